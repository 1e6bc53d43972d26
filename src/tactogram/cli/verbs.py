"""What each verb does: calls a job and prints its result. Nothing heavy is imported before a verb is chosen."""

from __future__ import annotations

from typing import Any

from tactogram.cli.printing import (
    Arguments,
    accuracies,
    columns,
    lines_of,
    print_result,
    ratings_text,
    shortened,
    text_of,
)


def demo(a: Arguments) -> None:
    """Simulate, classify, search and give a voice to surfaces; leaves a report."""
    from tactogram.jobs.demo import demo
    from tactogram.jobs.progress import shown

    with shown() as progress:
        result = demo(a.out, seed=a.seed, progress=progress)
    print_result(a, result, f"report: {result['report']}")


def doctor(a: Arguments) -> None:
    """Say what is installed, what is missing and what for, and which device is used."""
    from tactogram.jobs.doctor import doctor

    facts = doctor()
    lines = [f"tactogram {facts['tactogram']}, Python {facts['python']}, {facts['platform']}"]
    lines.append(
        f"device {facts['device']}, {facts['cores']} cores, {facts['threads']} threads, "
        f"{facts['memory_gib']} GiB memory"
    )
    lines += [f"  {name} {version or 'MISSING'}" for name, version in facts["packages"].items()]
    for name, extra in facts["extras"].items():
        state = f"missing {', '.join(extra['missing'])}" if extra["missing"] else "installed"
        lines.append(f"extra {name} ({extra['for']}): {state}")
    lines += [f"! {problem}" for problem in facts["problems"]] or ["no problems found"]
    print_result(a, facts, "\n".join(lines))


def data_list(a: Arguments) -> None:
    """List what can be imported and simulated."""
    from tactogram.jobs.data import list_sets

    facts = list_sets()
    rows = [(name, s["title"], s["licence"]) for name, s in facts["import"].items()]
    text = "import:\n" + columns(rows)
    text += "\nsimulate:\n" + columns(list(facts["simulate"].items()))
    print_result(a, facts, text)


def data_import(a: Arguments) -> None:
    """Import a data set into a store."""
    from tactogram.jobs.data import import_store
    from tactogram.jobs.progress import shown
    from tactogram.recipe import parse_changes

    options = parse_changes(a.options)
    with shown() as progress:
        report = import_store(
            a.set,
            a.path,
            a.out,
            options=options,
            skip_bad=a.skip_bad,
            workers=a.workers,
            progress=progress,
        )
    print_result(a, report, lines_of(report))


def data_simulate(a: Arguments) -> None:
    """Make a data set of simulated surfaces."""
    from tactogram.jobs.progress import shown
    from tactogram.jobs.simulate import simulate_to_store

    options = {
        "per_class": a.per_class,
        "rate": a.rate,
        "seconds": a.seconds,
        "raters": a.raters,
        "workers": a.workers,
    }
    if a.photographs is not None:
        options["photographs"] = a.photographs
    with shown() as progress:
        report = simulate_to_store(a.set, a.out, seed=a.seed, progress=progress, **options)
    print_result(a, report, lines_of(report))


def data_info(a: Arguments) -> None:
    """Say what a store holds."""
    from tactogram.jobs.data import store_info

    facts = store_info(a.path)
    ratings = facts["ratings"]
    text = lines_of({name: shortened(value) for name, value in facts.items() if name != "ratings"})
    print_result(a, facts, text if ratings is None else f"{text}\n{ratings_text(ratings)}")


def data_rate(a: Arguments) -> None:
    """Put tables of ratings into a store."""
    from tactogram.jobs.rating_tables import rate_store
    from tactogram.recipe import parse_changes

    facts = rate_store(a.path, a.files, scale=a.scale, settings=parse_changes(a.options), replace=a.replace)
    print_result(a, facts, lines_of({name: shortened(value) for name, value in facts.items()}))


def data_check(a: Arguments) -> int:
    """Read every shard of a store and compare it with its hash."""
    from tactogram.jobs.data import check_store

    facts = check_store(a.path)
    print_result(a, facts, lines_of(facts))
    return 0 if facts["ok"] else 1


def data_add(a: Arguments) -> None:
    """Put a recording into a store."""
    from tactogram.jobs.data import add_signal

    facts = add_signal(
        a.path,
        a.file,
        material=a.material,
        stream=a.stream,
        speed_mm_s=a.speed,
        force_n=a.force,
        **_signal_arguments(a),
    )
    print_result(a, facts, lines_of(facts))


def models(a: Arguments) -> None:
    """List the models."""
    from tactogram.models import available

    found = {
        name: m.model_dump(mode="json", exclude={"folder", "package", "name"})
        | {"recipes": list(m.recipes())}
        for name, m in available(a.models).items()
    }
    rows = [
        (name, str(m["year"]), f"{'+'.join(m['needs']) or '-'} -> {m['gives']}", m["title"])
        for name, m in found.items()
    ]
    print_result(a, found, columns(rows))


def train(a: Arguments) -> None:
    """Train a model on a data set."""
    from tactogram.jobs.progress import shown
    from tactogram.jobs.training import train

    with shown() as progress:
        run = train(
            a.model,
            a.data,
            **_training_arguments(a),
            out=a.out,
            resume=a.resume,
            devices=a.devices,
            progress=progress,
        )
    facts = run.facts()
    result = {"run": str(run.folder), "run_id": run.data["run_id"], "validation": facts["validation"]}
    shown_values = ", ".join(f"{name} {value:.3f}" for name, value in facts["validation"].items())
    print_result(a, result, f"run: {run.folder}" + (f"\nvalidation: {shown_values}" if shown_values else ""))


def crossval(a: Arguments) -> None:
    """Cross-validate a classifier, by recording, or a predictor of ratings, by item or rater."""
    from tactogram.jobs.crossval import crossval
    from tactogram.jobs.progress import shown
    from tactogram.models import find

    if find(a.model, a.models).task == "prediction":
        _crossval_ratings(a)
        return
    with shown() as progress:
        result = crossval(
            a.model,
            a.data,
            **_training_arguments(a),
            folds=a.folds,
            only_folds=a.only_folds,
            out=a.out,
            progress=progress,
        )
    print_result(a, result, f"{accuracies(result)}\nsplit: {result['split']}\nreport: {result['report']}")


def evaluate(a: Arguments) -> None:
    """Judge a run on recordings that it was not trained on."""
    from tactogram.jobs.evaluate import evaluate
    from tactogram.jobs.judges import Judging
    from tactogram.jobs.progress import shown
    from tactogram.recipe import parse_changes
    from tactogram.validation import validated

    judging = validated(Judging, parse_changes(a.judging, option="--judging"), where="--judging")
    with shown() as progress:
        result = evaluate(
            a.run_folder, data=a.data, unknown=a.unknown, judging=judging, rater=a.rater, progress=progress
        )
    if "window_accuracy" in result:
        lines = [accuracies(result)]
    elif "per_word" in result:
        lines = [_words_text(result)]
    elif "spread" in result:
        lines = _images_lines(result)
    elif "told_by" in result:
        lines = [f"mean absolute error to the surfaces' scores, told by {result['told_by']}"]
        lines += [
            f"{name}: {text_of(row['mae'])} (of {row['targets']} surfaces)"
            for name, row in result["conditions"].items()
        ]
        lines += [f"{name}: {text_of(value)}" for name, value in result["beside"].items()]
        lines += [f"{item}: {why}" for item, why in result["failed"].items()]
    else:
        lines = [
            f"{measure}: " + ", ".join(f"{column} {text_of(value)}" for column, value in row.items())
            for measure, row in result.get("measures", {}).items()
        ]
        published = result.get("as_published") or {}
        alone = result.get("pictures", {}).get("values", {}) | published.get("mean", {})
        lines += [f"{name}: {text_of(value)}" for name, value in alone.items()]
        lines += [result["as_published_missing"]] if "as_published_missing" in result else []
    print_result(a, result, "\n".join([*lines, f"report: {result['report']}"]))


def _images_lines(result: Any) -> list[str]:
    """Return what a generator's images differ by, and how far they follow their labels, as lines."""
    spread = result["spread"]
    lines = [
        f"two images differ by {spread['noise_spread']:.3g} (one label, other noise) and "
        f"{spread['label_spread']:.3g} (one noise, other label); two real ones by {spread['real_spread']:.3g}",
        f"collapsed: {result['collapse'] or 'no'}",
    ]
    if "following" in result:
        told = result["following"]
        lines.append(
            f"follows its label, told by {result['told_by']}: correlation {told['correlation']:.2f}, slope "
            f"{told['slope']:.2f}, error {told['error']:.3f}, to other labels {told['error_of_others']:.3f} (of 1)"
        )
    else:
        lines.append("whether images follow their label: give --rater RUN, a rater trained on rated images")
    return [*lines, f"judged on: {result['data']['split']}"]


def generate(a: Arguments) -> None:
    """Make signals or images with a trained generator, or both from the same words with two."""
    from pathlib import Path

    from tactogram.errors import ParameterError
    from tactogram.jobs.asked_words import goes_by_words
    from tactogram.jobs.generate import generate_files, parse_mix
    from tactogram.jobs.training import load_run

    runs = [load_run(folder) for folder in a.run_folders]
    by_words = {"words": a.words, "rest": a.rest, "like": a.like, "vibration": a.vibration, "rater": a.rater}
    if len(runs) > 1 or any(by_words.values()) or goes_by_words(runs[0]):
        for name in ("material", "mix", "image", "speed", "force"):
            if getattr(a, name) is not None:
                raise ParameterError(f"--{name} is not for models that go by words")
        _generate_from_words(a, runs)
        return
    material = {a.material: 1.0} if a.material else parse_mix(a.mix) if a.mix else None
    condition = {"material": material, "speed_mm_s": a.speed, "force_n": a.force}
    condition = {name: value for name, value in condition.items() if value is not None}
    written = generate_files(
        runs[0],
        condition,
        Path(a.out),
        seconds=a.seconds,
        seed=a.seed,
        count=a.count,
        photograph=a.image,
    )
    seen = written[0]
    lines = [row["file"] for row in written]
    if "taken_for" in seen:
        sure = f", confidence {seen['confidence']:.2f}" if "confidence" in seen else ""
        lines.append(f"photograph taken for {seen['taken_for']}{sure}")
    if "differ_by" in seen:
        lines.append(f"they differ by {seen['differ_by']}")
    print_result(a, {"files": written}, "\n".join(lines))


def _generate_from_words(a: Arguments, runs: list[Any]) -> None:
    from pathlib import Path

    from tactogram.jobs.from_words import generate_from_words
    from tactogram.jobs.generate import parse_words

    result = generate_from_words(
        runs,
        Path(a.out),
        words=parse_words(a.words) if a.words else None,
        rest=a.rest,
        like=a.like,
        vibration=a.vibration,
        raters=a.rater,
        seconds=a.seconds,
        seed=a.seed,
        count=a.count,
    )
    note = result["scores"][0]
    lines = [row["file"] for row in result["files"]]
    lines.append(f"asked: {text_of(note['asked']) or 'nothing'}")
    if note["filled"]:
        lines.append(f"filled with the {note['filled_from']}: {text_of(note['filled'])}")
    for each in result["scores"]:
        number = f" {each['number']}" if len(result["scores"]) > 1 else ""
        lines += [
            f"taken for the {what}{number}: {text_of(facts['taken'])}"
            for what, facts in each["made"].items()
            if "taken" in facts
        ]
        lines += [
            f"{what}{number} scored by {said['by']}: {text_of(said['scores'])}"
            for what, said in each.get("predicted", {}).items()
        ]
    if note["simulated"]:
        lines.append("learned from simulated data")
    print_result(a, result, "\n".join(lines))


def mix(a: Arguments) -> None:
    """Mix two materials step by step, and measure where each step lies between them."""
    from pathlib import Path

    from tactogram.jobs.mixing import mixing_ladder
    from tactogram.jobs.progress import shown

    condition = {"speed_mm_s": a.speed, "force_n": a.force}
    with shown() as progress:
        result = mixing_ladder(
            a.run_folder,
            a.start,
            a.end,
            steps=a.steps,
            signals=a.signals,
            mode=a.mode,
            seconds=a.seconds,
            seed=a.seed,
            condition={name: value for name, value in condition.items() if value is not None},
            out=Path(a.out) if a.out else None,
            progress=progress,
        )
    print_result(a, result, f"{result['in_words']}\nfigure: {result['figure']}")


def classify(a: Arguments) -> None:
    """Name the material of recordings."""
    from tactogram.jobs.classify import classify
    from tactogram.jobs.training import load_run
    from tactogram.signal.io import read_signal

    loaded = load_run(a.run_folder)
    results = {file: classify(loaded, read_signal(file, **_signal_arguments(a))) for file in a.files}
    rows = [
        (file, r["material"], f"{r['probability']:.3f}", "none of these?" if r["none_of_these"] else "")
        for file, r in results.items()
    ]
    print_result(a, {"files": results}, columns(rows))


def score(a: Arguments) -> None:
    """Score recordings, generated signals or images in sensory words, as a rater model has it."""
    from tactogram.jobs.score import score_file
    from tactogram.jobs.training import load_run

    loaded = load_run(a.run_folder, model_folders=a.models)
    results = {file: score_file(loaded, file, **_signal_arguments(a)) for file in a.files}
    first = next(iter(results.values()))
    rows = [("file", *first["scores"], "novel")]
    rows += [
        (file, *(f"{value:.2f}" for value in r["scores"].values()), text_of(r["novelty"]))
        for file, r in results.items()
    ]
    low, high = first["scale"]
    head = f"predicted by a {first['predicted_by']}, scale {low:g} to {high:g}"
    print_result(a, {"files": results}, f"{head}\n{columns(rows)}")


def search(a: Arguments) -> None:
    """Find what is most like a recording, or say that nothing is."""
    from tactogram.jobs.search import search
    from tactogram.signal.io import read_signal

    signal = read_signal(a.file, **_signal_arguments(a))
    result = search(a.run_folder, signal, data=a.data, count=a.count)
    verdict = "none of these" if result["none_of_these"] else "known"
    rows = [(f["material"], f"{f['distance']:.4f}", f["id"]) for f in result["nearest"]]
    head = f"{verdict}: nearest at {result['distance']:.4f}, threshold {result['threshold']:.4f}"
    print_result(a, result, head + "\n" + columns(rows))


def convert(a: Arguments) -> None:
    """Convert a signal from one file format to another."""
    from tactogram.jobs.convert import convert

    facts = convert(
        a.source,
        a.target,
        **_signal_arguments(a),
        columns=a.columns.split(",") if a.columns else None,
        time=a.time,
        sheet=a.sheet,
        full_scale=a.full_scale,
        play_at=a.play_at,
        resample_to=a.resample,
        subtype=a.subtype,
    )
    print_result(a, facts, lines_of(facts))


def run_export(a: Arguments) -> None:
    """Pack a run into one .zip file."""
    from tactogram.jobs.exchange import export_run

    print_result(a, facts := export_run(a.source, a.out), lines_of(facts))


def run_import(a: Arguments) -> None:
    """Unpack a run from a .zip file."""
    from tactogram.jobs.exchange import import_run

    print_result(a, facts := import_run(a.source, a.out), lines_of(facts))


def reproduce(a: Arguments) -> None:
    """Run the experiment behind a published table or figure."""
    from tactogram.jobs.progress import shown
    from tactogram.jobs.reproduce import experiments, reproduce
    from tactogram.recipe import parse_changes

    if a.list or a.experiment is None:
        found = experiments()
        print_result(a, found, columns(list(found.items())))
        return
    with shown() as progress:
        result = reproduce(
            a.experiment, recipe=a.recipe, out=a.out, options=parse_changes(a.set), progress=progress
        )
    print_result(a, result, result["text"])


def table(a: Arguments) -> None:
    """Show every model's published results beside ours."""
    from tactogram.jobs.table import table

    rows = table()
    shown_rows = [
        (r["model"], r["what"], text_of(r["published"]), text_of(r["ours"]), r["data"]) for r in rows
    ]
    print_result(
        a, {"rows": rows}, columns([("model", "what", "published", "ours", "our data"), *shown_rows])
    )


def _crossval_ratings(a: Arguments) -> None:
    from tactogram.errors import ParameterError
    from tactogram.jobs.progress import shown
    from tactogram.jobs.rating_crossval import crossval_ratings

    if a.split or a.only_folds:
        raise ParameterError(
            "--split and --only-folds are of classifiers; a predictor takes --folds and --repeats"
        )
    taken = ("by", "where", "recipe", "changes", "accelerator", "model_folders")
    arguments = {name: value for name, value in _training_arguments(a).items() if name in taken}
    with shown() as progress:
        result = crossval_ratings(
            a.model, a.data, **arguments, folds=a.folds, repeats=a.repeats, out=a.out, progress=progress
        )
    of = " of simulated raters" if result["data"]["simulated"] else ""
    head = f"mean absolute error{of}, points of a scale of {result['scale'][0]:g} to {result['scale'][1]:g}"
    print_result(
        a, result, f"{head}\n{_words_text(result)}\nsplit: {result['split']}\nreport: {result['report']}"
    )


def _words_text(result: dict[str, Any]) -> str:
    from tactogram.jobs.rating_crossval import COLUMNS

    rows = [("word", *COLUMNS.values())]
    rows += [
        (word, *(text_of(row[name]) for name in COLUMNS))
        for word, row in (*result["per_word"].items(), ("mean", result["mean"]))
    ]
    return columns(rows)


def _training_arguments(a: Arguments) -> dict[str, Any]:
    from pathlib import Path

    from tactogram.errors import ParameterError
    from tactogram.recipe import parse_changes

    changes = parse_changes(a.set)
    if a.band:
        changes["prepare.band"] = list(a.band)
    where = {}
    for text in a.where:
        key, sign, value = text.partition("=")
        if not sign:
            raise ParameterError(f"--where needs KEY=VALUE, got {text!r}")
        where[key] = value
    return {
        "recipe": a.recipe,
        "changes": changes,
        "split": a.split,
        "by": a.by,
        "label": a.label,
        "where": where,
        "accelerator": a.accelerator,
        "model_folders": [Path(folder) for folder in a.models],
    }


def _signal_arguments(a: Arguments) -> dict[str, Any]:
    axes = tuple(name.strip() for name in a.axes.split(",")) if a.axes else None
    return {"unit": a.unit, "rate": a.rate, "axes": axes}

"""Verbs that train and evaluate models, and pack runs."""

from __future__ import annotations

from typing import Any

from tactogram.cli.options import Verbs, models_option, training_arguments, training_options
from tactogram.cli.printing import Arguments, accuracies, columns, lines_of, print_result, text_of
from tactogram.cli.stopping import catch_stop_signals


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("train", train)
    add("model", metavar="MODEL", nargs="?", help="omit with --resume RUN")
    training_options(add, data_required=False)
    add("--out", metavar="RUN", help="the run's folder (default runs/MODEL-RECIPE-ID)")
    add(
        "--resume",
        nargs="?",
        const="",
        metavar="RUN",
        help="continue RUN with its own settings; without RUN, the run in --out if its settings are the same",
    )
    add("--devices", type=int, default=1, help="number of GPUs (default %(default)s)")

    add = verbs.add("crossval", crossval)
    add("model", metavar="MODEL")
    training_options(add, more_by="; for a predictor of ratings: item, rater or both")
    add("--folds", type=int, default=10, help="default %(default)s")
    add("--only-folds", type=int, metavar="N", help="run only the first N of them")
    add("--repeats", type=int, default=3, help="for a predictor of ratings: how often folds are redrawn")
    add("--out", metavar="DIR", help="folder for figures and report (default under runs)")

    add = verbs.add("evaluate", evaluate)
    add("run_folder", metavar="RUN")
    models_option(add)
    add("--data", metavar="DIR", help="data set to evaluate on (default: the run's own test part)")
    add("--unknown", action="store_true", help="also use the materials that were left out of training")
    add(
        "--judging",
        action="append",
        metavar="KEY=VALUE",
        default=[],
        help="for a generator: steps, window_s, longest_s, most or seed of the reference models",
    )
    add("--rater", metavar="RUN", help="for a generator conditioned on words: the rater model that scores it")

    verbs = verbs.group("run", "pack a run into one file, or unpack one")
    add = verbs.add("export", run_export)
    add("source", metavar="RUN")
    add("--out", required=True, metavar="FILE")
    add = verbs.add("import", run_import)
    add("source", metavar="FILE")
    add("--out", required=True, metavar="RUN")


def train(a: Arguments) -> None:
    """Train a model on a data set, or continue a run."""
    from tactogram.workflows.progress import shown
    from tactogram.workflows.training.resume import resume
    from tactogram.workflows.training.train import train

    taken = training_arguments(a)
    machine = {"accelerator": taken["accelerator"], "devices": a.devices}
    if a.resume:
        _only_resumes(a)
    elif not (a.model and a.data):
        a.usage_error("needs MODEL and --data DIR, or --resume RUN to go on with a run")
    with catch_stop_signals() as stop, shown() as progress:
        if a.resume:
            folders = taken["model_folders"]
            run = resume(
                a.resume, data=a.data, model_folders=folders, progress=progress, stop=stop, **machine
            )
        else:
            more = {"out": a.out, "resume": a.resume is not None}
            run = train(a.model, a.data, **taken | machine | more, progress=progress, stop=stop)
    facts = run.facts()
    validation, notes = facts["validation"], facts.get("notes", [])
    result = {"run": str(run.folder), "run_id": run.data["run_id"], "validation": validation, "notes": notes}
    lines = [f"run: {run.folder}"]
    if validation:
        lines.append("validation: " + ", ".join(f"{name} {value:.3f}" for name, value in validation.items()))
    print_result(a, result, "\n".join([*lines, *(f"note: {note}" for note in notes)]))


def _only_resumes(a: Arguments) -> None:
    """Refuse what a run that goes on has said already."""
    said = {"MODEL": a.model, "--out": a.out, "--set": a.set, "--band": a.band, "--where": a.where}
    said |= {"--split": a.split, "--recipe": a.recipe != "quick", "--by": a.by != "recording"}
    said |= {"--label": a.label != "material"}
    if given := [name for name, value in said.items() if value]:
        a.usage_error(
            f"--resume {a.resume} continues the run with its own settings: omit {', '.join(given)}, or start another "
            "run with --out"
        )


def crossval(a: Arguments) -> None:
    """Cross-validate a classifier, by recording, or a predictor of ratings, by item or rater."""
    from tactogram.models import find
    from tactogram.workflows.evaluation.crossval import crossval
    from tactogram.workflows.progress import shown

    if find(a.model, a.models).task == "prediction":
        _crossval_ratings(a)
        return
    with shown() as progress:
        result = crossval(
            a.model,
            a.data,
            **training_arguments(a),
            folds=a.folds,
            only_folds=a.only_folds,
            out=a.out,
            progress=progress,
        )
    print_result(a, result, f"{accuracies(result)}\nsplit: {result['split']}\nreport: {result['report']}")


def evaluate(a: Arguments) -> None:
    """Evaluate a run on recordings that it was not trained on."""
    from tactogram.recipe import parse_changes
    from tactogram.validation import validated
    from tactogram.workflows.evaluation.evaluate import evaluate
    from tactogram.workflows.evaluation.reference_models import EvaluationSettings
    from tactogram.workflows.progress import shown

    judging = validated(EvaluationSettings, parse_changes(a.judging, option="--judging"), where="--judging")
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
        lines = [f"mean absolute error to the surfaces' scores, rated by {result['told_by']}"]
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


def run_export(a: Arguments) -> None:
    """Pack a run into one .zip file."""
    from tactogram.workflows.training.run_archive import export_run

    print_result(a, facts := export_run(a.source, a.out), lines_of(facts))


def run_import(a: Arguments) -> None:
    """Unpack a run from a .zip file."""
    from tactogram.workflows.training.run_archive import import_run

    print_result(a, facts := import_run(a.source, a.out), lines_of(facts))


def _images_lines(result: Any) -> list[str]:
    """Return the spread and the label fidelity of a generator's images, as lines."""
    lines = []
    if spread := result["spread"]:
        lines = [
            f"two images differ by {spread['noise_spread']:.3g} (same label, other noise) and "
            f"{spread['label_spread']:.3g} (same noise, other label); two real ones by {spread['real_spread']:.3g}",
            f"collapsed: {result['collapse'] or 'no'}",
        ]
    if "following" in result:
        told = result["following"]
        lines.append(
            f"label fidelity, scored by {result['told_by']}: correlation {told['correlation']:.2f}, slope "
            f"{told['slope']:.2f}, error {told['error']:.3f}, to other labels {told['error_of_others']:.3f} (of 1)"
        )
    else:
        lines.append("for label fidelity give --rater RUN, a rater model trained on rated images")
    return [*lines, f"evaluated on: {result['data']['split']}"]


def _crossval_ratings(a: Arguments) -> None:
    from tactogram.errors import ParameterError
    from tactogram.workflows.evaluation.rating_crossval import crossval_ratings
    from tactogram.workflows.progress import shown

    if a.split or a.only_folds:
        raise ParameterError(
            "--split and --only-folds are for classifiers; a predictor takes --folds and --repeats"
        )
    taken = ("by", "where", "recipe", "changes", "accelerator", "model_folders")
    arguments = {name: value for name, value in training_arguments(a).items() if name in taken}
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
    from tactogram.workflows.evaluation.rating_crossval import COLUMNS

    rows = [("word", *COLUMNS.values())]
    rows += [
        (word, *(text_of(row[name]) for name in COLUMNS))
        for word, row in (*result["per_word"].items(), ("mean", result["mean"]))
    ]
    return columns(rows)

"""The command line: ``tactogram VERB``. Nothing heavy is imported before a verb is chosen."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

# torch's threads spin when they wait, and collapse when a core is busy. Read when torch is imported.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

Arguments = argparse.Namespace
Add = Callable[..., Any]


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb; return 0, or 1 after a line on stderr where something was wrong.

    Usage errors exit with 2, as argparse does.
    """
    arguments = _parser().parse_args(argv)
    from tactogram.errors import TactogramError

    if folders := getattr(arguments, "models", None):
        # Whatever loads a run finds them: a run names its model, not where it lies.
        known = os.environ.get("TACTOGRAM_MODELS")
        os.environ["TACTOGRAM_MODELS"] = os.pathsep.join([*folders, *([known] if known else [])])
    try:
        return arguments.run(arguments) or 0
    except TactogramError as error:
        sys.stderr.write(f"tactogram: {error}\n")
        return 1
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        # No permission, no space, a file where a folder is needed: the system's words say enough.
        sys.stderr.write(f"tactogram: {error}\n")
        return 1
    except KeyboardInterrupt:
        sys.stderr.write("tactogram: interrupted\n")
        return 130


# -- the verbs: what each takes ------------------------------------------------------------------------------


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="tactogram",
        description="Learn, generate, judge and render touch.",
        epilog="Results are on stdout, progress on stderr. `tactogram VERB --help` says what a verb takes.",
    )
    parser.add_argument("--version", action=_Version, help="show the version and exit")
    verbs = parser.add_subparsers(metavar="VERB", required=True)

    def verb(name: str, run: Callable[[Arguments], int | None], text: str, *, has_json: bool = True) -> Add:
        sub = verbs.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        sub.set_defaults(run=run)
        if has_json:
            sub.add_argument("--json", action="store_true", help="print one JSON object")
        return cast(Add, sub.add_argument)

    add = verb("demo", _demo, "simulate, classify, search and give a voice to surfaces; leaves a report")
    add("--out", default="runs/demo", help="folder for everything it makes (default %(default)s)")
    add("--seed", type=int, default=0)

    verb("doctor", _doctor, "say what is installed, what is missing and what for, and which device is used")
    _data_verbs(verbs)

    add = verb("models", _models, "list the models")
    _models_option(add)

    add = verb("train", _train, "train a model on a data set")
    add("model", metavar="MODEL")
    _training_options(add)
    add("--out", metavar="RUN", help="the run's folder (default runs/MODEL-RECIPE-ID)")
    add("--resume", action="store_true", help="go on with the run in --out after an interruption")
    add("--devices", type=int, default=1, help="how many GPUs (default %(default)s)")

    add = verb("crossval", _crossval, "cross-validate a classifier, by recording")
    add("model", metavar="MODEL")
    _training_options(add)
    add("--folds", type=int, default=10, help="default %(default)s")
    add("--only-folds", type=int, metavar="N", help="run only the first N of them")
    add("--out", metavar="DIR", help="folder for figures and report (default under runs)")

    add = verb("evaluate", _evaluate, "judge a run on recordings that it was not trained on")
    add("run_folder", metavar="RUN")
    _models_option(add)
    add("--data", metavar="DIR", help="a data set to judge on (default: the run's own test part)")

    add("--unknown", action="store_true", help="add the materials that were left out of training")

    add = verb("generate", _generate, "make signals with a trained generator")
    add("run_folder", metavar="RUN")
    _models_option(add)
    what = verbs.choices["generate"].add_mutually_exclusive_group(required=True)
    what.add_argument("--material", metavar="NAME")
    what.add_argument("--mix", metavar="A=0.6,B=0.4", help="weights by material")
    add("--speed", type=float, metavar="MM_S", help="stroking speed, mm/s")
    add("--force", type=float, metavar="N", help="normal force, N")
    add("--seconds", type=float, help="length (default: the model's own)")
    add("--seed", type=int, default=0)
    add("--count", type=int, default=1, help="how many (default %(default)s)")
    add("--out", required=True, metavar="FILE", help=".wav, .flac, .csv, .tsv, .npz or .xlsx")

    add = verb("classify", _classify, "name the material of recordings")
    add("run_folder", metavar="RUN")
    add("files", metavar="FILE", nargs="+")
    _models_option(add)
    _signal_options(add)

    add = verb("search", _search, "find what is most like a recording, or say that nothing is")
    add("run_folder", metavar="RUN")
    add("file", metavar="FILE")
    add(
        "--data",
        metavar="DIR",
        help="a data set to search in, added recordings too (default: what was trained on)",
    )
    add("--count", type=int, default=5, help="how many to show (default %(default)s)")
    _models_option(add)
    _signal_options(add)

    add = verb("convert", _convert, "convert a signal from one file format to another")
    add("source", metavar="A")
    add("target", metavar="B")
    _signal_options(add)
    add("--columns", help="columns to read from a table, e.g. ax,ay,az")
    add("--time", metavar="COLUMN", help="the table's column of time stamps")
    add("--sheet", help="the sheet of an .xlsx file")
    add("--full-scale", type=float, metavar="X", help="what integer full scale means, in the unit")
    add("--resample", type=float, metavar="HZ", help="rate of B")
    add("--subtype", help="sample format of B, e.g. PCM_16, PCM_24, FLOAT")

    run_verbs = verbs.add_parser("run", help="pack a run into one file, or unpack one").add_subparsers(
        metavar="export|import", required=True
    )
    for name, text, function in (
        ("export", "pack a run into one .zip file", _run_export),
        ("import", "unpack a run from a .zip file", _run_import),
    ):
        sub = run_verbs.add_parser(name, help=text, description=text)
        sub.add_argument("source", metavar="RUN" if name == "export" else "FILE")
        sub.add_argument("--out", required=True, metavar="FILE" if name == "export" else "RUN")
        sub.add_argument("--json", action="store_true", help="print one JSON object")
        sub.set_defaults(run=function)

    add = verb("reproduce", _reproduce, "run the experiment behind a published table or figure")
    add("experiment", metavar="EXPERIMENT", nargs="?")
    add("--list", action="store_true", help="list the experiments")
    add("--recipe", default="bench", help="bench (hours at most on 2 cores) or paper (default %(default)s)")
    add("--out", metavar="DIR", help="folder for its results (default runs/EXPERIMENT)")

    verb("table", _table, "show every model's published results beside ours")
    return parser


def _data_verbs(verbs: Any) -> None:
    data = verbs.add_parser("data", help="import, simulate, look at and check data sets").add_subparsers(
        metavar="list|import|simulate|info|check|add", required=True
    )

    def verb(name: str, run: Callable[[Arguments], int | None], text: str) -> Add:
        sub: argparse.ArgumentParser = data.add_parser(
            name, help=text, description=text[0].upper() + text[1:] + "."
        )
        sub.set_defaults(run=run)
        sub.add_argument("--json", action="store_true", help="print one JSON object")
        return sub.add_argument

    verb("list", _data_list, "list what can be imported and simulated")
    add = verb("import", _data_import, "import a data set into a store")
    add("set", metavar="SET", help="one of `tactogram data list`; `folder` for MATERIAL/*.wav and the like")
    add("path", metavar="PATH")
    add("--out", required=True, metavar="DIR")
    add("--skip-bad", action="store_true", help="report broken files and go on without them")
    add("--workers", type=int, help="processes (default: all cores)")
    add = verb("simulate", _data_simulate, "make a data set of simulated surfaces")
    add("set", metavar="SET")
    add("--out", required=True, metavar="DIR")
    add("--seed", type=int, default=0)
    add("--per-class", type=int, metavar="N", help="recordings per class")
    add("--rate", type=float, metavar="HZ")
    add("--seconds", type=float, help="length of a recording")
    add("--workers", type=int, help="processes (default: all cores)")
    for name, function, text in (
        ("info", _data_info, "say what a store holds"),
        ("check", _data_check, "read every shard of a store and compare it with its hash"),
    ):
        verb(name, function, text)("path", metavar="DIR")
    add = verb("add", _data_add, "put a recording into a store")
    add("path", metavar="DIR")
    add("file", metavar="FILE")
    add("--material", required=True, metavar="NAME")
    add("--stream", default=None, help="what it is (default: the store's only stream)")
    add("--speed", type=float, metavar="MM_S", help="stroking speed, mm/s")
    add("--force", type=float, metavar="N", help="normal force, N")
    _signal_options(add)


def _models_option(add: Add) -> None:
    add("--models", action="append", default=[], metavar="DIR", help="a folder with further models")


def _training_options(add: Add) -> None:
    add("--data", required=True, metavar="DIR", help="a store made by `data import` or `data simulate`")
    add(
        "--recipe",
        default="quick",
        metavar="NAME|FILE",
        help="paper, quick, tiny or a TOML file (default quick)",
    )
    add("--set", action="append", default=[], metavar="KEY=VALUE", help="change a value of the recipe")
    add("--band", type=float, nargs=2, metavar=("LO", "HI"), help="pass band in Hz; as --set prepare.band=…")
    add("--split", default="", metavar="last=N|all", help="keep the last N recordings of a class for testing")
    add("--by", default="recording", help="recording, session, subject or condition: never on two sides")
    add(
        "--label",
        default="material",
        help="what makes a class, e.g. material+contactor (default %(default)s)",
    )
    add("--where", action="append", default=[], metavar="KEY=VALUE", help="only recordings that have it")
    add("--accelerator", default="auto", help="auto, cpu, cuda or mps (default %(default)s)")
    _models_option(add)


def _signal_options(add: Add) -> None:
    add("--unit", help="unit of the samples, where the file does not say: m/s^2, m/s, m, N, V or 1")
    add("--rate", type=float, metavar="HZ", help="sampling rate, where the file does not say")
    add("--axes", help="names of the columns or channels to read, e.g. x,y,z")


# -- what each does ------------------------------------------------------------------------------------------


def _demo(a: Arguments) -> None:
    from tactogram.jobs.demo import demo
    from tactogram.jobs.progress import shown

    with shown() as progress:
        result = demo(a.out, seed=a.seed, progress=progress)
    _print(a, result, f"report: {result['report']}")


def _doctor(a: Arguments) -> None:
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
    _print(a, facts, "\n".join(lines))


def _data_list(a: Arguments) -> None:
    from tactogram.jobs.data import list_sets

    facts = list_sets()
    rows = [(name, s["title"], s["licence"]) for name, s in facts["import"].items()]
    text = "import:\n" + _columns(rows)
    text += "\nsimulate:\n" + _columns(list(facts["simulate"].items()))
    _print(a, facts, text)


def _data_import(a: Arguments) -> None:
    from tactogram.jobs.data import import_store
    from tactogram.jobs.progress import shown

    with shown() as progress:
        report = import_store(a.set, a.path, a.out, skip_bad=a.skip_bad, workers=a.workers, progress=progress)
    _print(a, report, _lines(report))


def _data_simulate(a: Arguments) -> None:
    from tactogram.jobs.progress import shown
    from tactogram.jobs.simulate import simulate_to_store

    options = {"per_class": a.per_class, "rate": a.rate, "seconds": a.seconds, "workers": a.workers}
    with shown() as progress:
        report = simulate_to_store(a.set, a.out, seed=a.seed, progress=progress, **options)
    _print(a, report, _lines(report))


def _data_info(a: Arguments) -> None:
    from tactogram.jobs.data import store_info

    facts = store_info(a.path)
    _print(a, facts, _lines(facts))


def _data_check(a: Arguments) -> int:
    from tactogram.jobs.data import check_store

    facts = check_store(a.path)
    _print(a, facts, _lines(facts))
    return 0 if facts["ok"] else 1


def _data_add(a: Arguments) -> None:
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
    _print(a, facts, _lines(facts))


def _models(a: Arguments) -> None:
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
    _print(a, found, _columns(rows))


def _train(a: Arguments) -> None:
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
    _print(a, result, f"run: {run.folder}" + (f"\nvalidation: {shown_values}" if shown_values else ""))


def _crossval(a: Arguments) -> None:
    from tactogram.jobs.crossval import crossval
    from tactogram.jobs.progress import shown

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
    _print(a, result, f"{_accuracies(result)}\nsplit: {result['split']}\nreport: {result['report']}")


def _evaluate(a: Arguments) -> None:
    from tactogram.jobs.evaluate import evaluate
    from tactogram.jobs.progress import shown

    with shown() as progress:
        result = evaluate(a.run_folder, data=a.data, unknown=a.unknown, progress=progress)
    if "measures" in result:
        lines = [
            f"{measure}: " + ", ".join(f"{column} {_text(value)}" for column, value in row.items())
            for measure, row in result["measures"].items()
        ]
    else:
        lines = [_accuracies(result)]
    _print(a, result, "\n".join([*lines, f"report: {result['report']}"]))


def _generate(a: Arguments) -> None:
    from pathlib import Path

    from tactogram.jobs.generate import generate_files, parse_mix

    material = {a.material: 1.0} if a.material else parse_mix(a.mix)
    condition = {"material": material, "speed_mm_s": a.speed, "force_n": a.force}
    condition = {name: value for name, value in condition.items() if value is not None}
    written = generate_files(
        a.run_folder, condition, Path(a.out), seconds=a.seconds, seed=a.seed, count=a.count
    )
    _print(a, {"files": written}, "\n".join(row["file"] for row in written))


def _classify(a: Arguments) -> None:
    from tactogram.jobs.classify import classify
    from tactogram.jobs.training import load_run
    from tactogram.signal.io import read_signal

    loaded = load_run(a.run_folder)
    results = {file: classify(loaded, read_signal(file, **_signal_arguments(a))) for file in a.files}
    rows = [
        (file, r["material"], f"{r['probability']:.3f}", "none of these?" if r["none_of_these"] else "")
        for file, r in results.items()
    ]
    _print(a, {"files": results}, _columns(rows))


def _search(a: Arguments) -> None:
    from tactogram.jobs.search import search
    from tactogram.signal.io import read_signal

    signal = read_signal(a.file, **_signal_arguments(a))
    result = search(a.run_folder, signal, data=a.data, count=a.count)
    verdict = "none of these" if result["none_of_these"] else "known"
    rows = [(f["material"], f"{f['distance']:.4f}", f["id"]) for f in result["nearest"]]
    head = f"{verdict}: nearest at {result['distance']:.4f}, threshold {result['threshold']:.4f}"
    _print(a, result, head + "\n" + _columns(rows))


def _convert(a: Arguments) -> None:
    from tactogram.jobs.convert import convert

    facts = convert(
        a.source,
        a.target,
        **_signal_arguments(a),
        columns=a.columns.split(",") if a.columns else None,
        time=a.time,
        sheet=a.sheet,
        full_scale=a.full_scale,
        resample_to=a.resample,
        subtype=a.subtype,
    )
    _print(a, facts, _lines(facts))


def _run_export(a: Arguments) -> None:
    from tactogram.jobs.exchange import export_run

    _print(a, facts := export_run(a.source, a.out), _lines(facts))


def _run_import(a: Arguments) -> None:
    from tactogram.jobs.exchange import import_run

    _print(a, facts := import_run(a.source, a.out), _lines(facts))


def _reproduce(a: Arguments) -> None:
    from tactogram.jobs.progress import shown
    from tactogram.jobs.reproduce import experiments, reproduce

    if a.list or a.experiment is None:
        found = experiments()
        _print(a, found, _columns(list(found.items())))
        return
    with shown() as progress:
        result = reproduce(a.experiment, recipe=a.recipe, out=a.out, progress=progress)
    _print(a, result, result["text"])


def _table(a: Arguments) -> None:
    from tactogram.jobs.table import table

    rows = table()
    shown_rows = [(r["model"], r["what"], _text(r["published"]), _text(r["ours"]), r["data"]) for r in rows]
    _print(a, {"rows": rows}, _columns([("model", "what", "published", "ours", "our data"), *shown_rows]))


# -- how results look ----------------------------------------------------------------------------------------


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


def _print(a: Arguments, result: Any, text: str) -> None:
    sys.stdout.write((json.dumps(result, ensure_ascii=False) if a.json else text) + "\n")


def _accuracies(result: Mapping[str, Any]) -> str:
    low, high = result["recording_accuracy_95"]
    return (
        f"recording accuracy {100 * result['recording_accuracy']:.1f} % (95 %: {100 * low:.1f}–{100 * high:.1f}) "
        f"of {result['recordings']}, window accuracy {100 * result['window_accuracy']:.1f} % of {result['windows']}"
    )


def _lines(facts: Mapping[str, Any]) -> str:
    return "\n".join(
        f"{name}: {_text(value)}" for name, value in facts.items() if value not in (None, [], {})
    )


def _text(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_text(inner)}" for name, inner in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(_text(inner) for inner in value)
    return str(value)


def _columns(rows: Sequence[Sequence[str]]) -> str:
    rows = [[str(cell) for cell in row] for row in rows]
    if not rows:
        return "none"
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join("  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in rows)


class _Version(argparse.Action):
    """Show the version without looking it up for every other command."""

    def __init__(self, option_strings: Sequence[str], dest: str, **kwargs: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **kwargs)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        sys.stdout.write(f"tactogram {version('tactogram')}\n")
        parser.exit()


if __name__ == "__main__":
    sys.exit(main())

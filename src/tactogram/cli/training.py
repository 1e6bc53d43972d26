"""Verbs that train and evaluate models, and pack runs."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from typing import Annotated, Any

from tactogram.cli.printing import Printer, accuracies, columns, lines_of, text_of
from tactogram.cli.stopping import catch_stop_signals
from tactogram.cli.verbs import UsageError, Verb
from tactogram.workflows.evaluation.requests import EvaluationRequest
from tactogram.workflows.request import SWEEP_ON, Argument, Option, Request
from tactogram.workflows.training.requests import (
    CrossvalRequest,
    ExportRequest,
    ProcessOptions,
    Purpose,
    TrainingRequest,
)


@dataclass(frozen=True)
class _TrainRequest(ProcessOptions):
    """A `TrainingRequest`, or a run to resume with its own settings."""

    model: Annotated[str | None, Argument("omit with --resume RUN or --for", "MODEL")] = None
    _: KW_ONLY
    data: Annotated[str | None, Option("store made by `data import` or `data simulate`", "DIR")] = None
    resume: Annotated[
        str | None,
        Option(
            "continue RUN with its own settings; without RUN, the run in --out if its settings are the same",
            "RUN",
            const="",
        ),
    ] = None
    purpose: Annotated[
        Purpose | None,
        Option(
            "instead of MODEL: the closest one to generate a material, or from photographs or words",
            flag="--for",
        ),
    ] = None
    sweep: Annotated[
        str | None,
        Option("train with values drawn from this space, and keep the best run; needs --out and Ray", "TOML"),
    ] = None
    on: Annotated[str, SWEEP_ON] = "ray"


@dataclass(frozen=True)
class _UnpackRequest(Request):
    source: Annotated[str, Argument("zip file, folder, or hf://OWNER/NAME of the Hub", "SOURCE")]
    out: Annotated[str, Option(metavar="RUN")]


@dataclass(frozen=True)
class _CompareRequest(Request):
    runs: Annotated[Sequence[str], Argument("folders of runs, two or more", "RUN")] = ()


def _train(request: _TrainRequest, show: Printer) -> None:
    from tactogram.datasets import open_store
    from tactogram.training.device import is_first_process
    from tactogram.workflows.training.model_choice import model_choice
    from tactogram.workflows.training.resume import resume
    from tactogram.workflows.training.train import train

    if request.resume:
        _refuse_settings(request)
    elif not request.data or bool(request.model) == bool(request.purpose):
        raise UsageError("needs --data DIR and MODEL or --for, or --resume RUN to continue a run")
    if request.purpose:
        model, recipe, why = model_choice(request.purpose, open_store(str(request.data)), label=request.label)
        show.notes([f"{model}: {why}"])
        own = request.recipe if request.recipe != _TrainRequest().recipe else recipe
        request = replace(request, model=model, recipe=own)
    if request.sweep:
        _sweep(request, show)
        return
    with catch_stop_signals() as stop, show.progress() as progress:
        values = vars(request) | {"progress": progress, "stop": stop}
        if request.resume:
            names = ("data", "accelerator", "devices", "logger", "model_folders", "progress", "stop")
            run = resume(request.resume, **{name: values[name] for name in names})
        else:
            values = {name: value for name, value in values.items() if name not in ("purpose", "sweep", "on")}
            run = train(**values | {"resume": request.resume is not None})
    if not is_first_process():
        return
    facts = run.facts()
    validation, notes = facts["validation"], facts["notes"]
    result = {"run": str(run.folder), "run_id": run.data["run_id"], "validation": validation, "notes": notes}
    lines = [f"run: {run.folder}"]
    if validation:
        lines.append("validation: " + ", ".join(f"{name} {value:.3f}" for name, value in validation.items()))
    show(result, "\n".join([*lines, *(f"note: {note}" for note in notes)]))


def _sweep(request: _TrainRequest, show: Printer) -> None:
    from tactogram.workflows.training.sweep import sweep

    if request.resume is not None:
        raise UsageError("--sweep goes on by itself with the same --out: omit --resume")
    with show.progress() as progress:
        values = vars(request) | {"progress": progress, "resume": False}
        of_training = {
            field.name: values[field.name] for field in fields(TrainingRequest) if field.name in values
        }
        result = sweep(TrainingRequest(**of_training), str(request.sweep), on=request.on)
    best = ", ".join(f"{key}={value}" for key, value in result["best"].items())
    show(result, f"run: {result['run']}\nbest of {len(result['trials'])}: {best}\nreport: {result['report']}")


def _refuse_settings(request: _TrainRequest) -> None:
    default = _TrainRequest()
    names = ("model", "purpose", "out", "changes", "band", "where", "split", "recipe", "by", "label")
    options = {"model": "MODEL", "purpose": "--for", "changes": "--set"}
    changed = [
        options.get(name, f"--{name}") for name in names if getattr(request, name) != getattr(default, name)
    ]
    if changed:
        raise UsageError(
            f"--resume {request.resume} continues the run with its own settings: omit {', '.join(changed)}, or start "
            "another run with --out"
        )


def _crossval(request: CrossvalRequest, show: Printer) -> None:
    from tactogram.models import find

    if find(request.model).task == "prediction":
        _crossval_ratings(request, show)
        return
    from tactogram.workflows.evaluation.crossval import crossval

    with show.progress() as progress:
        result = crossval(**vars(request) | {"progress": progress})
    show(result, f"{accuracies(result)}\nsplit: {result['split']}\nreport: {result['report']}")


def _evaluate(request: EvaluationRequest, show: Printer) -> None:
    from tactogram.workflows.evaluation.evaluate import evaluate

    with show.progress() as progress:
        result = evaluate(**vars(request) | {"progress": progress})
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
    show(result, "\n".join([*lines, f"report: {result['report']}"]))


def _export(request: ExportRequest, show: Printer) -> None:
    from tactogram.workflows.training.export import export

    with show.progress() as progress:
        facts = export(**vars(request) | {"progress": progress})
    show(facts, _networks_text(facts) if "networks" in facts else lines_of(facts))


def _networks_text(facts: dict[str, Any]) -> str:
    """Return the files of networks, with how far onnxruntime is from the package."""
    rows = [("network", "file", "KiB", "output", "largest difference")]
    for name, each in facts["networks"].items():
        for output, difference in each["difference"].items():
            rows.append((name, each["file"], f"{each['bytes'] / 1024:.0f}", output, f"{difference:.1g}"))
    return f"{columns(rows)}\nfolder: {facts['folder']}"


def _compare(request: _CompareRequest, show: Printer) -> None:
    from tactogram.workflows.training.run_comparison import compare_runs

    found = compare_runs(request.runs)
    rows = [("", *found["runs"])]
    for part in ("facts", "settings", "results"):
        rows += [(name, *map(text_of, values)) for name, values in found[part].items()]
    show(found, "\n".join([columns(rows), *(f"note: {note}" for note in found["notes"])]))


def _import(request: _UnpackRequest, show: Printer) -> None:
    from tactogram.workflows.training.hub_folder import import_from

    show(facts := import_from(request.source, request.out), lines_of(facts))


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
        fidelity = result["following"]
        lines.append(
            f"label fidelity, scored by {result['told_by']}: correlation {fidelity['correlation']:.2f}, slope "
            f"{fidelity['slope']:.2f}, error {fidelity['error']:.3f}, "
            f"to other labels {fidelity['error_of_others']:.3f} (of 1)"
        )
    else:
        lines.append("for label fidelity give --rater RUN, a rater model trained on rated images")
    return [*lines, f"evaluated on: {result['data']['split']}"]


def _crossval_ratings(request: CrossvalRequest, show: Printer) -> None:
    from tactogram.errors import ParameterError
    from tactogram.workflows.evaluation.rating_crossval import crossval_ratings

    if request.split or request.only_folds:
        raise ParameterError(
            "--split and --only-folds are for classifiers; a predictor takes --folds and --repeats"
        )
    with show.progress() as progress:
        result = crossval_ratings(**vars(request) | {"progress": progress})
    of = " of simulated raters" if result["data"]["simulated"] else ""
    head = f"mean absolute error{of}, points of a scale of {result['scale'][0]:g} to {result['scale'][1]:g}"
    show(result, f"{head}\n{_words_text(result)}\nsplit: {result['split']}\nreport: {result['report']}")


def _words_text(result: dict[str, Any]) -> str:
    from tactogram.workflows.evaluation.rating_crossval import COLUMNS

    rows = [("word", *COLUMNS.values())]
    rows += [
        (word, *(text_of(row[name]) for name in COLUMNS))
        for word, row in (*result["per_word"].items(), ("mean", result["mean"]))
    ]
    return columns(rows)


VERBS = {
    "train": Verb(_TrainRequest, _train),
    "crossval": Verb(CrossvalRequest, _crossval),
    "evaluate": Verb(EvaluationRequest, _evaluate, folders=("models",)),
    "compare": Verb(_CompareRequest, _compare),
    "run export": Verb(ExportRequest, _export),
    "run import": Verb(_UnpackRequest, _import),
}

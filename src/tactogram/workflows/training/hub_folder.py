"""Runs in the layout of the Hugging Face Hub: weights, configuration, card, and results where the Hub finds them.

The run's own files are beside them, so that nothing is lost on the way back. Paths of this machine are left out.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError, RunError
from tactogram.extras import imported
from tactogram.model import SignalKind
from tactogram.models import ModelInfo
from tactogram.signal.io.atomic import write_text
from tactogram.training.remote_run import open_run
from tactogram.training.run import Run
from tactogram.workflows import hub
from tactogram.workflows.evaluated_runs import evaluation_results
from tactogram.workflows.new_folder import new_folder
from tactogram.workflows.training import known_photographs
from tactogram.workflows.training.loaded_run import model_of
from tactogram.workflows.training.run_archive import check_foreign
from tactogram.workflows.training.surface_index import INDEX_FILES

NEEDED = ("recipe.toml", "data.json", "model.safetensors", "model.json")
OPTIONAL = (
    "environment.json",
    "split.json",
    "metrics.csv",
    *INDEX_FILES,
    known_photographs.FILE,
    "evaluation.json",
)
RESULTS = ".eval_results/tactogram.yaml"
"""Where the Hub looks for results."""
OF_THIS_MACHINE = {"data.json": ("path", "model_folders"), "evaluation.json": ("report",)}
TASKS = {
    "classification": "tactile-classification",
    "generation": "tactile-generation",
    "prediction": "tactile-rating",
}


def export_hub(run: Path | str, out: Path | str, *, push: str | None = None) -> dict[str, Any]:
    """Write a finished run into the new folder ``out``, and upload it as ``push`` if given; return what was done.

    Raises
    ------
    RunError
        If the run is not finished, ``out`` exists, or the upload fails.
    MissingExtraError
        If huggingface_hub is not installed.
    """
    hub.hub_library()
    found = open_run(run)
    found.facts()
    info = model_of(found)
    with new_folder(Path(out)) as folder:
        for name in (*NEEDED, *OPTIONAL):
            if (found.folder / name).is_file():
                _copy(found.folder / name, folder / name)
        copied = Run(folder)
        copied.write_json("config.json", _config(copied, info))
        write_text(folder / "README.md", _card(copied, info, found.name))
        _write_results(copied)
        files = sorted(path for path in folder.rglob("*") if path.is_file())
        facts = {"folder": str(out), "files": len(files), "bytes": sum(f.stat().st_size for f in files)}
    return facts | ({"pushed": hub.push(Path(out), push, kind="model")} if push else {})


def import_hub(folder: Path | str, out: Path | str) -> dict[str, Any]:
    """Put the run in a folder that `export_hub` wrote into the folder ``out``; return ``run`` and ``files``.

    Raises
    ------
    RunError
        If it is no such folder, or ``out`` exists.
    """
    source = Path(folder)
    for name in NEEDED:
        if not (source / name).is_file():
            raise RunError(f"{source}: not a run in the layout of the Hub: it has no {name}")
    with new_folder(Path(out)) as part:
        names = [name for name in (*NEEDED, *OPTIONAL) if (source / name).is_file()]
        for name in names:
            shutil.copyfile(source / name, part / name)
        run = Run(part)
        try:
            check_foreign(run)
            run.kind(), run.recipe  # refuses what does not fit
        except (DataError, ParameterError) as error:
            raise RunError(f"{source}: not a run of this package: {error}") from error
    return {"run": str(out), "files": len(names)}


def _copy(source: Path, target: Path) -> None:
    """Copy a file, without what it says of this machine."""
    left_out = OF_THIS_MACHINE.get(source.name)
    if left_out is None:
        shutil.copyfile(source, target)
        return
    values = Run(source.parent).read_json(source.name)
    kept = {key: value for key, value in values.items() if key not in left_out}
    Run(target.parent).write_json(target.name, {**kept, "path": ""} if "path" in values else kept)


def _config(run: Run, info: ModelInfo) -> dict[str, Any]:
    recipe, facts = run.recipe, run.facts()
    packages = run.read_json("environment.json").get("packages", {}) if _has(run, "environment.json") else {}
    return {
        "library_name": "tactogram",
        "tactogram_version": packages.get("tactogram"),
        "model_type": info.name,
        "task": info.task,
        "run_id": run.data["run_id"],
        "kind": facts["kind"],
        "prepare": recipe.prepare.model_dump(mode="json"),
        "config": info.config(recipe.config).model_dump(mode="json"),
        "seed": recipe.seed,
    }


def _has(run: Run, name: str) -> bool:
    return (run.folder / name).is_file()


def _evaluation(run: Run) -> dict[str, Any]:
    return run.read_json("evaluation.json") if _has(run, "evaluation.json") else {}


def _slug(text: str) -> str:
    return "-".join("".join(c if c.isalnum() else " " for c in text.lower()).split()) or "data"


def _card(run: Run, info: ModelInfo, name: str) -> str:
    """Return the model card: YAML that the Hub reads, then text."""
    from huggingface_hub import EvalResult, ModelCardData

    data, kind, evaluation = run.data, run.kind(), _evaluation(run)
    results, on = evaluation_results(evaluation), evaluation.get("data", {})
    entries = [
        EvalResult(
            task_type=TASKS[info.task],
            dataset_type=_slug(on.get("name", data["name"])),
            dataset_name=on.get("name", data["name"]),
            dataset_split=on.get("split"),
            dataset_revision=on.get("sha256"),
            metric_type=_slug(metric),
            metric_name=metric,
            metric_value=value,
        )
        for metric, value in results.items()
    ]
    simulated = kind.simulated or bool(on.get("simulated"))
    card = ModelCardData(
        library_name="tactogram",
        model_name=name,
        tags=["haptics", "tactile", info.name, *(["simulated-data"] if simulated else [])],
        eval_results=entries or None,
    )
    signals = (
        f"{kind.rate:g} Hz, {kind.unit}, axes {', '.join(kind.axes)}"
        if isinstance(kind, SignalKind)
        else "images"
    )
    text = [
        f"# {name}",
        f"{info.title} ({', '.join(info.authors)}, {info.year}), trained with tactogram.",
        "Trained on simulated data." if kind.simulated else "",
        "## Data",
        f"{data['name']}, licence of the data: {data.get('licence', 'not stated')}; SHA-256 of its content "
        f"`{data['sha256']}`. Signals: {signals}."
        + (f" Materials: {', '.join(kind.materials)}." if kind.materials else ""),
        "## Results",
        _results_text(results, on),
        "## Use",
        f"With tactogram installed:\n\n```sh\ntactogram run import hf://OWNER/{name} --out runs/{name}\n```",
    ]
    body = "\n\n".join(part for part in text if part)
    return f"---\n{card.to_yaml()}\n---\n\n{body}\n"


def _results_text(results: Mapping[str, float], on: Mapping[str, Any]) -> str:
    if not results:
        return "Not evaluated."
    where = f"On {on['name']}{' (simulated)' if on.get('simulated') else ''}, {on['split']}:"
    rows = [f"| {name} | {value:.4g} |" for name, value in results.items()]
    return "\n".join((where, "", "| figure | value |", "| --- | --- |", *rows))


def _write_results(run: Run) -> None:
    """Write the figures of an evaluation in the Hub's own format."""
    library = hub.hub_library()
    evaluation = _evaluation(run)
    on = evaluation.get("data", {})
    notes = f"{on.get('split', '')}{'; simulated data' if on.get('simulated') else ''}"
    entries = [
        library.EvalResultEntry(
            dataset_id=_slug(on["name"]),
            task_id=_slug(metric),
            value=value,
            dataset_revision=on["sha256"],
            notes=notes,
        )
        for metric, value in evaluation_results(evaluation).items()
    ]
    if entries:
        target = run.folder / RESULTS
        target.parent.mkdir()
        dump = imported("huggingface_hub.repocard", extra="hub", what="results").yaml_dump
        write_text(target, dump(library.eval_result_entries_to_yaml(entries)))

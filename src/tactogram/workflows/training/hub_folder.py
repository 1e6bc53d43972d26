"""Runs packed into one file, or in the layout of the Hugging Face Hub: weights, a card with results, and the run.

Paths of this machine are left out.
"""

from __future__ import annotations

import shutil
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from tactogram.datasets.store.pending import new_folder
from tactogram.errors import DataError, ParameterError, RunError
from tactogram.model import SignalKind
from tactogram.models import ModelInfo
from tactogram.signal.io.archives import UndatedZip, decoding
from tactogram.signal.io.atomic import atomic_write, write_text
from tactogram.training.run import Run, open_run
from tactogram.workflows import hub
from tactogram.workflows.results_table import evaluation_results
from tactogram.workflows.training import known_photographs
from tactogram.workflows.training.loaded_run import model_of
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
OF_THIS_MACHINE = {"data.json": ("path", "model_folders"), "evaluation.json": ("report",)}
TASKS = {
    "classification": "tactile-classification",
    "generation": "tactile-generation",
    "prediction": "tactile-rating",
}
LEFT_OUT = {"checkpoint.safetensors"}
LARGEST_BYTES = 8 * 2**30
"""Largest size of an unpacked run: a larger one is refused before it is unpacked."""


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
    opened = open_run(run)
    opened.facts()
    info = model_of(opened)
    with new_folder(Path(out)) as folder:
        for name in _files_in(opened.folder):
            _copy(opened.folder / name, folder / name)
        copied = Run(folder)
        # The Hub counts the downloads of this file.
        copied.write_json("config.json", {"library_name": "tactogram", "model_type": info.name})
        write_text(folder / "README.md", _card(copied, info, opened.name))
        files = list(folder.iterdir())
        facts = {"folder": str(out), "files": len(files), "bytes": sum(f.stat().st_size for f in files)}
    return facts | ({"pushed": hub.push(Path(out), push, kind="model")} if push else {})


def import_hub(source: Path | str, out: Path | str) -> dict[str, Any]:
    """Copy a run from a folder of `export_hub`, or from ``hf://OWNER/NAME``; return ``run`` and ``files``.

    Raises
    ------
    RunError
        If it is no run, cannot be had, or ``out`` exists.
    """
    if str(source).startswith(hub.PREFIX):
        with tempfile.TemporaryDirectory(prefix="tactogram-hub-") as folder:
            hub.pull(str(source).removeprefix(hub.PREFIX), Path(folder))
            return import_hub(folder, out)
    source = Path(source)
    for name in NEEDED:
        if not (source / name).is_file():
            raise RunError(f"{source}: not a run in the layout of the Hub: it has no {name}")
    names = _files_in(source)
    with new_folder(Path(out)) as part:
        for name in names:
            shutil.copyfile(source / name, part / name)
        run = Run(part)
        try:
            check_foreign(run)
            run.kind(), run.recipe  # refuses what does not fit
        except (DataError, ParameterError) as error:
            raise RunError(f"{source}: not a run of this package: {error}") from error
    return {"run": str(out), "files": len(names)}


def _files_in(folder: Path) -> list[str]:
    return [name for name in (*NEEDED, *OPTIONAL) if (folder / name).is_file()]


def _copy(source: Path, target: Path) -> None:
    """Copy a file, without what it says of this machine."""
    left_out = OF_THIS_MACHINE.get(source.name)
    if left_out is None:
        shutil.copyfile(source, target)
        return
    values = Run(source.parent).read_json(source.name, dict)
    kept = {key: value for key, value in values.items() if key not in left_out}
    Run(target.parent).write_json(target.name, {**kept, "path": ""} if "path" in values else kept)


def _card(run: Run, info: ModelInfo, name: str) -> str:
    """Return the model card: YAML that the Hub reads, then text."""
    from huggingface_hub import EvalResult, ModelCardData

    data, kind = run.data, run.kind()
    evaluation = run.evaluation
    results, on = evaluation_results(evaluation), evaluation.get("data", {})
    entries = [
        EvalResult(
            task_type=TASKS[info.task],
            dataset_type=_slug(on["name"]),
            dataset_name=on["name"],
            dataset_split=on["split"],
            dataset_revision=on["sha256"],
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
        f"{data['name']}, licence of the data: {data['licence']}; SHA-256 of its content "
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


def _slug(text: str) -> str:
    return "-".join("".join(c if c.isalnum() else " " for c in text.lower()).split()) or "data"


def export_run(run: Path | str, out: Path | str) -> dict[str, Any]:
    """Pack the finished run in ``run`` into the zip file ``out``; return ``file``, ``files`` and ``bytes``."""
    opened, target = open_run(run), Path(out)
    opened.facts()
    files = [
        f
        for f in sorted(opened.folder.rglob("*"))
        if f.is_file() and f.name not in LEFT_OUT and not f.name.startswith(".")
    ]
    with atomic_write(target) as part, UndatedZip(part) as packed:
        for file in files:
            packed.write(file, file.relative_to(opened.folder).as_posix())
    return {"file": str(target), "files": len(files), "bytes": target.stat().st_size}


def import_run(file: Path | str, out: Path | str) -> dict[str, Any]:
    """Unpack the run in the zip file ``file`` into the folder ``out``; return ``run`` and ``files``.

    Raises
    ------
    RunError
        If the file is not a packed run, names a path outside it, or ``out`` exists.
    """
    try:
        with new_folder(Path(out)) as part, decoding(Path(file), "not a packed run"):
            with zipfile.ZipFile(file) as packed:
                for member in packed.infolist():
                    path = PurePosixPath(member.filename)
                    if path.is_absolute() or ".." in path.parts or "\\" in member.filename:
                        raise RunError(f"names a path outside the run: {member.filename!r}")
                if sum(member.file_size for member in packed.infolist()) > LARGEST_BYTES:
                    raise RunError(f"would unpack to more than {LARGEST_BYTES >> 30} GiB")
                packed.extractall(part)
                count = len(packed.infolist())
            check_foreign(Run.open(part))
    except DataError as error:
        raise RunError(error) from error
    return {"run": str(out), "files": count}


def check_foreign(run: Run) -> None:
    """Refuse an unfinished run from elsewhere, and forget the folders of models on another machine."""
    run.facts()
    # Code is never loaded from a path in a file.
    data = {key: value for key, value in run.data.items() if key != "model_folders"}
    if data != run.data:
        run.write_json("data.json", data)

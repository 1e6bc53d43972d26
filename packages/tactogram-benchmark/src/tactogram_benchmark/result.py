"""Result of one model on one task with one seed: a JSON file, and the answers that are kept beside it."""

from __future__ import annotations

import json
import re
import subprocess
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import atomic_write, write_signal, write_text
from tactogram.text_files import read_json
from tactogram.validation import FrozenModel, validated
from tactogram_benchmark.data import OpenTask
from tactogram_benchmark.task import BenchmarkTask
from tactogram_benchmark.task_kind import Figure, Judgement, kind_of

FORMAT: Literal["tactogram-benchmark-result"] = "tactogram-benchmark-result"
VERSION: Literal[1] = 1
COMMITTED = Path(__file__).with_name("results.json")
Entry = Literal["model", "baseline", "outside"]
"""A model of this package or a folder of models; a baseline of the kind of task; or answers from a file."""


class ResultData(FrozenModel):
    """The store that a result was measured on."""

    name: str
    sha256: str
    simulated: bool


class BenchmarkResult(FrozenModel):
    """Content of a result's file. Unknown keys are errors."""

    format: Literal["tactogram-benchmark-result"] = FORMAT
    version: Literal[1] = VERSION
    task: str
    task_sha256: str
    model: str = Field(pattern=r"^[\w.-]+$")
    entry: Entry
    seed: int = Field(ge=0)
    recipe: str = ""
    """Name of the recipe, or a sentence on how the model was made."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """The recipe with every value."""
    data: ResultData
    split_sha256: str
    judge: int = Field(ge=1)
    """Version of the kind of task that judged it."""
    code: str
    """Version of the package that measured it, and revision of its source where it is a checkout."""
    device: str
    training_s: float | None = Field(default=None, ge=0)
    """Time of the training, s; None where it was kept from another task, or is unknown."""
    answering_s: float | None = Field(default=None, ge=0)
    finished: str
    """UTC."""
    figures: dict[str, Figure] = Field(default_factory=dict)
    """The main one first."""
    notes: tuple[str, ...] = ()
    failed: str = ""
    """Why there are no figures; empty if there are."""

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if bool(self.figures) == bool(self.failed):
            raise ValueError("a result has figures, or states why it failed, and not both")
        if self.figures and not self.main.by_item:
            raise ValueError("the first figure must have by_item, by which models are compared")
        return self

    @property
    def main_name(self) -> str:
        """Name of the main figure."""
        return next(iter(self.figures))

    @property
    def main(self) -> Figure:
        """The main figure."""
        return self.figures[self.main_name]

    def file(self, folder: Path) -> Path:
        """Return where the result belongs in a folder of results."""
        return folder / self.task / f"{self.model}-{self.seed}.json"

    def save(self, folder: Path) -> Path:
        """Write it to its place in a folder of results, and return that."""
        path = self.file(folder)
        write_text(path, json.dumps(self.model_dump(mode="json"), indent=1, ensure_ascii=False) + "\n")
        return path

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a file of `save`.

        Raises
        ------
        DataError
            If it is not JSON, or not a result.
        ParameterError
            If a value is wrong; names it.
        """
        values = read_json(path)
        if not isinstance(values, dict) or values.get("format") != FORMAT:
            raise DataError(path, f"must say format {FORMAT!r}; it is not a benchmark result")
        return validated(cls, values, where=str(path))


def result_of(
    opened: OpenTask,
    model: str,
    entry: Entry,
    seed: int,
    judgement: Judgement | None = None,
    **facts: Any,
) -> BenchmarkResult:
    """Return the result of a judgement now; ``facts`` are further fields of `BenchmarkResult`."""
    return BenchmarkResult(
        task=opened.task.name,
        task_sha256=opened.task.sha256,
        model=model,
        entry=entry,
        seed=seed,
        data=ResultData(name=opened.store.name, sha256=opened.store.sha256, simulated=opened.store.simulated),
        split_sha256=opened.task.split_sha256,
        judge=kind_of(opened.task.kind).version,
        code=code_revision(),
        device=device(),
        finished=datetime.now(UTC).isoformat(timespec="seconds"),
        figures=dict(judgement.figures) if judgement else {},
        notes=judgement.notes if judgement else (),
        **facts,
    )


def check_result(result: BenchmarkResult, tasks: Mapping[str, BenchmarkTask], *, where: str) -> None:
    """Refuse a result of an unknown task, or of another version of a task or its data.

    Raises
    ------
    ParameterError
        Naming what differs.
    """
    task = tasks.get(result.task)
    if task is None:
        raise ParameterError(f"{where}: task must be one of {', '.join(tasks)}, got {result.task!r}")
    for name, expected, got in (
        ("task_sha256", task.sha256, result.task_sha256),
        ("split_sha256", task.split_sha256, result.split_sha256),
        ("data.sha256", task.data.sha256, result.data.sha256),
    ):
        if expected != got:
            raise ParameterError(
                f"{where}: {name} must be {expected[:12]}… as in {task.file.name}, got {got[:12]}…: it was measured on "
                "another version of the task; run it again"
            )
    kind = kind_of(task.kind)
    if result.judge != kind.version:
        raise ParameterError(
            f"{where}: judge must be {kind.version}, the version of {task.kind}, got {result.judge}; run it again"
        )
    if result.figures and (result.main_name, result.main.better) != kind.main:
        raise ParameterError(
            f"{where}: first figure must be {kind.main[0]}, {kind.main[1]} is better, got {result.main_name}, "
            f"{result.main.better}"
        )


def read_results(folders: Iterable[Path]) -> list[BenchmarkResult]:
    """Return the results in folders; of one task, model and seed the last folder's.

    Raises
    ------
    DataError, ParameterError
        If a file is no result.
    """
    newest: dict[tuple[str, str, int], BenchmarkResult] = {}
    for folder in folders:
        for file in sorted(folder.glob("*/*.json")):
            result = BenchmarkResult.load(file)
            newest[result.task, result.model, result.seed] = result
    return list(newest.values())


def brief(results: Iterable[BenchmarkResult]) -> str:
    """Return results that did not fail as JSON, as far as a ranking needs them: a line each."""
    kept = (
        result.model_copy(update={"figures": {result.main_name: result.main}, "settings": {}, "notes": ()})
        for result in sorted(results, key=lambda r: (r.task, r.model, r.seed))
        if not result.failed
    )
    return (
        "[\n"
        + ",\n".join(json.dumps(each.model_dump(mode="json", exclude_defaults=True)) for each in kept)
        + "\n]\n"
    )


def committed_results() -> list[BenchmarkResult]:
    """Return the results of `brief` that come with the package."""
    return [BenchmarkResult(**row) for row in json.loads(COMMITTED.read_text(encoding="utf-8"))]


def device() -> str:
    """Return the device that trainings run on here."""
    import torch

    from tactogram.datasets import cores

    return torch.cuda.get_device_name() if torch.cuda.is_available() else f"CPU, {cores()} cores"


@cache
def code_revision() -> str:
    """Return the version of the package, and the revision of its source, marked where files differ from it."""
    release = version("tactogram")
    folder = Path(__file__).parent
    git = ["git", "-C", str(folder)]
    try:
        revision = subprocess.run([*git, "rev-parse", "--short=12", "HEAD"], capture_output=True, check=True)
        changed = subprocess.run(
            [*git, "status", "--porcelain", "--untracked-files=no", "--", str(folder.parent)],
            capture_output=True,
            check=True,
        )
    except (OSError, subprocess.CalledProcessError):
        return release
    return f"{release}+{revision.stdout.decode().strip()}{'.changed' if changed.stdout.strip() else ''}"


RECORDED = "recorded"
REAL_FOLDER = "recorded-data"
"""Of samples made from recorded data, whose licences differ: kept apart, so that results can be shared without."""


def save_shown(
    out: Path, task: str, model: str, shown: Mapping[str, Signal | Image], *, simulated: bool
) -> None:
    """Write answers to ``OUT/TASK/shown/MODEL/ITEM.flac`` or ``.png``, and what was recorded to ``…/recorded``.

    Those of recorded data go to ``OUT/recorded-data/TASK``.
    """
    folder = (out if simulated else out / REAL_FOLDER) / task / "shown"
    for name, content in shown.items():
        item = name.removesuffix(f" {RECORDED}")
        path = folder / (model if item == name else RECORDED) / re.sub(r"[^\w.=+-]+", "_", item)
        if isinstance(content, Image):
            from PIL import Image as Picture

            with atomic_write(path.with_name(path.name + ".png")) as part:
                Picture.fromarray(content.pixels).save(part)
        else:
            write_signal(path.with_name(path.name + ".flac"), content)

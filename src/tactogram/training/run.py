"""Run folder: the files of a training.

recipe.toml  environment.json  data.json  split.json  metrics.jsonl  metrics.csv
checkpoint.safetensors (during training)  model.safetensors + model.json (afterwards)
samples/  figures/  evaluation.json  report.html
"""

from __future__ import annotations

import csv
import io
import json
import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Required, Self, TypeVar

import tomli_w
from pydantic import ConfigDict
from typing_extensions import TypedDict

from tactogram.datasets.recording import LabelName
from tactogram.datasets.store.remote import is_remote
from tactogram.errors import DataError, ParameterError, RunError
from tactogram.model import ImageKind, Kind, Model, SignalKind
from tactogram.recipe import Recipe
from tactogram.signal.io.atomic import clear_parts, write_text
from tactogram.text_files import parse_json, path_of, read_json, read_text
from tactogram.training.checkpoint import load_state, save_state
from tactogram.validation import facts_of

VERSION = 1
T = TypeVar("T")
_OPEN = ConfigDict(extra="allow")
"""Models and workflows keep further facts in the run's files."""


class RunData(TypedDict, total=False):
    """Content of ``data.json``; a run that came from elsewhere has no path."""

    __pydantic_config__ = _OPEN  # type: ignore[misc]
    run_id: Required[str]
    name: Required[str]
    sha256: Required[str]
    licence: Required[str]
    label: Required[LabelName]
    simulated: Required[bool]
    path: str
    split: Mapping[str, Any]
    photographs: Mapping[str, Any]
    materials: Mapping[str, Any]
    model_folders: list[str]


class ModelFacts(TypedDict, total=False):
    """Content of ``model.json``."""

    __pydantic_config__ = _OPEN  # type: ignore[misc]
    version: Required[int]
    kind: Required[dict[str, Any]]
    notes: Required[list[str]]
    validation: dict[str, Any]
    photographs: dict[str, Any]


class _EvaluatedData(TypedDict):
    __pydantic_config__ = _OPEN  # type: ignore[misc]
    name: str
    sha256: str
    split: Any


class RunEvaluation(TypedDict, total=False):
    """Content of ``evaluation.json``."""

    __pydantic_config__ = _OPEN  # type: ignore[misc]
    data: _EvaluatedData
    measures: dict[str, Any]


class LoggedLine(TypedDict):
    """Line of ``metrics.jsonl``, with the losses of a step."""

    __pydantic_config__ = _OPEN  # type: ignore[misc]
    stage: int
    step: int


@dataclass(frozen=True)
class TrainingPosition:
    """Position in a training: ``step`` finished steps of stage number ``stage``."""

    stage: int = 0
    step: int = 0


BEGINNING = TrainingPosition()


@dataclass(frozen=True)
class Run:
    """A run folder. Files are replaced atomically, so that it is usable after a kill at any time."""

    folder: Path

    @classmethod
    def create(cls, folder: Path, *, recipe: Recipe, data: Mapping[str, Any], identity: str) -> Self:
        """Create the folder with recipe, environment and data facts.

        Raises `RunError` if the folder contains a run.
        """
        run = cls(folder)
        run.check_free()
        folder.mkdir(parents=True, exist_ok=True)
        run.write_json("environment.json", environment())
        run.write_json("data.json", {**data, "run_id": identity})
        values = recipe.model_dump(mode="json", exclude_none=True)
        write_text(folder / "recipe.toml", tomli_w.dumps(values))
        return run

    def check_free(self) -> None:
        """Refuse a folder that contains a run, or a file in its place."""
        if (self.folder / "recipe.toml").exists():
            state = "is finished" if self.finished else "has begun; resume it"
            raise RunError(
                f"{self.folder}: contains a run, which {state}, choose another folder or delete it"
            )
        if self.folder.exists() and not self.folder.is_dir():
            raise RunError(f"{self.folder}: is a file; choose a folder")

    @classmethod
    def open(cls, folder: Path) -> Self:
        """Return the run in ``folder``; refuses a folder without one."""
        run = cls(folder)
        run.check_begun()
        return run

    def check_begun(self) -> None:
        """Refuse a folder without a run."""
        if (self.folder / "recipe.toml").is_file():
            return
        if (self.folder / "dataset.json").is_file():
            reason = (
                f"it is a store; train a model on it: tactogram train MODEL --data {self.folder} --out RUN"
            )
        else:
            got = "a folder" if self.folder.is_dir() else "a file" if self.folder.exists() else "none"
            reason = f"expected a folder that `tactogram train` made, got {got}"
        raise RunError(f"{self.folder}: not a run: {reason}")

    @property
    def name(self) -> str:
        """The folder's name."""
        return self.folder.resolve().name

    @property
    def finished(self) -> bool:
        """Whether the training is finished."""
        return (self.folder / "model.json").is_file()

    @property
    def recipe(self) -> Recipe:
        """The recipe of the training."""
        return Recipe.load(self.folder / "recipe.toml")

    @property
    def data(self) -> RunData:
        """The training data: path, name, sha256, split, whether simulated."""
        return self.read_json("data.json", RunData)

    @property
    def evaluation(self) -> RunEvaluation:
        """Figures of the evaluation; empty if there was none."""
        found = (self.folder / "evaluation.json").is_file()
        return self.read_json("evaluation.json", RunEvaluation) if found else {}

    def save_checkpoint(self, learner: Model, position: TrainingPosition) -> None:
        """Save the state at ``position``."""
        save_state(self.folder / "checkpoint.safetensors", learner.state(), asdict(position))

    def restore(self, learner: Model) -> TrainingPosition:
        """Load the last checkpoint into ``learner`` and drop later log lines."""
        clear_parts(self.folder)
        path = self.folder / "checkpoint.safetensors"
        position = TrainingPosition()
        if path.exists():
            state, facts = load_state(path)
            try:
                learner.load_state(state)
                position = TrainingPosition(**facts)
            except (KeyError, TypeError, ValueError, RuntimeError) as error:
                raise RunError(f"{path}: the checkpoint is of another run: {error}") from error
        earlier = [m for m in self.metrics() if (m["stage"], m["step"]) <= (position.stage, position.step)]
        write_text(self.folder / "metrics.jsonl", "".join(json.dumps(m) + "\n" for m in earlier))
        return position

    def log(self, position: TrainingPosition, values: Mapping[str, float]) -> None:
        """Append a line to metrics.jsonl."""
        with (self.folder / "metrics.jsonl").open("a", encoding="utf-8") as file:
            file.write(json.dumps({**asdict(position), **values}) + "\n")

    def metrics(self) -> list[dict[str, Any]]:
        """Return the logged lines, without a last line cut short by a kill; refuses other broken lines."""
        path = self.folder / "metrics.jsonl"
        if not path.exists():
            return []
        try:
            lines = read_text(path).split("\n")[:-1]
            rows: list[Any] = [
                facts_of(LoggedLine, parse_json(line, where := f"{path}: line {number}"), where=where)
                for number, line in enumerate(lines, 1)
            ]
        except DataError as error:
            raise RunError(f"{error}; delete the line, or the run") from error
        return rows

    def finish(self, learner: Model, kind: Kind, facts: Mapping[str, Any]) -> None:
        """Write the weights, their facts, and the curves as a table; then delete the checkpoint."""
        self._write_curves()
        weights = {key: value for key, value in learner.state().items() if key != "optimisers"}
        save_state(self.folder / "model.safetensors", weights)
        self.write_json("model.json", {"version": VERSION, "kind": asdict(kind), **facts})
        self.forget_checkpoint()

    def forget_checkpoint(self) -> None:
        """Delete the checkpoint of a finished run, which a kill may have left."""
        if (checkpoint := self.folder / "checkpoint.safetensors").exists():  # a finished run may be read-only
            checkpoint.unlink()

    def _write_curves(self) -> None:
        lines = self.metrics()
        columns = list(dict.fromkeys(name for line in lines for name in line))
        text = io.StringIO()
        table = csv.DictWriter(text, columns, lineterminator="\n")
        table.writeheader()
        table.writerows(lines)
        write_text(self.folder / "metrics.csv", text.getvalue())

    def facts(self) -> ModelFacts:
        """Return model.json.

        Raises `RunError` if the training is not finished, or the run is of a later version.
        """
        if not self.finished:
            raise RunError(f"{self.folder}: the training is not finished; resume it")
        version = self.read_json("model.json", dict).get("version")
        if isinstance(version, int) and version > VERSION:
            raise RunError(f"{self.folder}: of a later version (format {version}, known {VERSION})")
        return self.read_json("model.json", ModelFacts)

    def kind(self) -> Kind:
        """Return the properties that all signals, or all images, of the run share."""
        kind, where = self.facts()["kind"], f"{self.folder / 'model.json'}: kind"
        with self.refusing():
            if "rate" in kind:
                return facts_of(SignalKind, kind, where=where)
            return facts_of(ImageKind, kind, where=where)

    def read_json(self, name: str, kind: type[T]) -> T:
        """Return one of the run's JSON files as a ``kind``; refuses another content."""
        path = self.folder / name
        with self.refusing():
            return facts_of(kind, read_json(path), where=path, remedy="it is damaged; use a copy of the run")

    @contextmanager
    def refusing(self) -> Iterator[None]:
        """Raise what is wrong with a file of the run as a `RunError`."""
        try:
            yield
        except DataError as error:
            raise RunError(error) from error

    def write_json(self, name: str, values: Mapping[str, Any]) -> None:
        """Write one of the run's JSON files."""
        write_text(self.folder / name, json.dumps(values, indent=1, ensure_ascii=False) + "\n")


def run_at(folder: Path | str) -> Run:
    """Return the run in a folder, which need not hold one yet; `ParameterError` for a URL."""
    if is_remote(folder):
        raise ParameterError(
            f"a run must be in a folder, got {folder}; copy it from and to an object store by its own program, "
            "such as `aws s3 sync`"
        )
    return Run(path_of(folder, "run"))


def open_run(folder: Path | str) -> Run:
    """Return the run in a folder; `RunError` if there is none."""
    run = run_at(folder)
    run.check_begun()
    return run


def environment() -> dict[str, Any]:
    """Return the environment of a training: versions, processor, threads."""
    import torch

    packages = {}
    for name in ("tactogram", "torch", "numpy", "scipy", "lightning-fabric", "numba"):
        try:
            packages[name] = version(name)
        except PackageNotFoundError:
            packages[name] = "not installed as a package"
    return {
        "python": platform.python_version(),
        "platform": platform.platform(),
        "processor": platform.processor() or platform.machine(),
        "threads": torch.get_num_threads(),
        "cuda": torch.cuda.get_device_name() if torch.cuda.is_available() else None,
        "packages": packages,
    }

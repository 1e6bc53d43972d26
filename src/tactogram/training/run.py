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
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Self

import tomli_w

from tactogram.datasets.store.remote import is_remote
from tactogram.errors import DataError, ParameterError, RunError
from tactogram.model import ImageKind, Kind, Model, SignalKind
from tactogram.recipe import Recipe
from tactogram.signal.io.atomic import clear_parts, write_text
from tactogram.text_files import parse_json, path_of, read_json, read_text
from tactogram.training.checkpoint import load_state, save_state

VERSION = 1


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
            reason = f"expected a folder that `tactogram train` made{self._absence}"
        raise RunError(f"{self.folder}: not a run: {reason}")

    @property
    def _absence(self) -> str:
        return ", got " + (
            "a folder" if self.folder.is_dir() else "a file" if self.folder.exists() else "none"
        )

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
    def data(self) -> dict[str, Any]:
        """The training data: path, name, sha256, split, whether simulated."""
        return self.read_json("data.json")

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
            rows = [parse_json(line, f"{path}: line {number}") for number, line in enumerate(lines, 1)]
        except DataError as error:
            raise RunError(f"{error}; delete the line, or the run") from error
        for number, line in enumerate(rows, 1):
            if not isinstance(line, dict) or not {"stage", "step"} <= line.keys():
                raise RunError(f"{path}: line {number} must have stage and step; delete the line, or the run")
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

    def facts(self) -> dict[str, Any]:
        """Return model.json.

        Raises `RunError` if the training is not finished, or the run is of a later version.
        """
        if not self.finished:
            raise RunError(f"{self.folder}: the training is not finished; resume it")
        facts = self.read_json("model.json")
        if not isinstance(facts.get("version"), int):
            raise RunError(f"{self.folder / 'model.json'}: has no version; it is damaged")
        if facts["version"] > VERSION:
            raise RunError(f"{self.folder}: of a later version (format {facts['version']}, known {VERSION})")
        return facts

    def kind(self) -> Kind:
        """Return the properties that all signals, or all images, of the run share."""
        try:
            facts: dict[str, Any] = {
                k: tuple(v) if isinstance(v, list) else v for k, v in self.facts()["kind"].items()
            }
            return SignalKind(**facts) if "rate" in facts else ImageKind(**facts)
        except (KeyError, TypeError, AttributeError) as error:
            raise RunError(f"{self.folder / 'model.json'}: kind lacks or misspells {error}") from error

    def read_json(self, name: str) -> dict[str, Any]:
        """Return one of the run's JSON files; refuses anything but an object."""
        try:
            values = read_json(self.folder / name)
        except DataError as error:
            raise RunError(str(error)) from error
        if not isinstance(values, dict):
            raise RunError(f"{self.folder / name}: expected a JSON object, got {type(values).__name__}")
        return values

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

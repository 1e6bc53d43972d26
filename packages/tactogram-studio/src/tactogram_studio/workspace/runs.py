"""Runs of a workspace: finished ones are listed without torch and loaded once; all are summarised."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram import models
from tactogram.datasets import Store, open_store
from tactogram.errors import DataError, TactogramError
from tactogram.model import ImageKind, Kind, SignalKind
from tactogram.signal import Signal
from tactogram.text_files import read_json, read_toml
from tactogram.workflows import evaluation_results, is_training, numbers_of
from tactogram_studio.workspace.folder import STORE, Workspace

if TYPE_CHECKING:
    from tactogram.workflows import LoadedRun

LOCK = threading.RLock()
"""Of loaded runs, which all pages share."""
LONGEST_RECORDING_S = 10.0
"""Length up to which a recording is shown beside a result."""


@dataclass(frozen=True)
class FinishedRun:
    """A finished run that is not loaded; ``name`` is relative to the workspace, ``data`` is ``data.json``."""

    folder: Path
    name: str
    model: models.ModelInfo
    kind: Kind
    data: dict[str, Any] = field(default_factory=dict)

    @property
    def ships(self) -> bool:
        """Whether the model came with this run, whose training data no workspace has."""
        return self.name == self.model.name

    @property
    def title(self) -> str:
        """Name, model and training data."""
        if self.ships:
            return f"{self.name}, ready to use"
        name = "example surfaces" if self.name == "studio/first/voices" else self.name
        return f"{name}: {self.model.name}, trained on {_data_name(self.data)}"


@dataclass
class RunCatalogue:
    """The runs of a workspace, for generation, classification and comparison with recordings."""

    workspace: Workspace
    _listed: dict[tuple[Path, int], FinishedRun] = field(default_factory=dict)

    def own(self, task: str = "generation") -> list[FinishedRun]:
        """Return the readable finished runs of a task in the workspace, newest first."""
        runs = []
        for folder in self.workspace.finished_runs():
            with suppress(TactogramError, OSError):  # damaged, or its model is not installed
                key = _version(folder)
                if key not in self._listed:
                    self._listed[key] = self.get(self.workspace.name_of(folder))
                if self._listed[key].model.task == task:
                    runs.append(self._listed[key])
        return runs

    def finished(self, task: str = "generation") -> list[FinishedRun]:
        """Return the runs of a task, newest first; last those that models come with."""
        shipped = (name for name in models.available() if models.shipped_run(name))
        return self.own(task) + [run for name in shipped if (run := self.get(name)).model.task == task]

    def get(self, name: str) -> FinishedRun:
        """Return a finished run by its folder, relative to the workspace, or by the name of the model it comes with."""
        folder = models.shipped_run(name) or self.workspace.inside(name)
        if not (folder / "model.json").is_file():
            raise DataError(name, "no such finished run in this workspace; it may have been deleted")
        facts = _read(folder / "model.json")
        stored = facts.get("kind")
        if not isinstance(stored, dict):
            raise DataError(name, "model.json has no kind; the run is broken")
        values: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value for key, value in stored.items()
        }
        try:
            kind: Kind = SignalKind(**values) if "rate" in values else ImageKind(**values)
        except TypeError as error:
            raise DataError(name, f"model.json is broken: {error}") from None
        model = models.find(str(facts.get("model"))).of(images=isinstance(kind, ImageKind))
        return FinishedRun(folder, name, model, kind, _read(folder / "data.json"))

    def load(self, run: FinishedRun) -> LoadedRun:
        """Return a loaded run; it is loaded again only after a change."""
        with LOCK:
            return _load(*_version(run.folder))

    def store_of(self, run: FinishedRun) -> Store | None:
        """Return the training data of a run, at its original place or elsewhere in the workspace."""
        original = (self.workspace.folder / str(run.data.get("path", ""))).resolve()
        if original.is_relative_to(self.workspace.folder) and (original / STORE).is_file():
            return open_store(original)
        for path in self.workspace.stores():
            with suppress(TactogramError):
                if (store := open_store(path)).sha256 == run.data.get("sha256"):
                    return store
        return None

    def classifier_for(self, run: FinishedRun) -> FinishedRun | None:
        """Return the classifier of the same data, else the newest for signals of the same unit, domain and axes."""
        kind = run.kind
        if not isinstance(kind, SignalKind):
            return None
        fitting = [
            other
            for other in self.own("classification")
            if isinstance(other.kind, SignalKind)
            and (other.kind.unit, other.kind.domain, other.kind.axes) == (kind.unit, kind.domain, kind.axes)
        ]
        same = [other for other in fitting if other.data.get("sha256") == run.data.get("sha256")]
        return next(iter((*same, *fitting)), None)

    def classify(self, classifier: FinishedRun, signal: Signal) -> dict[str, Any]:
        """Return a classifier's prediction, as `tactogram.workflows.recognition.classify`."""
        from tactogram.workflows import classify

        with LOCK:
            return classify(self.load(classifier), signal)

    def nearest(
        self, run: FinishedRun, signal: Signal, *, count: int = 3
    ) -> tuple[str, list[tuple[str, Signal, bool]]]:
        """Return the search method, and the training recordings most like a signal: title, signal, simulated.

        The recordings are as the run's model saw them. They are found by a classifier of the same data
        (`workflows.recognition.search`) or, without one, by their spectra (`find_similar`).
        """
        store = self.store_of(run)
        if store is None:
            raise DataError(
                f"The training data of {run.name} is not in this workspace: there is nothing to compare with."
            )
        with LOCK:
            loaded, classifier = self.load(run), self.classifier_for(run)
            if classifier is not None and classifier.data.get("sha256") == run.data.get("sha256"):
                from tactogram.workflows import search

                method, distance = f"by {classifier.name}", "distance {:.2g}"
                similar = search(self.load(classifier), signal, data=store.path, count=count)
            else:
                from tactogram.workflows import find_similar

                method, distance = "by their spectra", "{:.1f} dB away"
                cache = self.workspace.studio_folder / "spectra"
                stream = loaded.recipe.prepare.stream
                similar = find_similar(store, signal, stream=stream, count=count, cache=cache)
            return method, [
                _found(loaded, store, each["id"], distance.format(each["distance"]))
                for each in similar["nearest"]
            ]


def _found(run: LoadedRun, store: Store, id: str, distance: str) -> tuple[str, Signal, bool]:
    """Return a recording as the run's model saw it: title, signal, simulated."""
    info = store.info(id)
    stream = run.recipe.prepare.stream_of(store.streams_of(id))
    signal = run.as_trained.apply(store.signal(id, stream))
    longest = round(LONGEST_RECORDING_S * signal.rate) if signal.domain == "time" else len(signal)
    kind = "simulated recording" if info.simulated else "recording"
    return f"{info.material or id} ({kind}, {distance})", signal.cut(0, longest), info.simulated


def _version(folder: Path) -> tuple[Path, int]:
    return folder, (folder / "model.json").stat().st_mtime_ns


@lru_cache(maxsize=4)
def _load(folder: Path, changed_ns: int) -> LoadedRun:
    from tactogram.workflows import load_run

    return load_run(folder)


def _data_name(data: Mapping[str, Any]) -> str:
    """Return the folder of a run's training data, since all imported stores have the name of their importer."""
    return Path(str(data.get("path", ""))).name or "unknown data"


def _read(file: Path) -> dict[str, Any]:
    values = read_json(file)
    if not isinstance(values, dict):
        raise DataError(file, "expected an object")
    return values


@dataclass(frozen=True)
class RunSummary:
    """Summary of a run with its results by name; entries whose file is unreadable are empty.

    ``training`` is whether a process, of any origin, is training it.
    """

    folder: Path
    model: str
    finished: bool
    training: bool = False
    data: Mapping[str, Any] = field(default_factory=dict)
    recipe: Mapping[str, Any] = field(default_factory=dict)
    validation: Mapping[str, float] = field(default_factory=dict)
    evaluation: Mapping[str, float] = field(default_factory=dict)

    @property
    def simulated(self) -> bool:
        """Whether any of its data is simulated."""
        return bool(self.data.get("simulated"))

    @property
    def data_name(self) -> str:
        """Name of its training data."""
        return _data_name(self.data)

    @property
    def has_report(self) -> bool:
        """Whether it was evaluated."""
        return (self.folder / "report.html").is_file()


def run_summary(folder: Path) -> RunSummary:
    """Return the summary of a run folder."""
    recipe = _read_or_empty(folder / "recipe.toml")
    return RunSummary(
        folder,
        str(recipe.get("model", "unknown")),
        (folder / "model.json").is_file(),
        is_training(folder),
        _read_or_empty(folder / "data.json"),
        recipe,
        numbers_of(_read_or_empty(folder / "model.json").get("validation")),
        evaluation_results(_read_or_empty(folder / "evaluation.json")),
    )


def _read_or_empty(path: Path) -> dict[str, Any]:
    with suppress(DataError):
        values = read_toml(path) if path.suffix == ".toml" else read_json(path)
        return values if isinstance(values, dict) else {}
    return {}

"""Runs of the page Make: found without torch, loaded once, used one at a time."""

from __future__ import annotations

import json
import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactogram import models
from tactogram.datasets import RecordingInfo, Store, open_store
from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.model import ImageKind, Kind, SignalKind
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_image, read_signal
from tactogram.signal.io.atomic import write_text
from tactogram.studio.pages.make.form import GenerationForm, GenerationRequest, check, form_of
from tactogram.studio.pages.make.material_map import levels_db, positions
from tactogram.studio.workspace.folder import Workspace

if TYPE_CHECKING:
    from tactogram.workflows.training.loaded_run import LoadedRun

MOST_LOADED = 4
MAP_S = 1.0
"""Length of what each material's place on the map follows from, s."""
MOST_COMPARED = 400
"""Recordings that a result is held against by their spectra."""


@dataclass(frozen=True)
class FinishedRun:
    """A finished run, as far as it is known without loading it.

    Parameters
    ----------
    folder : Path
    name : str
        Relative to the workspace.
    facts : ModelFacts
    kind : SignalKind or ImageKind
    data : mapping
        What it was trained on, as of ``data.json``.
    """

    folder: Path
    name: str
    facts: models.ModelInfo
    kind: Kind
    data: dict[str, Any] = field(default_factory=dict)

    @property
    def form(self) -> GenerationForm:
        """What can be asked of it."""
        return form_of(self.facts, self.kind)

    @property
    def title(self) -> str:
        """What people read."""
        short = "first voices" if self.name == "studio/first/voices" else self.name
        return f"{short}: {self.facts.name}, of {self.data.get('name', 'unknown data')}"


@dataclass
class RunCatalogue:
    """The runs of a workspace.

    Parameters
    ----------
    workspace : Workspace
    """

    workspace: Workspace
    _loaded: OrderedDict[tuple[Path, int], LoadedRun] = field(default_factory=OrderedDict)
    _lock: threading.RLock = field(default_factory=threading.RLock)
    _known: dict[tuple[Path, int], FinishedRun] = field(default_factory=dict)
    _prepared_of: dict[tuple[Path, str], tuple[list[RecordingInfo], list[Signal]]] = field(
        default_factory=dict
    )

    def choices(self, task: str = "generation") -> list[FinishedRun]:
        """Return the finished runs of a task, newest first; what cannot be read is left out."""
        found = []
        for folder in self.workspace.finished_runs():
            try:
                key = (folder, (folder / "model.json").stat().st_mtime_ns)
                if key not in self._known:
                    self._known[key] = self.choice(self.workspace.name_of(folder))
                choice = self._known[key]
            except (TactogramError, OSError):
                continue
            if choice.facts.task == task:
                found.append(choice)
        return found

    def choice(self, name: str) -> FinishedRun:
        """Return a finished run by its folder, relative to the workspace.

        Raises
        ------
        TactogramError
            If it is none, no longer is, or is not readable.
        """
        folder = self.workspace.inside(name)
        if not (folder / "model.json").is_file():
            raise DataError(f"{name}: no finished run of this workspace; it was deleted, or never there")
        facts = _read(folder / "model.json")
        held = facts.get("kind")
        if not isinstance(held, dict):
            raise DataError(f"{name}: model.json says no kind; the run is broken")
        values: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value for key, value in held.items()
        }
        try:
            kind: Kind = SignalKind(**values) if "rate" in values else ImageKind(**values)
        except TypeError as error:
            raise DataError(f"{name}: model.json is broken: {error}") from None
        return FinishedRun(
            folder, name, models.find(str(facts.get("model"))), kind, _read(folder / "data.json")
        )

    def load(self, choice: FinishedRun) -> LoadedRun:
        """Return a run, ready for use; loaded once while it stays as it is."""
        key = (choice.folder, (choice.folder / "model.json").stat().st_mtime_ns)
        with self._lock:
            if key not in self._loaded:
                from tactogram.workflows.training.loaded_run import load_run

                self._loaded[key] = load_run(choice.folder)
                while len(self._loaded) > MOST_LOADED:
                    self._loaded.popitem(last=False)
            self._loaded.move_to_end(key)
            return self._loaded[key]

    # -- making ------------------------------------------------------------------------------------------

    def make(
        self, asked: GenerationRequest, *, go_on: Callable[[int], bool] = lambda number: True
    ) -> list[tuple[int, Signal | Image]]:
        """Return what is asked for, each piece with its own number from 1.

        Parameters
        ----------
        asked : Asked
        go_on : callable
            Asked before each piece, with its number; False ends it.

        Raises
        ------
        TactogramError
            For what is missing or does not fit; nothing was made then.
        """
        choice = self.choice(asked.run)
        check(asked, choice.form)
        with self._lock:
            run = self.load(choice)
            condition = self.condition(asked, run, choice.form)
            from tactogram.workflows.generation.generate import generate

            pieces = generate(run, condition, seconds=asked.seconds, seed=asked.seed, count=asked.count)
            made: list[tuple[int, Signal | Image]] = []
            for number in range(1, asked.count + 1):
                if not go_on(number):
                    break
                made.append((number, next(pieces)))
            return made  # all at once: whoever stopped taking pieces would keep the lock

    def condition(self, asked: GenerationRequest, run: LoadedRun, form: GenerationForm) -> dict[str, Any]:
        """Return a form's answers as a condition, with its files read and the words that were left open filled in."""
        condition: dict[str, Any] = {}
        if asked.mix and form.has("materials"):
            condition["material"] = asked.mix
        if asked.photo and form.has("photo"):
            condition["image"] = self.photograph(asked)
        if form.has("words"):
            from tactogram.workflows.generation.word_scores import ask

            rest = None if set(form.words) <= set(asked.words) else "mean"
            condition["words"] = ask([run], asked.words, rest=rest).on_scale_of(run)  # type: ignore[arg-type]
        if asked.vibration and form.has("vibration"):
            condition["vibration"] = read_signal(self.workspace.inside(asked.vibration))
        if asked.speed_mm_s is not None:
            condition["speed_mm_s"] = asked.speed_mm_s
        if asked.force_n is not None:
            condition["force_n"] = asked.force_n
        return condition

    def photograph(self, asked: GenerationRequest) -> Image:
        """Return the chosen part of the photograph."""
        path = self.workspace.inside(asked.photo)
        if not path.is_file():
            raise DataError(f"{asked.photo}: is gone; choose a photograph again")
        return cropped(read_image(path), asked.crop)

    # -- the map -----------------------------------------------------------------------------------------

    def places(self, choice: FinishedRun) -> NDArray[np.float64]:
        """Return where each material of a run stands on its map, float64, shape (material, 2).

        By the spectra of what the run makes of each alone (seed 0, one second); worked out once and kept.
        """
        file = self.workspace.studio_folder / "maps" / f"{choice.data.get('run_id', 'run')}.json"
        materials = choice.kind.materials
        if file.is_file():
            held = _read(file)
            if held.get("materials") == list(materials):
                return np.array(held["places"], np.float64)
        made = [signal for name in materials if isinstance(signal := self._alone(choice, name), Signal)]
        if len(made) < len(materials):
            raise ParameterError(f"{choice.name}: makes images; there is no map of their spectra")
        places = positions(levels_db(made))
        write_text(file, json.dumps({"materials": materials, "places": places.round(4).tolist()}))
        return places

    def _alone(self, choice: FinishedRun, material: str) -> Signal | Image:
        seconds = MAP_S if choice.form.over == "time" else None
        asked = GenerationRequest(choice.name, {material: 1.0}, seconds=seconds)
        return next(made for _, made in self.make(asked))

    # -- what it is like ---------------------------------------------------------------------------------

    def classifier_for(self, choice: FinishedRun) -> FinishedRun | None:
        """Return the classifier of the same data, else the newest of signals of the same unit and axes."""
        known = [
            found
            for found in self.choices("classification")
            if isinstance(found.kind, SignalKind)
            and isinstance(choice.kind, SignalKind)
            and (found.kind.unit, found.kind.domain, found.kind.axes)
            == (choice.kind.unit, choice.kind.domain, choice.kind.axes)
        ]
        same = [found for found in known if found.data.get("sha256") == choice.data.get("sha256")]
        return next(iter((*same, *known)), None)

    def classify(self, classifier: FinishedRun, signal: Signal) -> dict[str, Any]:
        """Return what a classifier takes a signal for, see `tactogram.workflows.recognition.classify`."""
        from tactogram.workflows.recognition.classify import classify

        with self._lock:
            return classify(self.load(classifier), signal)

    def store_of(self, choice: FinishedRun) -> Store | None:
        """Return the data that a run learned from, if it lies in the workspace, there or elsewhere."""
        there = (self.workspace.folder / str(choice.data.get("path", ""))).resolve()
        if there.is_relative_to(self.workspace.folder) and (there / "dataset.json").is_file():
            return open_store(there)
        for path in self.workspace.stores():
            store = open_store(path)
            if store.sha256 == choice.data.get("sha256"):
                return store
        return None

    def nearest(
        self, choice: FinishedRun, signal: Signal, *, count: int = 3
    ) -> tuple[str, list[tuple[str, Signal, bool]]]:
        """Return by what recordings were found, and those most like a signal: title, signal, whether simulated.

        The signals are as the run's model was given them.

        By a classifier of the same data where there is one (`workflows.recognition.search`), else by the spectrum (rms
        difference in third octaves, dB).

        Raises
        ------
        DataError
            If the data is not in the workspace.
        """
        store = self.store_of(choice)
        if store is None:
            raise DataError(
                f"The data that {choice.name} learned from is not in this workspace: there is nothing to compare with."
            )
        with self._lock:
            run = self.load(choice)
            classifier = self.classifier_for(choice)
            if classifier is not None and classifier.data.get("sha256") == choice.data.get("sha256"):
                from tactogram.workflows.recognition.search import search

                found = search(self.load(classifier), signal, data=store.path, count=count)["nearest"]
                return f"by {classifier.name}", [
                    (
                        f"{named(store.info(one['id']))}, distance {one['distance']:.2g})",
                        self._recording(run, store, one["id"]),
                        store.info(one["id"]).simulated,
                    )
                    for one in found
                ]
            infos, signals = self._prepared(run, choice, store)
        if not signals:
            raise DataError(
                f"{store.name} holds no recording of the kind that {choice.name} makes: no comparison."
            )
        levels = levels_db([signal, *signals])
        distance = np.sqrt(((levels[1:] - levels[0]) ** 2).mean(1)) if levels.size else np.zeros(len(infos))
        order = np.argsort(distance, kind="stable")[:count]
        return "by their spectra", [
            (f"{named(infos[k])}, {distance[k]:.1f} dB away)", signals[k], infos[k].simulated) for k in order
        ]

    def _prepared(
        self, run: LoadedRun, choice: FinishedRun, store: Store
    ) -> tuple[list[RecordingInfo], list[Signal]]:
        """Return the recordings that are of the run's kind, with their signals."""
        key = (choice.folder, store.sha256)
        if key not in self._prepared_of:
            step = max(1, -(-len(store.index) // MOST_COMPARED))
            kept: tuple[list[RecordingInfo], list[Signal]] = ([], [])
            for info in list(store.index)[::step]:
                try:
                    signal = self._recording(run, store, info.id)
                    run.kind.check(signal)
                except TactogramError:  # another sensor's, for example the other half of a set of two kinds
                    continue
                kept[0].append(info)
                kept[1].append(signal)
            self._prepared_of[key] = kept
        return self._prepared_of[key]

    def _recording(self, run: LoadedRun, store: Store, id: str) -> Signal:
        """Return a recording as the run's model was given it."""
        stream = run.recipe.prepare.stream_of(store.streams_of(id))
        signal = run.as_trained.apply(store.signal(id, stream))
        longest = round(10.0 * signal.rate) if signal.domain == "time" else len(signal)
        return signal.cut(0, longest)


def named(info: RecordingInfo) -> str:
    """Return how the title of a recording begins; a simulated one says so."""
    return f"{info.material or info.id} ({'simulated ' if info.simulated else ''}recording"


def cropped(image: Image, crop: tuple[float, float, float, float] | None) -> Image:
    """Return the part of an image whose left, top, right, bottom are shares of its sides; at least a pixel."""
    if crop is None:
        return image
    rows, columns = image.size
    left, top, right, bottom = crop
    first_row, first_column = min(rows - 1, int(top * rows)), min(columns - 1, int(left * columns))
    return image.cut(
        first_row,
        first_column,
        max(first_row + 1, round(bottom * rows)),
        max(first_column + 1, round(right * columns)),
    )


def _read(file: Path) -> dict[str, Any]:
    try:
        values = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise DataError(f"{file}: not readable: {error}") from None
    if not isinstance(values, dict):
        raise DataError(f"{file}: expected an object")
    return values

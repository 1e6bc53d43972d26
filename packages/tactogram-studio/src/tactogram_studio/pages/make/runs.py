"""Runs of the page Make: listed without torch, loaded once, used by one thread at a time."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactogram import models
from tactogram.datasets import RecordingInfo, Store, open_store
from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.model import ImageKind, Kind, SignalKind
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_image, read_signal, write_text
from tactogram.text_files import read_json
from tactogram_studio.pages.make.form import (
    LONGEST_S,
    OF_A_STROKE,
    Crop,
    GenerationForm,
    GenerationRequest,
    check_request,
    form_of,
)
from tactogram_studio.pages.make.material_map import levels_db, positions
from tactogram_studio.workspace.folder import Workspace

if TYPE_CHECKING:
    from tactogram.workflows import LoadedRun

MAP_S = 1.0
"""Length of the signals whose spectra place the materials on the map, s."""
MOST_SEARCHED = 400
"""Recordings whose spectra a result is compared with."""
LONGEST_RECORDING_S = 10.0


@dataclass(frozen=True)
class FinishedRun:
    """A finished run that is not loaded; ``name`` is relative to the workspace, ``data`` is ``data.json``."""

    folder: Path
    name: str
    model: models.ModelInfo
    kind: Kind
    data: dict[str, Any] = field(default_factory=dict)

    @property
    def form(self) -> GenerationForm:
        """The form of the page for this run; raises `ParameterError` if it generates nothing."""
        form = form_of(self.model, self.kind)
        if not self.data.get("photographs", {}).get("train"):
            form = replace(form, instead=tuple(part for part in form.instead if part != "photo"))
        return form

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
        return f"{name}: {self.model.name}, trained on {self.data.get('name', 'unknown data')}"


@dataclass
class RunCatalogue:
    """The runs of a workspace, for generation, classification and comparison with recordings."""

    workspace: Workspace
    _lock: threading.RLock = field(default_factory=threading.RLock)
    _listed: dict[tuple[Path, int], FinishedRun] = field(default_factory=dict)
    _prepared: dict[tuple[Path, str], list[tuple[RecordingInfo, Signal]]] = field(default_factory=dict)

    def finished(self, task: str = "generation") -> list[FinishedRun]:
        """Return the readable finished runs of a task, newest first; last those that models come with."""
        runs = []
        for folder in self.workspace.finished_runs():
            with suppress(TactogramError, OSError):
                key = _version(folder)
                if key not in self._listed:
                    self._listed[key] = self.get(self.workspace.name_of(folder))
                if self._listed[key].model.task == task:
                    runs.append(self._listed[key])
        shipped = (name for name in models.available() if models.shipped_run(name))
        return runs + [run for name in shipped if (run := self.get(name)).model.task == task]

    def get(self, name: str) -> FinishedRun:
        """Return a finished run by its folder, relative to the workspace, or by the name of the model it comes with."""
        folder = models.shipped_run(name) or self.workspace.inside(name)
        if not (folder / "model.json").is_file():
            raise DataError(f"{name}: no such finished run in this workspace; it may have been deleted")
        facts = _read(folder / "model.json")
        stored = facts.get("kind")
        if not isinstance(stored, dict):
            raise DataError(f"{name}: model.json has no kind; the run is broken")
        values: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value for key, value in stored.items()
        }
        try:
            kind: Kind = SignalKind(**values) if "rate" in values else ImageKind(**values)
        except TypeError as error:
            raise DataError(f"{name}: model.json is broken: {error}") from None
        model = models.find(str(facts.get("model"))).of(images=isinstance(kind, ImageKind))
        return FinishedRun(folder, name, model, kind, _read(folder / "data.json"))

    def load(self, run: FinishedRun) -> LoadedRun:
        """Return a loaded run; it is loaded again only after a change."""
        with self._lock:
            return _load(*_version(run.folder))

    # -- generating --------------------------------------------------------------------------------------

    def generate(
        self, request: GenerationRequest, *, proceed: Callable[[int], bool] = lambda number: True
    ) -> list[tuple[int, Signal | Image]]:
        """Return the requested results, each with its number from 1.

        ``proceed`` is called with each number before the result is generated; False ends the generation.
        """
        run = self.get(request.run)
        request = run.form.used(request)
        check_request(request, run.form)
        with self._lock:
            loaded = self.load(run)
            condition = self._condition(request, loaded, run.form)
            from tactogram.workflows import generate

            pieces = generate(
                loaded, condition, seconds=request.seconds, seed=request.seed, count=request.count
            )
            results: list[tuple[int, Signal | Image]] = []
            for number in range(1, request.count + 1):
                if not proceed(number):
                    break
                results.append((number, next(pieces)))
            return results  # a list: a generator that is not exhausted would hold the lock

    def _condition(self, request: GenerationRequest, run: LoadedRun, form: GenerationForm) -> dict[str, Any]:
        """Return the model's condition for a form, with files read and missing words filled in."""
        condition: dict[str, Any] = {}
        if request.mix and form.has("materials"):
            condition["material"] = request.mix
        if request.photo and form.has("photo"):
            condition["image"] = self.photograph(request)
        if request.text:
            condition["text"] = request.text
        if form.some_words and request.words:
            from tactogram.workflows import some_words

            condition["words"] = some_words(run, request.words)
        elif "words" in form.needs:
            from tactogram.workflows import ask

            rest = None if set(form.words) <= set(request.words) else "mean"
            condition["words"] = ask([run], request.words, rest=rest).on_scale_of(run)  # type: ignore[arg-type]
        if request.vibration and form.has("vibration"):
            vibration = read_signal(self.workspace.inside(request.vibration))
            condition["vibration"] = (
                run.prepare_vibration(vibration) if "vibration" in form.instead else vibration
            )
        given = {name: getattr(request, name) for name in OF_A_STROKE}
        condition |= {name: value for name, value in given.items() if value is not None}
        if request.motion:
            from tactogram.workflows import SIMULATED, motion_of

            simulated = request.motion == SIMULATED
            source = SIMULATED if simulated else self.workspace.inside(request.motion)
            motion = motion_of(source, seconds=request.seconds, seed=request.seed)
            if request.seconds is None and motion.seconds > LONGEST_S:
                raise ParameterError(
                    f"The motion lasts {motion.seconds:g} s; set a length of at most {LONGEST_S:g} s, or cut it."
                )
            condition["motion"] = motion
        return condition

    def photograph(self, request: GenerationRequest) -> Image:
        """Return the cropped photograph."""
        path = self.workspace.inside(request.photo)
        if not path.is_file():
            raise DataError(f"{request.photo}: no longer available; choose a photograph again")
        return cropped(read_image(path), request.crop)

    def said(self, request: GenerationRequest) -> dict[str, Any]:
        """Return `condition_facts` of a request, and what they say of its description in a sentence, ``described``."""
        from tactogram.workflows import condition_facts, description_text

        run = self.get(request.run)
        request = run.form.used(request)
        measured = request.vibration and "vibration" in run.form.instead
        recorded = read_signal(self.workspace.inside(request.vibration)) if measured else None
        with self._lock:
            loaded = self.load(run)
            facts = condition_facts(loaded, self._condition(request, loaded, run.form), recorded)
        text = description_text(facts)
        return facts | {"described": f"{text[:1].upper()}{text[1:]}." if text else ""}

    def described(self, request: GenerationRequest, text: str) -> GenerationRequest:
        """Return a request for what an English text describes: the text if the run predicts from it, else materials.

        Raises `ParameterError` if the run mixes materials and it is like no name of them.
        """
        from tactogram.workflows import with_materials

        given = {"text": text} | ({"image": self.photograph(request)} if request.photo else {})
        with self._lock:
            found = with_materials(self.load(self.get(request.run)), given)
        if "text" in found or request.photo:
            return replace(request, text=text)
        return replace(request, text="", weights=found["material"])

    def places(self, run: FinishedRun) -> NDArray[np.float64]:
        """Return the place of each material of a run on its map, float64, shape (material, 2).

        Places follow from the spectra of one generated second of each material (seed 0), and are stored.
        """
        file = self.workspace.studio_folder / "maps" / f"{run.data.get('run_id', 'run')}.json"
        materials = run.kind.materials
        if file.is_file():
            stored = _read(file)
            if stored.get("materials") == list(materials):
                return np.array(stored["places"], np.float64)
        seconds = MAP_S if run.form.over == "time" else None
        signals = []
        for name in materials:
            [(_, made)] = self.generate(GenerationRequest(run.name, {name: 1.0}, seconds=seconds))
            if not isinstance(made, Signal):
                raise ParameterError(f"{run.name}: generates images, whose spectra have no map")
            signals.append(made)
        places = positions(levels_db(signals))
        write_text(file, json.dumps({"materials": materials, "places": places.round(4).tolist()}))
        return places

    # -- comparing ---------------------------------------------------------------------------------------

    def classifier_for(self, run: FinishedRun) -> FinishedRun | None:
        """Return the classifier of the same data, else the newest for signals of the same unit, domain and axes."""
        kind = run.kind
        if not isinstance(kind, SignalKind):
            return None
        fitting = [
            other
            for other in self.finished("classification")
            if isinstance(other.kind, SignalKind)
            and (other.kind.unit, other.kind.domain, other.kind.axes) == (kind.unit, kind.domain, kind.axes)
        ]
        same = [other for other in fitting if other.data.get("sha256") == run.data.get("sha256")]
        return next(iter((*same, *fitting)), None)

    def classify(self, classifier: FinishedRun, signal: Signal) -> dict[str, Any]:
        """Return a classifier's prediction, as `tactogram.workflows.recognition.classify`."""
        from tactogram.workflows import classify

        with self._lock:
            return classify(self.load(classifier), signal)

    def store_of(self, run: FinishedRun) -> Store | None:
        """Return the training data of a run, at its original place or elsewhere in the workspace."""
        original = (self.workspace.folder / str(run.data.get("path", ""))).resolve()
        if original.is_relative_to(self.workspace.folder) and (original / "dataset.json").is_file():
            return open_store(original)
        stores = map(open_store, self.workspace.stores())
        return next((store for store in stores if store.sha256 == run.data.get("sha256")), None)

    def nearest(
        self, run: FinishedRun, signal: Signal, *, count: int = 3
    ) -> tuple[str, list[tuple[str, Signal, bool]]]:
        """Return the search method, and the training recordings most like a signal: title, signal, simulated.

        The recordings are prepared as the run's model saw them. They are found by a classifier of the same data
        (`workflows.recognition.search`) or, without one, by the rms difference of third-octave levels, dB.
        """
        store = self.store_of(run)
        if store is None:
            raise DataError(
                f"The training data of {run.name} is not in this workspace: there is nothing to compare with."
            )
        with self._lock:
            loaded = self.load(run)
            classifier = self.classifier_for(run)
            if classifier is not None and classifier.data.get("sha256") == run.data.get("sha256"):
                from tactogram.workflows import search

                found = search(self.load(classifier), signal, data=store.path, count=count)["nearest"]
                return f"by {classifier.name}", [
                    (
                        f"{_title(info := store.info(each['id']))}, distance {each['distance']:.2g})",
                        self._recording(loaded, store, info.id),
                        info.simulated,
                    )
                    for each in found
                ]
            recordings = self._recordings(loaded, run, store)
        if not recordings:
            raise DataError(f"{store.name} has no recording of the kind that {run.name} generates.")
        levels = levels_db([signal, *(recording for _, recording in recordings)])
        distance = (
            np.sqrt(((levels[1:] - levels[0]) ** 2).mean(1)) if levels.size else np.zeros(len(recordings))
        )
        order = np.argsort(distance, kind="stable")[:count]
        return "by their spectra", [
            (f"{_title(info)}, {distance[k]:.1f} dB away)", recording, info.simulated)
            for k, (info, recording) in ((k, recordings[k]) for k in order)
        ]

    def _recordings(
        self, loaded: LoadedRun, run: FinishedRun, store: Store
    ) -> list[tuple[RecordingInfo, Signal]]:
        """Return up to `MOST_SEARCHED` recordings of the run's kind."""
        key = (run.folder, store.sha256)
        if key not in self._prepared:
            step = max(1, -(-len(store.index) // MOST_SEARCHED))
            recordings = []
            for info in list(store.index)[::step]:
                with suppress(TactogramError):  # another sensor's, for example
                    signal = self._recording(loaded, store, info.id)
                    loaded.kind.check(signal)
                    recordings.append((info, signal))
            self._prepared[key] = recordings
        return self._prepared[key]

    def _recording(self, run: LoadedRun, store: Store, id: str) -> Signal:
        """Return a recording as the run's model saw it."""
        stream = run.recipe.prepare.stream_of(store.streams_of(id))
        signal = run.as_trained.apply(store.signal(id, stream))
        longest = round(LONGEST_RECORDING_S * signal.rate) if signal.domain == "time" else len(signal)
        return signal.cut(0, longest)


def _title(info: RecordingInfo) -> str:
    """Return the start of a recording's title, with an open parenthesis."""
    return f"{info.material or info.id} ({'simulated ' if info.simulated else ''}recording"


def cropped(image: Image, crop: Crop | None) -> Image:
    """Return the crop of an image, at least a pixel."""
    if crop is None:
        return image
    rows, columns = image.size
    left, top, right, bottom = crop
    first_row, first_column = min(rows - 1, int(top * rows)), min(columns - 1, int(left * columns))
    last_row, last_column = round(bottom * rows), round(right * columns)
    return image.cut(
        first_row, first_column, max(first_row + 1, last_row), max(first_column + 1, last_column)
    )


def _version(folder: Path) -> tuple[Path, int]:
    return folder, (folder / "model.json").stat().st_mtime_ns


@lru_cache(maxsize=4)
def _load(folder: Path, changed_ns: int) -> LoadedRun:
    from tactogram.workflows import load_run

    return load_run(folder)


def _read(file: Path) -> dict[str, Any]:
    values = read_json(file)
    if not isinstance(values, dict):
        raise DataError(f"{file}: expected an object")
    return values

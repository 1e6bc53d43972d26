"""Runs of the page Make: what a filled-in form generates, what is said of it, and the map of a run's materials."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, ParameterError
from tactogram.model import condition_options
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_image, read_signal, write_image, write_text
from tactogram.text_files import read_json
from tactogram_studio.generation.form import (
    LONGEST_S,
    Crop,
    GenerationForm,
    GenerationRequest,
    check_request,
    form_of_run,
    options_of,
)
from tactogram_studio.signals.traits import band_levels
from tactogram_studio.workspace.runs import LOCK, FinishedRun, RunCatalogue

if TYPE_CHECKING:
    from tactogram.workflows import LoadedRun

NEIGHBOURS = 3
"""Most materials in the mix of a point."""
MARGIN = 0.1
APART = 0.1
"""Least distance between two materials, in sides of the map, so that each can be reached."""
DEEPEST_DB = 60.0
"""Level below the strongest band at which differences no longer count."""
LEAST = 0.01
"""Share below which a material is omitted from a mix."""
MAP_S = 1.0
"""Length of the signals whose spectra place the materials on the map, s."""


def levels_db(signals: Sequence[Signal]) -> NDArray[np.float64]:
    """Return third-octave levels in the bands that all signals share, float64, shape (signal, band), dB."""
    spectra = [band_levels(signal) for signal in signals]
    shared = sorted(set.intersection(*(set(np.round(f, 6)) for f, _ in spectra)))
    rows = [
        [a for f, a in zip(*spectrum, strict=True) if round(float(f), 6) in shared] for spectrum in spectra
    ]
    level = 20 * np.log10(np.maximum(np.array(rows, np.float64), 1e-12))
    if not level.size:
        return np.zeros((len(signals), 0))
    return np.asarray(np.maximum(level, level.max() - DEEPEST_DB))


def positions(features: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places in the unit square whose distances approximate those of ``features``.

    Classical multidimensional scaling (Torgerson 1952): the two strongest components; places closer than `APART` are
    then moved apart.

    Parameters
    ----------
    features : float64 array, shape (item, feature)

    Returns
    -------
    float64 array, shape (item, 2)
        From the left and from the top, each at least `MARGIN` from the edge. Deterministic.
    """
    n = len(features)
    centred = features - features.mean(0)
    u, s, _ = np.linalg.svd(centred, full_matrices=False)
    points = np.zeros((n, 2))
    for k in range(min(2, len(s))):
        component = u[:, k] * s[k]
        largest = np.argmax(np.abs(component))
        points[:, k] = component * (np.sign(component[largest]) or 1.0)
    extent = np.ptp(points, axis=0).max()
    middle = (points.max(0) + points.min(0)) / 2
    unit = (points - middle) / (extent or 1.0) * (1 - 2 * MARGIN) + 0.5
    return _apart(unit)


def weights_at(point: Sequence[float], places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the weights of the items at a point, float64, shape (item,), sum 1.

    Only the nearest `NEIGHBOURS` count, weighted by ((R - d) / (R d))^2 with R the distance of the next one (Franke
    and Nielson 1980): weights change continuously between neighbours, and an item's place gives that item alone.
    """
    distance = np.linalg.norm(places - np.asarray(point, np.float64), axis=1)
    on = distance < 1e-6
    if on.any():
        return np.asarray(on / on.sum())
    if len(places) > NEIGHBOURS:
        reach = np.sort(distance)[NEIGHBOURS]
        share = np.maximum(reach - distance, 0) / (reach * distance)
    else:
        share = 1 / distance
    weight = share**2
    if not weight.any():  # all at the same distance
        weight = np.asarray(distance <= distance.min() * (1 + 1e-9), np.float64)
    weight /= weight.sum()
    weight[weight < LEAST] = 0
    return np.asarray(weight / weight.sum())


def point_of(weights: Mapping[str, float], names: Sequence[str], places: NDArray[np.float64]) -> list[float]:
    """Return the place of the handle for arbitrary weights: their centre."""
    share = np.array([max(0.0, weights.get(name, 0.0)) for name in names])
    if not share.any():
        return [0.5, 0.5]
    return [float(value) for value in share @ places / share.sum()]


def _apart(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places moved until no two are closer than `APART`, in at most a hundred rounds."""
    moved = places.copy()
    n = len(moved)
    least = min(APART, 0.7 / max(1.0, np.sqrt(n)))
    for _ in range(100):
        close = False
        for i in range(n):
            for j in range(i):
                step = moved[i] - moved[j]
                distance = float(np.linalg.norm(step))
                if distance < least * 0.999:
                    close = True
                    angle = 2.4 * (i + j)  # a fixed direction for two at the same place
                    away = step / distance if distance > 1e-9 else np.array([np.cos(angle), np.sin(angle)])
                    moved[i] += away * (least - distance) / 2
                    moved[j] -= away * (least - distance) / 2
        moved = np.clip(moved, MARGIN, 1 - MARGIN)
        if not close:
            break
    return moved


@dataclass
class GeneratingRuns(RunCatalogue):
    """The runs of a workspace, and what they generate for a form."""

    def generate(
        self, request: GenerationRequest, *, proceed: Callable[[int], bool] = lambda number: True
    ) -> list[tuple[int, Signal | Image]]:
        """Return the requested results, each with its number from 1.

        ``proceed`` is called with each number before the result is generated; False ends the generation.
        """
        run = self.get(request.run)
        form = form_of_run(run)
        request = form.used(request)
        check_request(request, form)
        with LOCK:
            loaded = self.load(run)
            condition, _ = self._condition(request, loaded, form)
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

    def _condition(
        self, request: GenerationRequest, run: LoadedRun, form: GenerationForm
    ) -> tuple[dict[str, Any], list[str]]:
        """Return the condition that a form states, missing words filled in, and sentences on what a recording lacks."""
        from tactogram.workflows import SIMULATED, Reading, ask

        options = options_of(request.changed(image=self.photo_file(request)), form)
        condition: dict[str, Any] = {}
        for name, (_, option) in condition_options().items():
            if option.file and options.get(name, SIMULATED) != SIMULATED:
                options[name] = self.workspace.inside(options[name])
        if "words" in form.needs:
            scores = options.pop("words", {})
            rest = None if set(form.words) <= set(scores) else "mean"
            condition["words"] = ask([run], scores, rest=rest).on_scale_of(run)  # type: ignore[arg-type]
            if "vibration" in options:
                condition["vibration"] = read_signal(options.pop("vibration"))
        how = Reading(run, {}, request.seconds, request.seed)
        condition |= how.condition(options)
        motion = condition.get("motion")
        if motion is not None and request.seconds is None and motion.seconds > LONGEST_S:
            raise ParameterError(
                f"The motion lasts {motion.seconds:g} s; set a length of at most {LONGEST_S:g} s, or cut it."
            )
        return condition, how.limited

    def photo_file(self, request: GenerationRequest) -> str:
        """Return the file of the cropped photograph, relative to the workspace, written if missing; "" without one."""
        photograph = str(request.values.get("image", ""))
        if not photograph:
            return ""
        whole = self.workspace.inside(photograph)
        if not whole.is_file():
            raise DataError(f"{photograph}: no longer available; choose a photograph again")
        if request.crop is None:
            return photograph
        digest = hashlib.sha256(f"{photograph} {request.crop}".encode()).hexdigest()[:8]
        file = whole.with_name(f"{whole.stem}-part-{digest}.png")
        if not file.is_file():
            write_image(file, cropped(read_image(whole), request.crop))
        return self.workspace.name_of(file)

    def said(self, request: GenerationRequest) -> dict[str, Any]:
        """Return `condition_facts` of a request, and what they say of its description in a sentence, ``described``."""
        from tactogram.workflows import condition_facts, description_text

        run = self.get(request.run)
        form = form_of_run(run)
        with LOCK:
            loaded = self.load(run)
            condition, lacks = self._condition(form.used(request), loaded, form)
            facts = condition_facts(loaded, condition)
        if limited := [*facts.get("limited", ()), *lacks]:
            facts["limited"] = limited
        text = description_text(facts)
        return facts | {"described": f"{text[:1].upper()}{text[1:]}." if text else ""}

    def described(self, request: GenerationRequest, text: str) -> GenerationRequest:
        """Return a request for what an English text describes: the text if the run predicts from it, else materials.

        Raises `ParameterError` if the run mixes materials and it names none of them.
        """
        from tactogram.workflows import with_materials

        photograph = self.photo_file(request)
        condition = {"image": read_image(self.workspace.inside(photograph))} if photograph else {}
        with LOCK:
            completed = with_materials(self.load(self.get(request.run)), condition | {"text": text})
        if "text" in completed or photograph:
            return request.changed(text=text)
        return request.changed(text="", material=completed["material"], typed=text)

    def places(self, run: FinishedRun) -> NDArray[np.float64]:
        """Return the place of each material of a run on its map, float64, shape (material, 2).

        Places follow from the spectra of one generated second of each material (seed 0), and are stored.
        """
        file = self.workspace.studio_folder / "maps" / f"{run.data.get('run_id', 'run')}.json"
        materials = run.kind.materials
        if file.is_file():
            stored = read_json(file)
            if stored.get("materials") == list(materials):
                return np.array(stored["places"], np.float64)
        seconds = MAP_S if form_of_run(run).over == "time" else None
        signals = []
        for name in materials:
            [(_, content)] = self.generate(
                GenerationRequest(run.name, {"material": {name: 1.0}}, seconds=seconds)
            )
            if not isinstance(content, Signal):
                raise ParameterError(f"{run.name}: generates images, whose spectra have no map")
            signals.append(content)
        places = positions(levels_db(signals))
        write_text(file, json.dumps({"materials": materials, "places": places.round(4).tolist()}))
        return places


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

"""Runs of the page Make: what a filled-in form generates, and what is said of it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, ParameterError
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
    form_of_run,
)
from tactogram_studio.pages.make.material_map import levels_db, positions
from tactogram_studio.workspace.runs import LOCK, FinishedRun, RunCatalogue

if TYPE_CHECKING:
    from tactogram.workflows import LoadedRun

MAP_S = 1.0
"""Length of the signals whose spectra place the materials on the map, s."""


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
            condition = self._condition(request, loaded, form)
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
        form = form_of_run(run)
        request = form.used(request)
        measured = request.vibration and "vibration" in form.instead
        recorded = read_signal(self.workspace.inside(request.vibration)) if measured else None
        with LOCK:
            loaded = self.load(run)
            facts = condition_facts(loaded, self._condition(request, loaded, form), recorded)
        text = description_text(facts)
        return facts | {"described": f"{text[:1].upper()}{text[1:]}." if text else ""}

    def described(self, request: GenerationRequest, text: str) -> GenerationRequest:
        """Return a request for what an English text describes: the text if the run predicts from it, else materials.

        Raises `ParameterError` if the run mixes materials and it is like no name of them.
        """
        from tactogram.workflows import with_materials

        given = {"text": text} | ({"image": self.photograph(request)} if request.photo else {})
        with LOCK:
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
            stored = read_json(file)
            if stored.get("materials") == list(materials):
                return np.array(stored["places"], np.float64)
        seconds = MAP_S if form_of_run(run).over == "time" else None
        signals = []
        for name in materials:
            [(_, made)] = self.generate(GenerationRequest(run.name, {name: 1.0}, seconds=seconds))
            if not isinstance(made, Signal):
                raise ParameterError(f"{run.name}: generates images, whose spectra have no map")
            signals.append(made)
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

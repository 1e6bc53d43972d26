"""Clone of a surface: strokes at many speeds and forces, generated from one, and a texture fitted to all."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import Recording, create_store
from tactogram.errors import ParameterError
from tactogram.model import Condition, limits_within
from tactogram.signal import Signal
from tactogram.signal.io import read_image, read_signal
from tactogram.signal.io.atomic import check_writable
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.texture_map import NAMES, NoiseMap
from tactogram.training.run import Run
from tactogram.training.seeds import child_seed
from tactogram.workflows.generation.generate import limits, run_provenance, within
from tactogram.workflows.generation.requests import FORCES_N, SPEEDS_MM_S, STROKE_S, CloneRequest
from tactogram.workflows.generation.word_scores import some_words
from tactogram.workflows.request import takes
from tactogram.workflows.training.loaded_run import LoadedRun, load_run
from tactogram.workflows.training.train import train

WORDS = "words"
"""Material of the surface that words describe."""
_CLONED = SPEEDS_MM_S, FORCES_N
LEAST_S = 1.0
"""Shortest recording that is itself a stroke of its clone."""


@takes(CloneRequest)
def clone(request: CloneRequest) -> Run:
    """Return a run of `texture_var` that plays surfaces at any speed and force, from one stroke, photograph or name.

    Its strokes are beside the run, in the store ``OUT-strokes``: those generated at each of ``speeds`` and ``forces``,
    limited to what the model predicts, which count as simulated; and a recording of 1 s or more whose speed is known,
    as of the middle one of ``forces`` if its own is not. A recording in another unit than the model's keeps its unit,
    but then all must have it. ``notes`` of the run's facts say what is outside of what the model learned.

    Raises
    ------
    ParameterError
        If nothing describes a surface, two do so by one name, or the model cannot generate strokes at other speeds.
    DataError
        If a recording cannot be read.
    RunError
        If ``out`` holds a run.
    """
    out = Path(request.out)
    strokes = out.with_name(f"{out.name}-strokes")
    check_writable(out, folder=True)
    Run(out).check_free()
    loaded = load_run(request.model)
    ranges = loaded.model.predicted_ranges
    if not ranges:
        raise ParameterError(
            f"{request.model} predicts no other speeds and forces; take texture_flow as it comes trained, or train it "
            "on recordings at several speeds with config.prediction=true"
        )
    surfaces, limited = _surfaces(request, loaded)
    for name, values, default in zip(NAMES, (request.speeds, request.forces), _CLONED, strict=True):
        known = {name: ranges[name]} if name in ranges else {}
        limited += [
            str(found) for value in {*values} - {*default} for found in limits_within({name: value}, known)
        ]
    store = create_store(
        strokes,
        _strokes(request, loaded, surfaces, ranges),
        name=f"clones of {', '.join(surfaces)}",
        licence="that of the recordings",
        source=f"tactogram clone, by {run_provenance(loaded, request.seed)['run']}",
        simulated=True,
    )
    run = train("texture_var", store.path, out=out, split="all", progress=request.progress)
    facts = run.facts()
    run.write_json("model.json", facts | {"notes": [*facts["notes"], *limited]})
    return run


def live_map(
    run: LoadedRun, condition: Condition, ranges: Mapping[str, tuple[float, float]], *, seed: int = 0
) -> NoiseMap:
    """Return a surface over speed and force, to be streamed: a clone that is not stored.

    ``condition`` describes it to a run that predicts surfaces within ``ranges`` (`Model.predicted_ranges`).
    """
    at, described = _grid(_CLONED, ranges), within(run, condition)
    strokes = [
        run.generate(
            {**described, **_known(pair)},
            seconds=STROKE_S,
            seed=child_seed(seed, "clone", number),
        )
        for number, pair in enumerate(at, start=1)
    ]
    models = [fit_modulated_noise(stroke) for stroke in strokes if isinstance(stroke, Signal)]
    return NoiseMap(models, np.array(at, np.float64))


def _grid(
    cloned: tuple[Sequence[float], Sequence[float]], ranges: Mapping[str, tuple[float, float]]
) -> list[tuple[float | None, ...]]:
    """Return the speeds and forces of strokes, None where a model predicts none."""
    return list(
        product(*(_within(values, ranges.get(name)) for name, values in zip(NAMES, cloned, strict=True)))
    )


def _known(pair: Sequence[float | None]) -> dict[str, float]:
    return {name: value for name, value in zip(NAMES, pair, strict=True) if value is not None}


def _within(values: Sequence[float], limits: tuple[float, float] | None) -> list[float | None]:
    """Return those of values that a model predicts, which begin and end at its limits; None if it predicts none."""
    if limits is None:
        return [None]
    return [*sorted({min(max(value, limits[0]), limits[1]) for value in values})]


def _surfaces(request: CloneRequest, loaded: LoadedRun) -> tuple[dict[str, Mapping[str, Any]], list[str]]:
    """Return the condition that describes each surface, by name, and what is outside of what the model learned."""
    limited: list[str] = []
    found: dict[str, Mapping[str, Any]] = {}
    known = {"vibration_speed_mm_s": request.speed, "vibration_force_n": request.force}
    names = [
        *(Path(file).stem for file in (*request.recordings, *request.images)),
        *request.materials,
        *([WORDS] if request.words else []),
    ]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ParameterError(
            f"recordings, photographs, materials and `words` must have different names, got {twice[0]!r} twice"
        )
    for file in map(Path, request.recordings):
        recording = read_signal(file, **request.reading)
        found[file.stem] = {"vibration": loaded.prepare_vibration(recording), **known}
        notes = *limits(loaded, known), *loaded.missing_band(recording)
        limited += [f"{file.stem}: {note}" for note in notes]
    found |= {Path(file).stem: {"image": read_image(file)} for file in request.images}
    found |= {name: {"material": name} for name in request.materials}
    if request.words:
        asked = {"words": some_words(loaded, request.words)}
        found[WORDS], limited = within(loaded, asked), [*limited, *map(str, limits(loaded, asked))]
    if not found:
        raise ParameterError("give a recording of a surface, `images`, `materials` or `words`")
    return found, limited


def _strokes(
    request: CloneRequest,
    loaded: LoadedRun,
    surfaces: Mapping[str, Mapping[str, Any]],
    ranges: Mapping[str, tuple[float, float]],
) -> Iterator[Recording]:
    grid = _grid((request.speeds, request.forces), ranges)
    forces = sorted({force for _, force in grid if force is not None})
    middle = forces[len(forces) // 2] if forces else None
    recorded = {
        name: (request.speed, request.force or middle)
        for name, given in surfaces.items()
        if request.speed and "vibration" in given and given["vibration"].seconds >= LEAST_S
    }
    for name, (speed, force) in recorded.items():
        yield _stroke(name, surfaces[name]["vibration"], speed, force, simulated=False)
    at = [(name, pair) for name in surfaces for pair in grid]
    for number, (name, pair) in enumerate(at, start=1):
        if recorded.get(name) == pair:
            continue
        made = loaded.generate(
            {**surfaces[name], **_known(pair)},
            seconds=request.seconds,
            seed=child_seed(request.seed, "clone", number),
        )
        request.progress("generate", number, len(at))
        yield _stroke(name, made, *pair, simulated=True)


def _stroke(
    name: str, signal: Any, speed: float | None, force: float | None, *, simulated: bool
) -> Recording:
    return Recording(
        streams={"acceleration": signal},
        material=name,
        speed_mm_s=speed,
        force_n=force,
        simulated=simulated,
        source="-".join([name, *(f"{value:g}" for value in (speed, force) if value is not None)]),
    )

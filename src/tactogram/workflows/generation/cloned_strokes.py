"""Strokes of cloned surfaces: generated at many speeds and forces from what describes one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import Recording
from tactogram.errors import Message, ParameterError, Remedy
from tactogram.model import Condition
from tactogram.signal import Signal
from tactogram.signal.io import read_image, read_signal
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.texture_map import NAMES, NoiseMap
from tactogram.training.seeds import child_seed
from tactogram.workflows.generation.generate import limits, within
from tactogram.workflows.generation.word_scores import some_words
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import LoadedRun

SPEEDS_MM_S, FORCES_N = (30.0, 60.0, 120.0, 240.0, 400.0), (0.3, 1.0, 3.0)
"""Of the strokes that a clone is made of."""
STROKE_S = 4.0
"""Length of each, s."""
WORDS = "words"
"""Material of the surface that words describe."""
LEAST_S = 1.0
"""Shortest recording that is itself a stroke of its clone."""


def live_map(
    run: LoadedRun, condition: Condition, ranges: Mapping[str, tuple[float, float]], *, seed: int = 0
) -> NoiseMap:
    """Return a surface over speed and force, to be streamed: a clone that is not stored.

    ``condition`` describes it to a run that predicts surfaces within ``ranges`` (`Model.predicted_ranges`).
    """
    pairs, described = _grid((SPEEDS_MM_S, FORCES_N), ranges), within(run, condition)
    strokes = [
        run.generate(
            {**described, **_known(pair)},
            seconds=STROKE_S,
            seed=child_seed(seed, "clone", number),
        )
        for number, pair in enumerate(pairs, start=1)
    ]
    models = [fit_modulated_noise(stroke) for stroke in strokes if isinstance(stroke, Signal)]
    return NoiseMap(models, np.array(pairs, np.float64))


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


def described_surfaces(
    loaded: LoadedRun,
    *,
    recordings: Sequence[Path | str],
    reading: Mapping[str, Any],
    speed: float | None,
    force: float | None,
    images: Sequence[Path | str],
    materials: Sequence[str],
    words: Mapping[str, float] | None,
) -> tuple[dict[str, Mapping[str, Any]], list[str]]:
    """Return the condition that describes each surface, by name, and what is outside of what the model learned."""
    limited: list[str] = []
    surfaces: dict[str, Mapping[str, Any]] = {}
    known = {"vibration_speed_mm_s": speed, "vibration_force_n": force}
    names = [
        *(Path(file).stem for file in (*recordings, *images)),
        *materials,
        *([WORDS] if words else []),
    ]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ParameterError(
            f"recordings, photographs, materials and words must have different names, got {twice[0]!r} twice"
        )
    for file in map(Path, recordings):
        recording = read_signal(file, **reading)
        surfaces[file.stem] = {"vibration": loaded.prepare_vibration(recording), **known}
        notes = *limits(loaded, known), *loaded.missing_band(recording)
        limited += [Message(note, place=file.stem) for note in notes]
    surfaces |= {Path(file).stem: {"image": read_image(file)} for file in images}
    surfaces |= {name: {"material": name} for name in materials}
    if words:
        asked = {"words": some_words(loaded, words)}
        surfaces[WORDS], limited = within(loaded, asked), [*limited, *map(str, limits(loaded, asked))]
    if not surfaces:
        others = (Remedy("", name) for name in ("images", "materials", "words"))
        raise ParameterError("nothing to clone", remedy=(Remedy("give a recording of a surface"), *others))
    return surfaces, limited


def strokes_of(
    loaded: LoadedRun,
    surfaces: Mapping[str, Mapping[str, Any]],
    ranges: Mapping[str, tuple[float, float]],
    *,
    recorded_at: tuple[float | None, float | None],
    speeds: Sequence[float],
    forces: Sequence[float],
    seconds: float,
    seed: int,
    progress: ProgressCallback,
) -> Iterator[Recording]:
    """Yield the strokes of each surface: its recording, if its speed is known, and those generated."""
    grid = _grid((speeds, forces), ranges)
    pressed = sorted({force for _, force in grid if force is not None})
    middle = pressed[len(pressed) // 2] if pressed else None
    known_speed, known_force = recorded_at
    recorded = {
        name: (known_speed, known_force or middle)
        for name, condition in surfaces.items()
        if known_speed and "vibration" in condition and condition["vibration"].seconds >= LEAST_S
    }
    for name, (speed, force) in recorded.items():
        yield _stroke(name, surfaces[name]["vibration"], speed, force, simulated=False)
    planned = [(name, pair) for name in surfaces for pair in grid]
    for number, (name, pair) in enumerate(planned, start=1):
        if recorded.get(name) == pair:
            continue
        stroke = loaded.generate(
            {**surfaces[name], **_known(pair)},
            seconds=seconds,
            seed=child_seed(seed, "clone", number),
        )
        progress("generate", number, len(planned))
        yield _stroke(name, stroke, *pair, simulated=True)


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

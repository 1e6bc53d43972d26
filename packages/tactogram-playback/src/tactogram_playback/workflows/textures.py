"""Textures for a stream out of runs and files: tables over speed and force, or surfaces to move over."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tactogram.errors import ParameterError, Remedy
from tactogram.model import Condition, material_weights, some_of
from tactogram.models import shipped_run
from tactogram.rendering import combined
from tactogram.signal import NoiseMap, Signal, TextureMap
from tactogram.signal.io import read_metadata, read_signal
from tactogram_playback.streaming.noise_texture import ModulatedNoiseTexture, NoiseTable
from tactogram_playback.streaming.texture_table import TextureTable
from tactogram_playback.streaming.textures import (
    Along,
    AutoregressiveTexture,
    StreamingTexture,
    SurfaceTexture,
)

if TYPE_CHECKING:
    from tactogram.workflows import LoadedRun

MOST_TEXTURES = 16
"""Largest number of textures streamed together without a mix."""


@dataclass(frozen=True)
class TextureSettings:
    """Settings by which sources become textures for an engine at ``rate`` (Hz), in blocks of ``most`` samples.

    ``axes`` is how several axes become one: dft321, mean (of signals) or the name of one; ``speed_mm_s`` that at which
    signals over time were recorded, or are generated; ``along`` what a surface is laid out over; ``seconds`` the length
    of a generated signal, by default the model's own.
    """

    rate: float
    most: int
    axes: str = "dft321"
    speed_mm_s: float | None = None
    along: Along = "path"
    seconds: float | None = None
    seed: int = 0


def textures_of(
    sources: Sequence[str | Path],
    names: Sequence[str],
    settings: TextureSettings,
    **options: Any,
) -> tuple[list[StreamingTexture], bool]:
    """Return the textures of runs and files, and whether any was learned or recorded from a simulation.

    ``sources``: run folders (of generators) and signal files; ``options`` are passed to `read_signal`. ``names``:
    materials and file stems that are wanted; all where empty.

    Raises `ParameterError` if a name is in no source, or no names are given and there are too many textures.
    """
    # With torch, which surfaces do without.
    from tactogram.workflows import load_run

    textures: list[StreamingTexture] = []
    simulated = False
    known: list[str] = []
    for number, source in enumerate(sources):
        path = Path(source)
        if path.is_dir() or shipped_run(str(source)):
            run = load_run(path)
            offered: Sequence[str] = run.kind.materials
            chosen = [name for name in offered if not names or name in names]
            if not names and len(chosen) > MOST_TEXTURES:
                remedy = Remedy(f"choose {some_of(offered)}, with", "mix")
                raise ParameterError(path, f"has {len(chosen)} materials", remedy=remedy)
            added = [_of_run(run, name, settings, number) for name in chosen]
            simulated = simulated or run.simulated
        else:
            offered = (path.stem,)
            is_chosen = not names or path.stem in names
            added = [_of_file(path, settings, options)] if is_chosen else []
            simulated = simulated or bool(is_chosen and read_metadata(path).get("simulated"))
        known += offered
        textures += added
    missing = [name for name in names if name not in known]
    if missing:
        name = missing[0]
        raise ParameterError.must("mix", f"be {some_of(known, like=name)}", name, choices=known)
    return textures, simulated


def _of_run(run: LoadedRun, name: str, settings: TextureSettings, number: int) -> StreamingTexture:
    """Return one material of a run: over speed and force where it can, or else a signal that it generates."""
    condition: dict[str, Any] = {"material": {name: 1.0}}
    if texture := live_texture(run, name, condition, settings, number):
        return texture
    from tactogram.workflows import generate

    if settings.speed_mm_s is not None and "speed_mm_s" in run.facts.conditions:
        condition["speed_mm_s"] = settings.speed_mm_s
    signal = next(iter(generate(run, condition, seconds=settings.seconds, seed=settings.seed)))
    if not isinstance(signal, Signal):
        raise ParameterError(f"{run.run.name}: {run.facts.name} makes images; a stream needs signals")
    return surface_of(name, signal, settings, settings.speed_mm_s)


def live_texture(
    run: LoadedRun, name: str, condition: Condition, settings: TextureSettings, number: int = 0
) -> AutoregressiveTexture | ModulatedNoiseTexture | None:
    """Return what ``condition`` describes as a texture over speed and force; None if the run only generates signals.

    Of a run whose materials are such maps ``condition`` is one material; one that predicts surfaces at any speed and
    force (`Model.predicted_ranges`) is cloned. ``number`` varies the seed.
    """
    from tactogram.training import surface_seed

    seed = settings.seed + 1000 * number
    own = surface_seed(seed, condition)
    if run.model.maps:
        index = int(np.argmax(material_weights(condition, run.kind.materials)))
        return texture_of_map(name, run.model.maps[index], settings, seed=own)
    ranges = run.model.predicted_ranges
    if not ranges:
        return None
    from tactogram.workflows import live_map

    return texture_of_map(name, live_map(run, condition, ranges, seed=seed), settings, seed=own)


def texture_of_map(
    name: str, surface: TextureMap | NoiseMap, settings: TextureSettings, *, seed: int = 0
) -> AutoregressiveTexture | ModulatedNoiseTexture:
    """Return a map over speed and force as a texture."""
    rate, most = settings.rate, settings.most
    if isinstance(surface, NoiseMap):
        noise = NoiseTable(surface, axis=settings.axes)
        return ModulatedNoiseTexture(name, noise, rate=rate, most=most, seed=seed)
    table = TextureTable(surface, axis=settings.axes)
    return AutoregressiveTexture(name, table, rate=rate, most=most, seed=seed)


def _of_file(path: Path, settings: TextureSettings, options: Mapping[str, Any]) -> StreamingTexture:
    recorded = read_metadata(path).get("speed_mm_s")
    speed = settings.speed_mm_s if settings.speed_mm_s is not None else recorded
    return surface_of(path.stem, read_signal(path, **options), settings, speed)


def surface_of(
    name: str, signal: Signal, settings: TextureSettings, speed_mm_s: float | None
) -> SurfaceTexture:
    """Return a signal as a surface; one over time needs the speed at which it was recorded."""
    single_axis, _ = combined(signal, settings.axes)
    speed = speed_mm_s if signal.domain == "time" else None
    return SurfaceTexture(name, single_axis, rate=settings.rate, speed_mm_s=speed, along=settings.along)

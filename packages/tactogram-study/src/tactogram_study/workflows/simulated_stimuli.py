"""Simulated recordings and pictures of a study's stimuli, and recordings drawn or reconstructed from others."""

from __future__ import annotations

import zlib
from dataclasses import replace
from functools import lru_cache

import tactogram_simulate as simulate
from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal
from tactogram_study.stimuli import Stimulus

SEEDS = 16
"""Number of pictures of each simulated family for ``any/TEXT``."""


@lru_cache(maxsize=64)
def simulated_signal(text: str, seed: int, seconds: float | None) -> Signal:
    """Return the vibration, or else the first stream, of the first recording of a simulated material."""
    set_name, surface = simulated_surface(text)
    listed = simulate.tasks(set_name, seed=seed, per_class=1, own_images=False)
    chosen = next(task for task in listed if task.surface == surface)
    # At least one stroke is simulated; the requested length is cut from its middle, where the finger moves.
    simulated_s = chosen.seconds if seconds is None else max(seconds, min(chosen.seconds, 2 * seconds))
    streams = simulate.make(replace(chosen, seconds=min(simulated_s, 10.0))).streams
    signal = streams.get("acceleration") or next(iter(streams.values()))
    length = len(signal) if seconds is None else min(len(signal), round(seconds * signal.rate))
    start = (len(signal) - length) // 2
    return signal.cut(start, start + length)


def simulated_surface(text: str) -> tuple[str, int]:
    """Return the set of a simulated material, and its index there."""
    set_name, _, material = text.partition("/")
    if set_name not in simulate.SETS:
        raise ParameterError(f"simulated set must be one of {', '.join(simulate.SETS)}, got {set_name!r}")
    names = [surface.name for surface in simulate.SETS[set_name].surfaces]
    if material not in names:
        known = ", ".join(names) or "none"
        raise ParameterError.must("simulated", f"be SET/MATERIAL; {set_name} has {known}", text)
    return set_name, names.index(material)


def simulated_image(text: str, seed: int) -> Image:
    """Return a simulated picture, FAMILY/NUMBER; ``any/TEXT`` draws both by the text."""
    family, number = image_family(text)
    if family == "any":
        drawn = zlib.crc32(number.encode())
        families = list(simulate.FAMILIES)
        return simulate.tactile_image(
            families[drawn % len(families)], drawn // len(families) % SEEDS, seed=seed
        )
    return simulate.tactile_image(family, int(number), seed=seed)


def image_family(text: str) -> tuple[str, str]:
    """Return the family of a simulated picture, and its number there."""
    family, _, number = text.partition("/")
    if family != "any" and (family not in simulate.FAMILIES or not number.isdigit()):
        known = ", ".join(simulate.FAMILIES)
        raise ParameterError.must("simulated_image", f"be FAMILY/NUMBER with a family of {known}", text)
    return family, number


def autoregressive_signal(signal: Signal, stimulus: Stimulus) -> Signal:
    """Return a signal drawn from the autoregressive model of a recording, over displacement as over time."""
    from tactogram.signal import fit_autoregressive, synthesise
    from tactogram.training import surface_seed

    model = fit_autoregressive(replace(signal, domain="time"))  # a model only counts samples
    seed = surface_seed(stimulus.seed, {"vibration": signal})
    return replace(synthesise(model, stimulus.seconds or signal.extent, seed=seed), domain=signal.domain)


def reconstruction(signal: Signal, stimulus: Stimulus) -> Signal:
    """Return a recording as it is after its spectrogram picture, with a phase that is recovered."""
    from tactogram.features import reconstructed  # loads torch

    if stimulus.reconstructed == "griffin_lim":
        return reconstructed(signal, start="random", iteration="griffin_lim", seed=stimulus.seed)
    return reconstructed(signal, start="gradient", iteration="admm+fast_griffin_lim", seed=stimulus.seed)

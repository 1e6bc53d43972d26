"""Tonal surfaces: noise, which the network generates, and the tones of ribs and weaves, which it does not.

The magnitudes of a spectrogram do not keep a line steady. So tones are taken out of recordings before these are
measured, and added to what is generated (`tactogram.signal.tones`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.model import Example
from tactogram.models.texture_flow.surfaces import Surface
from tactogram.signal import Signal
from tactogram.signal.modulated_noise import LEAST_RATE, band_edges
from tactogram.signal.texture_map import group_by_condition
from tactogram.signal.tone_fit import split_tones
from tactogram.signal.tones import ARRAYS, Tones, join_tones

Array = NDArray[np.float64]

MOST_PATTERNS = 8
"""Strokes of a surface whose tones are kept."""


class TonalSurface(NamedTuple):
    """A surface without its tones, these, the mean square of a signal per power of its surface, and its clicks."""

    surface: Surface
    tones: Tones
    scale: float
    local: Array | None = None
    """Quantiles of `tactogram.signal.local_amplitudes`, None if unknown: over displacement, and in runs of 0.1.0."""

    @property
    def power(self) -> float:
        """Mean square of all axes."""
        return float(self.scale * self.surface.power + self.tones.power.sum())

    @staticmethod
    def mixed(members: Sequence[TonalSurface], weights: Array) -> TonalSurface:
        """Return a mix: noise as in `Surface.mixed`, tones in amplitude, the power of both as the mean in dB."""
        share = weights / weights.sum()
        noise = Surface.mixed([member.surface for member in members], weights)
        tones = join_tones([member.tones for member in members], share)
        known = [member.local for member in members if member.local is not None]
        local = np.tensordot(share, known, 1) if len(known) == len(members) else None
        mix = TonalSurface(noise, tones, members[0].scale, local)
        if not len(tones.frequency):
            return mix
        gain = 0.5 * float(share @ np.log([member.power for member in members]) - np.log(mix.power))
        axes = len(noise.mean)
        louder = noise._replace(log_root=noise.log_root + gain * torch.eye(axes))
        return mix._replace(surface=louder, tones=tones.scaled(np.full(axes, np.exp(gain))))


@dataclass(frozen=True, eq=False)
class StrokeTones:
    """Tones of one stroke of a surface.

    Attributes
    ----------
    tones : Tones
    speed_mm_s : float
        NaN if unknown.
    noise : float
        Mean square of all axes of the noise that they are in.
    """

    tones: Tones
    speed_mm_s: float
    noise: float

    def at(self, speed_mm_s: float | None, noise: float, rate: float) -> Tones:
        """Return the tones at a speed, None if unknown, with the power over ``noise`` that they had."""
        ratio = 1.0 if speed_mm_s is None or not self.speed_mm_s > 0 else speed_mm_s / self.speed_mm_s
        gain = np.sqrt(noise / self.noise) if self.noise > 0 else 1.0
        moved = self.tones.moved(ratio, band_edges(rate)[[0, -1]])
        return moved.scaled(np.full(moved.amplitude.shape[1], gain))

    def state(self) -> dict[str, Tensor]:
        """Return the arrays."""
        numbers = torch.tensor([self.speed_mm_s, self.noise], dtype=torch.float64)
        return {"numbers": numbers} | {name: torch.from_numpy(getattr(self.tones, name)) for name in ARRAYS}

    @staticmethod
    def from_state(state: Mapping[str, Any]) -> StrokeTones:
        """Return the tones of `state`."""
        tones = Tones(*(np.asarray(state[name], np.float64) for name in ARRAYS))
        return StrokeTones(tones, *map(float, state["numbers"]))


def split_strokes(examples: Sequence[Example]) -> tuple[list[StrokeTones], list[Example]]:
    """Return the tones of strokes of one surface, at most `MOST_PATTERNS`, and the strokes without theirs.

    The ratio of their power to that of the noise is that of the means over all strokes. Speeds and forces take turns,
    first that at which tones stand out most from the noise. What is left of tonal strokes has one mean, as the offsets
    of a sensor may differ by more than this noise.
    """
    speeds, groups = group_by_condition([example.condition for example in examples])
    by_group: list[list[Tones]] = []
    rest = list(examples)
    noise_power = np.empty(len(groups))
    for number, members in enumerate(groups):
        patterns, noise = split_signals([examples[member].signal for member in members])
        by_group.append(patterns if len(patterns) < 2 else [tones.at_its_own_speed() for tones in patterns])
        noise_power[number] = np.mean(
            [np.var(signal.samples, axis=1, dtype=np.float64).sum() for signal in noise]
        )
        for index, signal in zip(members, noise, strict=True):
            rest[index] = replace(examples[index], signal=signal)
    power = np.array([patterns[0].power.sum() if patterns else 0.0 for patterns in by_group])
    if not power.any():
        return [], rest
    strokes = [len(members) for members in groups]
    ratio = float(np.average(noise_power, weights=strokes) / np.average(power, weights=strokes))
    order = np.argsort(-power / np.maximum(noise_power, np.finfo(float).tiny), kind="stable")
    known = [
        StrokeTones(by_group[group][turn], float(speeds[group, 0]), float(power[group] * ratio))
        for turn in range(max(map(len, by_group)))
        for group in order
        if turn < len(by_group[group])
    ]
    means = [example.signal.samples.mean(1, keepdims=True, dtype=np.float64) for example in rest]
    return known[:MOST_PATTERNS], [
        _shifted(example, np.mean(means, 0) - own) for example, own in zip(rest, means, strict=True)
    ]


def _shifted(example: Example, offset: Array) -> Example:
    signal = example.signal
    return replace(example, signal=signal.with_samples((signal.samples + offset).astype(np.float32)))


def split_signals(signals: Sequence[Signal]) -> tuple[list[Tones], list[Signal]]:
    """Return the tones of signals of one texture, and the signals without theirs; over displacement there are none."""
    first = signals[0]
    if first.domain != "time" or first.rate < LEAST_RATE:
        return [], list(signals)
    means = [signal.samples.mean(1, keepdims=True, dtype=np.float64) for signal in signals]
    centred = [signal.samples - mean for signal, mean in zip(signals, means, strict=True)]
    tones, rest = split_tones(centred, first.rate, band=band_edges(first.rate)[[0, -1]])
    return tones, [
        signal if noise is x else signal.with_samples((noise + mean).astype(np.float32))
        for signal, noise, x, mean in zip(signals, rest, centred, means, strict=True)
    ]

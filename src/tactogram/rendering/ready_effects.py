"""Ready effects of designers, from a click to rain, as events."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.features.text_classifier import plain
from tactogram.model.conditions import some_of
from tactogram.parameters import Positive, Share, checked
from tactogram.rendering.files.events import PULSE_S, Events, Part, Transient
from tactogram.text_files import read_toml

FILE = Path(__file__).with_suffix(".toml")
LONGEST_S = 600.0
"""Longest effect, s."""
Points = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class RandomTransients:
    """Transients at random times: most are of the lower of two amplitudes, their frequencies between two, Hz."""

    per_second: float
    amplitude: tuple[float, float]
    frequency: tuple[float, float]
    seconds: float

    def points(self, seconds: float, rng: np.random.Generator) -> Points:
        """Return times (s), amplitudes and frequencies (Hz), no closer than a transient lasts."""
        gaps = PULSE_S + rng.exponential(1 / self.per_second - PULSE_S, int(seconds / PULSE_S) + 1)
        times = np.cumsum(gaps) - gaps[0]
        times = times[times <= seconds - PULSE_S]
        shares, (low, high) = rng.random(len(times)) ** 3, self.amplitude
        hz = rng.uniform(*self.frequency, len(times))
        columns = np.round([times, low + shares * (high - low), hz], 4)
        return tuple(map(tuple, columns.T.tolist()))


@dataclass(frozen=True)
class ReadyEffect:
    """An effect: points of its amplitude and frequency (s; 0 to 1, Hz), transients, and how it is repeated.

    Amplitudes of ``transients`` (s, amplitude, Hz) are added to the vibration's. ``also`` are other names.
    """

    title: str
    about: str
    also: tuple[str, ...] = ()
    amplitude: Points = ()
    frequency: Points = ((0.0, 0.0),)
    transients: Points = ()
    times: int = 1
    every: float = 0.0
    vary: float = 0.0
    random: RandomTransients | None = None

    @property
    def name(self) -> str:
        """Its name on the command line."""
        return self.title.lower().replace(" ", "-")

    @property
    def seconds(self) -> float:
        """Its own length, s."""
        return self.events().seconds

    def events(self, seconds: float | None = None, strength: float = 1.0, seed: int = 0) -> Events:
        """Return the effect as `effect` does."""
        rng, times, factor, transients = np.random.default_rng(seed), self.times, 1.0, self.transients
        if self.random:
            seconds = seconds or self.random.seconds
            transients = self.random.points(seconds, rng)
        elif seconds and self.every:
            times = int(seconds / self.every + 1e-9)
            if not times:
                raise ParameterError.must("seconds", f"be >= {self.every:g} for {self.name}", seconds)
        elif seconds and not self.amplitude:
            raise ParameterError(f"cannot change the length of {self.name}; omit it", parameter="seconds")
        elif seconds:
            factor = seconds / self.amplitude[-1][0]
        lines: list[list[tuple[float, ...]]] = [[], [], []]
        for number in range(times):
            late, weaker = (self.vary * rng.random(2)).tolist()
            start, gain = self.every * (number + late * (number > 0)), 1 - weaker
            lines[0] += [(start + factor * time, gain * value) for time, value in self.amplitude]
            lines[1] += [(start + factor * time, hz) for time, hz in self.frequency]
            lines[2] += [(start + factor * time, gain * value, hz) for time, value, hz in transients]
        parts = [Part.of(*np.transpose(lines[0]), *np.transpose(lines[1]))] if lines[0] else []
        taps = [
            Transient(time, value + sum(float(part.at(time)) for part in parts), hz)
            for time, value, hz in lines[2]
        ]
        return Events.of(parts, taps, seconds or 0.0).scaled(strength)


@cache
def effects() -> Mapping[str, ReadyEffect]:
    """Return the ready effects by name, each with ``about``, ``also`` (other names) and ``seconds``.

    >>> len(tactogram.effects()), tactogram.effects()["click"].about
    (32, 'a key: a sharp press and a weaker release')
    """
    ready = [
        ReadyEffect(**{name: _frozen(value) for name, value in values.items()})
        for values in read_toml(FILE)["effect"]
    ]
    return {each.name: each for each in ready}


@checked
def effect(name: str, *, seconds: Positive | None = None, strength: Share = 1.0, seed: int = 0) -> Events:
    """Return a ready effect as events, which `tactogram.rendering.write_haptic` writes and `carrier` plays.

    Parameters
    ----------
    name : str
        One of `effects`, or another name of it, such as "button press".
    seconds : float, optional
        Length; what repeats is repeated, a single vibration stretched; that of single transients is fixed.
    strength : float
        Factor of all amplitudes, 0 to 1.
    seed : int
        Of what is drawn: drops of rain, strokes of an engine.

    Returns
    -------
    Events

    Raises
    ------
    ParameterError
        If there is no such effect, or it cannot be so long.

    Examples
    --------
    >>> beats = tactogram.effect("heartbeat", seconds=5, strength=0.8)
    >>> beats.seconds, round(beats.peak, 2)
    (5.0, 0.72)
    >>> [round(tap.amplitude, 2) for tap in tactogram.effect("button press").transients]
    [0.9, 0.35]
    """
    if seconds is not None and seconds > LONGEST_S:
        raise ParameterError.must("seconds", f"be at most {LONGEST_S:g}", seconds)
    if seed < 0:
        raise ParameterError.must("seed", "be >= 0", seed)
    return find_effect(name).events(seconds, strength, seed)


def find_effect(name: str) -> ReadyEffect:
    """Return an effect by any of its names; `ParameterError` with the nearest names if there is none."""
    called = {plain(word): each for each in effects().values() for word in (each.name, *each.also)}
    if plain(name) in called:
        return called[plain(name)]
    raise ParameterError.must("name", f"be {some_of(tuple(effects()), like=name)}", name, choices=called)


def _frozen(value: Any) -> Any:
    if isinstance(value, dict):
        return RandomTransients(**value)
    return tuple(map(_frozen, value)) if isinstance(value, list) else value

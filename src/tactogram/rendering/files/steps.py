"""Steps of strength, which several formats hold instead of lines: transients as short steps."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import sample_count
from tactogram.rendering.files.events import JUMP_S, Events, Line, Transient, stepped

TAP_MS = 60
"""Longest transient, ms: an eccentric motor has hardly shorter ones. A choice, for phones as for game pads."""


@dataclass(frozen=True)
class Pulse(Transient):
    """A transient whose length a file states, s."""

    seconds: float


@dataclass(frozen=True)
class StepRules:
    """Lengths of a format's steps, in ms.

    A vibration changes every ``step_ms``. A transient is a step of ``pulse_ms``, which is no multiple of it, so that it
    can be distinguished, or as long as a `Pulse` states, at least ``least_ms``; the next one is at least ``gap_ms``
    away, or the stronger of the two counts. When a file is read, a step of ``least_ms`` to ``tap_ms`` between silences
    is a transient, too.
    """

    step_ms: int
    pulse_ms: int
    gap_ms: int
    tap_ms: int
    levels: int
    least_ms: int = 0

    def write(self, events: Events, *, what: str, first_ms: int = 0) -> tuple[NDArray[np.int64], Line]:
        """Return the edges of steps, ms, and the strength in each, rounded to ``levels``.

        ``what`` names the format in errors. The first step ends at ``first_ms``, if any: a vibration that begins, jumps
        or ends adds an edge otherwise. Raises `ParameterError` if the events last less than 1 ms, or too long.
        """
        sample_count(events.seconds, 1e3)
        taps = self.pulses(events) if self.pulse_ms else []
        length = max([round(1e3 * events.seconds), *(end for _, end, _ in taps)])
        if length < 1:
            raise ParameterError(f"{what} needs at least 1 ms, got {events.seconds:g} s")
        whole = events.joined.within(0.0, length / 1e3)
        fixed = np.array([0, first_ms, length])
        if not first_ms:
            jumps, sounds = (np.diff(whole.times) <= 2 * JUMP_S), np.diff(whole.amplitude > 0)
            bends = np.append(jumps | sounds, False) | np.append(False, sounds)
            fixed = np.append(fixed, np.rint(1e3 * whole.times[bends]))
        edges = np.unique(fixed).astype(np.int64)
        last = 0 if first_ms else self.step_ms / 2
        grid = [np.arange(a, b - last, self.step_ms) for a, b in pairwise(edges.tolist())]
        edges = np.unique(np.concatenate([edges, *grid])).astype(np.int64)
        for start, end, _ in taps:
            edges = np.union1d(edges[(edges <= start) | (edges >= end)], [start, end])
        strength = np.minimum(whole.at((edges[:-1] + edges[1:]) / 2e3), 1)
        for start, _, amplitude in taps:
            i = int(np.searchsorted(edges, start))
            strength[i] = max(strength[i], amplitude)
        strength = np.rint(self.levels * strength) / self.levels
        first = np.flatnonzero(np.diff(strength, prepend=-1))
        return np.append(edges[first], length), strength[first]

    def taps(self, events: Events) -> list[tuple[int, float]]:
        """Return the beginning, ms, and the strength of each transient that has room."""
        return [(start, strength) for start, _, strength in self.pulses(events)]

    def pulses(self, events: Events) -> list[tuple[int, int, float]]:
        """Return the beginning and the end, ms, and the strength of each transient that has room."""
        taps: list[tuple[int, int, float]] = []
        for one in events.transients:
            start, end = span_ms(one, self.pulse_ms, self.least_ms)
            gap = 1 if isinstance(one, Pulse) else self.gap_ms
            if taps and start < taps[-1][1] + gap:
                taps[-1] = (*taps[-1][:2], max(taps[-1][2], min(1.0, one.amplitude)))
            else:
                taps.append((start, end, min(1.0, one.amplitude)))
        return taps

    def read(self, edges: Line, strength: Line, hz: float) -> Events:
        """Return the events of steps between ``edges`` (s): runs of steps above 0, and transients."""
        lasting = np.diff(edges) > 0
        starts, strength = edges[:-1][lasting], np.asarray(strength)[lasting]
        first = np.flatnonzero(np.diff(strength, prepend=-1))
        edges, strength = np.append(starts[first], edges[-1]), strength[first]
        ms = np.rint(1e3 * np.diff(edges))
        before, after = np.append(0.0, strength[:-1]), np.append(strength[1:], 0.0)
        alone = (before == 0) & (after == 0) & (ms >= self.least_ms) & (ms <= self.tap_ms)
        peak = (ms == self.pulse_ms) & (strength > before) & (strength > after)
        tap = (strength > 0) & (alone | peak)
        under = np.where(tap, np.minimum(before, after), strength)
        runs = np.split(np.arange(len(under)), np.flatnonzero(np.diff(under > 0)) + 1)
        return Events.of(
            (stepped(edges[run[0] : run[-1] + 2], under[run], hz) for run in runs if under[run].any()),
            (Pulse(*map(float, (edges[i], strength[i], hz, ms[i] / 1e3))) for i in np.flatnonzero(tap)),
            float(edges[-1]),
        )


def span_ms(one: Transient, usual: int, least: int = 0) -> tuple[int, int]:
    """Return the beginning and the end of a transient, ms, of ``usual`` length where it states none."""
    start = round(1e3 * one.time)
    return start, start + (max(least, round(1e3 * one.seconds)) if isinstance(one, Pulse) else usual)

"""Control points of an envelope: few straight lines of amplitude and frequency, as Android 16's builders take them.

The limits are those that are taken to hold on every phone with envelopes; `VibratorEnvelopeEffectInfo` states a phone's
own. An effect begins at amplitude 0, and each point states how long the line to it takes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.files.analysis import HIGHEST_HZ
from tactogram.rendering.files.catalogue import HapticFormat
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, has_key, sample_count
from tactogram.rendering.files.events import (
    JUMP_S,
    STEP_S,
    Events,
    FrequencySpan,
    Line,
    Part,
    Transient,
    stepped,
    thinned,
)

MOST_POINTS = 16
SHORTEST_MS, LONGEST_MS = 20, 1000
"""Shortest and longest line, ms."""
MOVED_S = SHORTEST_MS / 2e3
"""By how much a transient may be moved, so that the line before it is not too short."""
CLOSE = 0.02
"""Fewer points are used where they come this close (rms) to the envelope, relative to its peak. A choice."""
CLOSE_OCTAVES = 0.1
STEPS = round(SHORTEST_MS / 1e3 / STEP_S)
"""Points of the analysed envelope in the shortest line."""
TAP_MS = 60
"""Longest transient, ms: an eccentric motor has hardly shorter ones. A choice, for phones as for game pads."""


@dataclass(frozen=True)
class EnvelopeBuilder:
    """One of Android's builders, whose calls are a document.

    ``point`` are the names of a call's amplitude, frequency and duration, ``start`` that of the first frequency, a
    share of ``span`` if there is one. An effect of shares ends at 0.
    """

    title: str
    format: str
    point: tuple[str, str, str]
    start: str
    span: FrequencySpan | None = None

    def haptic_format(self, name: str, instead: Mapping[str, str]) -> HapticFormat:
        """Return the format of these documents."""
        return HapticFormat(
            name=name,
            title=self.title,
            suffix=".json",
            engine="Android",
            holds="envelope",
            encode=self.encode,
            decode=self.decode,
            bands=((0.0, HIGHEST_HZ),),  # all that is felt, without transients, which take two lines each
            recognise=self.recognise,
            resolution_s=MOVED_S,
            instead=instead,
        )

    def recognise(self, document: Any) -> bool:
        """Return whether a document has control points, the first of them with a frequency of this kind."""
        points = document.get("controlPoints") if isinstance(document, dict) else None
        return isinstance(points, list) and bool(points) and has_key(self.point[1])(points[0])

    def encode(self, events: Events, header: DocumentHeader) -> dict[str, Any]:
        """Return the document of events within 0 to 1."""
        points, span = control_points(events, what=self.title), self.span and (events.span or self.span)
        hz = points.frequency
        first, *tones = (np.round(span.share(hz), 4) if span else np.round(hz, 1)).tolist()
        ms = np.rint(1e3 * np.diff(points.times)).astype(int).tolist()
        calls = zip(np.round(points.amplitude[1:], 4).tolist(), tones, ms, strict=True)
        listed = [dict(zip(self.point, call, strict=True)) for call in calls]
        about = {"format": self.format, self.start: first, "controlPoints": listed}
        return about | {"description": header.description}

    def decode(self, document: Node) -> DecodedDocument:
        """Return the events: lines, and as transients what rises and falls back to a level in the shortest lines."""
        notes, most = document.notes, 1.0 if self.span else np.inf
        bounds = dict(zip(self.point, (1.0, most, np.inf), strict=True))
        points = [
            tuple(point.number(name, None, 0.0, high) for name, high in bounds.items())
            for point in document.nodes("controlPoints")
        ]
        if not points:
            notes.problems.append("controlPoints: must not be empty")
        notes.check()
        if len(points) > MOST_POINTS:
            notes.warn(f"an effect must have at most {MOST_POINTS} points", len(points), "phones differ")
        for ms in (ms for _, _, ms in points if not SHORTEST_MS <= ms <= LONGEST_MS):
            notes.warn(f"{self.point[2]} must be {SHORTEST_MS} to {LONGEST_MS}", f"{ms:g}", "phones differ")
        if self.span and points[-1][0] > 0:
            notes.warn(f"the last control point must have an {self.point[0]} of 0", f"{points[-1][0]:g}")
        first = document.number(self.start, points[0][1], 0.0, most)
        amplitude, hz, durations = np.array([(0.0, first, 0.0), *points]).T
        times, hz = np.cumsum(durations) / 1e3, self.span.hz(hz) if self.span else hz
        short = np.append(durations[1:] <= SHORTEST_MS, False)
        before, after = np.append(0.0, amplitude[:-1]), np.append(amplitude[1:], 0.0)
        peak = np.append(False, short[:-1] & short[1:]) & (amplitude > before) & (before == after)
        taps = [Transient(*map(float, (times[i - 1], amplitude[i], hz[i]))) for i in np.flatnonzero(peak)]
        part = Part.of(times, np.where(peak, before, amplitude), times, hz)
        events = Events.of([part], taps, float(times[-1]), self.span)
        return DecodedDocument(events, document.text("description"), self.point[1])


def control_points(events: Events, *, what: str) -> Part:
    """Return events as one vibration of `MOST_POINTS` or fewer lines between whole ms, from and to amplitude 0.

    Events of few points keep them, and a transient is a peak of two lines; if there are too many, the strongest are
    kept. Others become the lines that are closest to strength and frequency. ``what`` names the result in errors.
    Raises `ParameterError` if they are too short or too long.
    """
    length = round(1e3 * events.seconds)
    for start, _ in _rises(events.transients)[-1:]:
        rest = length - start - 2 * SHORTEST_MS
        length = start + 2 * SHORTEST_MS + (max(rest, SHORTEST_MS) if rest > 0 else 0)
    if not 2 * SHORTEST_MS <= length <= MOST_POINTS * LONGEST_MS:
        raise ParameterError(
            f"{what} lasts {2 * SHORTEST_MS} to {MOST_POINTS * LONGEST_MS} ms, got {length} ms; cut it, or use a "
            "format without that limit"
        )
    taps = sorted(events.transients, key=lambda tap: -tap.amplitude)
    designed = taps or len(events.joined.times) <= 4 * MOST_POINTS
    least = len(taps) // 2 if events.parts else min(1, len(taps))
    for kept in range(min(len(taps), MOST_POINTS // 2), least - 1, -1) if designed else ():
        exact = _exact(replace(events, transients=tuple(taps[:kept])), length)
        if exact is not None:
            return exact
    return _closest(events, length)


def _rises(taps: Sequence[Transient]) -> list[tuple[int, Transient]]:
    """Return transients in order of time, each with the ms at which it begins to rise.

    That is its own time, or up to `MOVED_S` off it where the line before it would be shorter than any.
    """
    rises, free = [], 0
    for tap in sorted(taps, key=lambda tap: tap.time):
        start = round(1e3 * tap.time)
        if 0 < start - free < SHORTEST_MS:
            start = free + SHORTEST_MS * round((start - free) / SHORTEST_MS)
        rises.append((start, tap))
        free = start + 2 * SHORTEST_MS
    return rises


def _exact(events: Events, length: int) -> Part | None:
    """Return the lines through the points of an envelope and the peaks of transients; None if they do not fit."""
    whole = events.joined
    points = {0: (0.0, float(whole.hz(0.0))), length: (0.0, float(whole.hz(length / 1e3)))}
    part = whole.within(0.0, length / 1e3)
    octaves = np.log2(np.maximum(part.frequency, 1))
    bends = {*thinned(part.times, part.amplitude, CLOSE), *thinned(part.times, octaves, CLOSE_OCTAVES)}
    last = -SHORTEST_MS
    for i in sorted(bends) if whole.peak > 0 else ():
        time, amplitude = round(1e3 * float(part.times[i])), min(1.0, float(part.amplitude[i]))
        if amplitude > 0 or points.get(last, (0.0,))[0] > 0:
            # A jump takes the shortest line; the first and the last point are 0.
            time = min(max(time, last + SHORTEST_MS, SHORTEST_MS), length - SHORTEST_MS)
        last = max(time, last)
        points.setdefault(last, (amplitude, float(part.frequency[i])))
    for start, tap in _rises(events.transients):
        if any(start <= ms <= start + 2 * SHORTEST_MS and points[ms][0] > 0 for ms in points):
            return None
        under = min(1.0, float(whole.at((start + SHORTEST_MS) / 1e3)))
        shape = (under, max(under, tap.amplitude), under)
        points |= {start + i * SHORTEST_MS: (level, tap.frequency) for i, level in enumerate(shape)}
    places = sorted(points)
    amplitude, hz = np.array([points[ms] for ms in places]).T
    ends = [end for a, b in pairwise(places) for end in (*range(a, b, LONGEST_MS), b)]
    times = np.unique(ends)
    if len(times) - 1 > MOST_POINTS or np.diff(times).min() < SHORTEST_MS:
        return None
    return Part(times / 1e3, np.interp(times, places, amplitude), np.interp(times, places, hz))


def _closest(events: Events, length: int) -> Part:
    """Return the lines that are closest to the strength and the frequency of events.

    The ends are chosen on a grid of `SHORTEST_MS` by dynamic programming (Bellman 1961), then amplitudes and
    frequencies are fitted by least squares, those of the frequency weighted by the amplitude.
    """
    count = length // SHORTEST_MS
    grid = SHORTEST_MS * np.arange(count + 1)
    grid[-1] = length
    # The last line is stretched by up to a step.
    fine = np.interp(np.arange(STEPS * count + 1), STEPS * np.arange(count + 1), grid) / 1e3
    amplitude = np.minimum(events.strength(fine), 1)
    hz = np.maximum(events.joined.hz(fine), 1)
    for tap in events.transients:
        hz[slice(*np.searchsorted(fine, [tap.time, tap.time + SHORTEST_MS / 1e3]))] = max(tap.frequency, 1)
    times = grid[_chosen(amplitude, hz, grid)] / 1e3
    # Shares of the ends in the lines.
    lines = np.stack([np.interp(fine, times, unit) for unit in np.eye(len(times))], axis=1)
    fitted = np.zeros(len(times))
    free = slice(STEPS, -STEPS)
    fitted[1:-1] = np.linalg.lstsq(lines[free, 1:-1], amplitude[free])[0]
    weight = (amplitude + 1e-3 * max(float(amplitude.max()), 1e-9))[:, None]
    tuned = np.linalg.lstsq(weight * lines, weight[:, 0] * hz)[0]
    return Part(times, np.clip(fitted, 0, 1), np.clip(tuned, hz.min(), hz.max()))


def _chosen(amplitude: Line, hz: Line, grid: NDArray[np.int64]) -> list[int]:
    """Return the places on the grid (ms) between which lines are closest; the fewest lines that are `CLOSE`."""
    costs = _costs(amplitude, hz, grid)
    best, before = [np.append(0.0, np.full(len(grid) - 1, np.inf))], []
    for _ in range(MOST_POINTS):
        total = best[-1][:, None] + costs
        before.append(total.argmin(axis=0))
        best.append(total.min(axis=0))
    close = len(amplitude) * (CLOSE * float(amplitude.max())) ** 2
    # At least two, so that something lies between the beginning at 0 and the end at 0.
    errors = np.array([sums[-1] for sums in best[2:]])
    lines = 2 + int(np.argmax(errors <= close) if errors.min() <= close else errors.argmin())
    ends = [len(grid) - 1]
    for step in reversed(before[:lines]):
        ends.insert(0, int(step[ends[0]]))
    return ends


def _costs(amplitude: Line, hz: Line, grid: NDArray[np.int64]) -> Line:
    """Return the squared error of the line between two places on the grid, shape (begin, end); inf if too long.

    The first and the last step do not count: no line could begin or end elsewhere than at 0. An octave of frequency
    counts as much as the whole amplitude. A choice.
    """
    ends, tones = amplitude[::STEPS].copy(), hz[::STEPS]
    ends[[0, -1]] = 0.0
    costs = np.full((len(grid), len(grid)), np.inf)
    for steps in range(1, min(LONGEST_MS // SHORTEST_MS, len(grid) - 1) + 1):
        along = np.arange(steps * STEPS) / (steps * STEPS)
        strength, sounding = (sliding_window_view(x[:-1], steps * STEPS)[::STEPS] for x in (amplitude, hz))
        line, tone = (x[:-steps, None] * (1 - along) + x[steps:, None] * along for x in (ends, tones))
        error = (line - strength) ** 2 + (strength * np.log2(tone / sounding)) ** 2
        error[0, :STEPS] = error[-1, -STEPS:] = 0.0
        begin = np.arange(len(grid) - steps)
        costs[begin, begin + steps] = error.sum(axis=1)
    costs[grid - grid[:, None] > LONGEST_MS] = np.inf
    return costs


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
        for tap in events.transients:
            start, end = span_ms(tap, self.pulse_ms, self.least_ms)
            gap = 1 if isinstance(tap, Pulse) else self.gap_ms
            if taps and start < taps[-1][1] + gap:
                taps[-1] = (*taps[-1][:2], max(taps[-1][2], min(1.0, tap.amplitude)))
            else:
                taps.append((start, end, min(1.0, tap.amplitude)))
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

"""Events: what every haptic file holds, vibrations with breakpoints and transients."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError

Line = NDArray[np.float64]

STEP_S = 0.005
"""Grid on which a curve that is no line is held, s."""
PULSE_S = 0.020
"""Length of a transient where a file is played here, s: it starts at full strength and falls like half a Hann window.
Devices have their own."""
JUMP_S = SHORTEST_S = 1e-5
"""Time that a jump takes, and least length of events, s."""
UNKNOWN_HZ = 150.0
"""Frequency of silence."""
PHONE_HZ = 170.0
"""Assumed if a phone's file states no frequency: linear resonant actuators of phones resonate at 150 to 200 Hz. A
choice."""
FROM_PHONE = "nothing in the file: a phone's usual"
LONGEST_PIECE = 200
"""Points that `thinned` processes together: its run time stays proportional to the length."""


@dataclass(frozen=True)
class FrequencySpan:
    """Frequencies (Hz) at a file's 0 and 1 of frequency or sharpness, linear in between."""

    low: float
    high: float

    def share(self, hz: Line | float) -> Line:
        """Return the position of frequencies in the span, clipped to 0 to 1."""
        return np.clip((np.asarray(hz) - self.low) / (self.high - self.low), 0, 1)

    def hz(self, share: Line | float) -> Line:
        """Return the frequencies of shares."""
        return np.asarray(self.low + np.asarray(share) * (self.high - self.low))


@dataclass(frozen=True)
class Transient:
    """A moment too short for a line: its beginning (s), its whole strength (0 to 1), and its frequency (Hz)."""

    time: float
    amplitude: float
    frequency: float


@dataclass(frozen=True, eq=False)
class Part:
    """A vibration: amplitude and frequency (Hz) at times (s), linear in between: float64 arrays, shape (point,).

    Times increase; a jump takes `JUMP_S`. The amplitude is that of the sine of equal power, 0 outside the times.
    """

    times: Line
    amplitude: Line
    frequency: Line

    @classmethod
    def of(cls, times: ArrayLike, amplitude: ArrayLike, tones: ArrayLike, hz: ArrayLike) -> Part:
        """Return the vibration with these points of the amplitude, in order, and of the frequency (times and Hz).

        A point at the time of the one before makes a jump.
        """
        own, strength = increasing(np.asarray(times, float)), np.asarray(amplitude, float)
        turns, values = (
            increasing(np.atleast_1d(np.asarray(tones, float))),
            np.atleast_1d(np.asarray(hz, float)),
        )
        both = np.union1d(own, turns[(turns > own[0]) & (turns < own[-1])])
        return cls(both, np.interp(both, own, strength), np.interp(both, turns, values))

    @property
    def start(self) -> float:
        """Its beginning, s."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """Its end, s."""
        return float(self.times[-1])

    @property
    def peak(self) -> float:
        """The largest amplitude."""
        return float(self.amplitude.max(initial=0.0))

    def at(self, t: Line | float) -> Line:
        """Return the amplitude at times."""
        return np.asarray(np.interp(t, self.times, self.amplitude, left=0.0, right=0.0))

    def hz(self, t: Line | float) -> Line:
        """Return the frequency at times."""
        return np.asarray(np.interp(t, self.times, self.frequency))

    @property
    def runs(self) -> list[Part]:
        """Its stretches that sound, without the jumps from and to silence."""
        first, second = self.amplitude[:-1], self.amplitude[1:]
        edge = (np.minimum(first, second) == 0) & (np.diff(self.times) <= 2 * JUMP_S)
        on = (np.maximum(first, second) > 0) & ~edge
        return [self.within(*span) for span in spans_of(self.times[:-1][on], self.times[1:][on], 0.0)]

    def within(self, start: float, end: float) -> Part:
        """Return it from ``start`` to ``end``, with silence where it has nothing."""
        edges = [start, self.start - JUMP_S, self.end + JUMP_S, end]
        times = np.union1d(self.times[slice(*np.searchsorted(self.times, [start, end]))], edges)
        times = times[(times >= start) & (times <= end)]
        inside = np.clip(times, self.start, self.end)
        amplitude = np.where(np.abs(times - inside) < JUMP_S / 2, self.at(inside), 0.0)
        return Part(times, amplitude, self.hz(times))


@dataclass(frozen=True, eq=False)
class Events:
    """Vibrations, which may sound at once, and transients in order of time, of ``seconds`` in all.

    ``span`` is that of a file whose frequencies are shares, such as sharpness: a file of shares gets the same ones.
    """

    seconds: float
    parts: tuple[Part, ...] = ()
    transients: tuple[Transient, ...] = ()
    span: FrequencySpan | None = None

    @classmethod
    def of(
        cls,
        parts: Iterable[Part],
        transients: Iterable[Transient],
        seconds: float = 0.0,
        span: FrequencySpan | None = None,
        *,
        limited: bool = True,
    ) -> Events:
        """Return events without what is silent, that last at least ``seconds``.

        What is ``limited`` is reduced to an amplitude of 1 where vibrations together exceed it, as by one actuator.
        """
        sounding = tuple(part for part in parts if part.peak > 0)
        taps = tuple(sorted((tap for tap in transients if tap.amplitude > 0), key=lambda tap: tap.time))
        end = max([seconds, *(part.end for part in sounding)])
        end = max([end, *(tap.time + PULSE_S for tap in taps if tap.time >= end)])
        if limited and (whole := joined(sounding)).peak > 1:
            parts, sounding = sounding, ()
            for part in parts:
                inside = whole.times[slice(*np.searchsorted(whole.times, [part.start, part.end]))]
                times = np.union1d(part.times, inside)
                shares = part.at(times) / np.maximum(whole.at(times), 1)
                sounding += (Part(times, shares, part.hz(times)),)
        return cls(
            end, sounding, tuple(replace(tap, amplitude=min(1.0, tap.amplitude)) for tap in taps), span
        )

    @property
    def peak(self) -> float:
        """The largest amplitude."""
        return max([self.joined.peak, *(tap.amplitude for tap in self.transients)])

    @property
    def frequencies(self) -> list[float]:
        """The lowest and the highest frequency of each vibration, and that of each transient, Hz."""
        ends = [float(hz) for part in self.parts for hz in (part.frequency.min(), part.frequency.max())]
        return [*ends, *(tap.frequency for tap in self.transients)]

    @property
    def count(self) -> int:
        """The number of vibrations and transients."""
        return len(self.parts) + len(self.transients)

    @cached_property
    def joined(self) -> Part:
        """All vibrations as one, see `joined`."""
        return joined(self.parts)

    def check_length(self, title: str) -> None:
        """Raise `ParameterError` if they last less than `SHORTEST_S`; ``title`` is the format's."""
        if self.seconds < SHORTEST_S:
            raise ParameterError(f"{title} needs at least {SHORTEST_S:g} s, got {self.seconds:g} s")

    def scaled(self, factor: float) -> Events:
        """Return it with all amplitudes multiplied."""
        parts = (replace(part, amplitude=factor * part.amplitude) for part in self.parts)
        taps = (replace(tap, amplitude=factor * tap.amplitude) for tap in self.transients)
        return replace(self, parts=tuple(parts), transients=tuple(taps))

    def in_span(self, span: FrequencySpan) -> Events:
        """Return it with the same shares of another span."""
        own = self.span or span
        parts = (replace(part, frequency=span.hz(own.share(part.frequency))) for part in self.parts)
        taps = (replace(tap, frequency=float(span.hz(own.share(tap.frequency)))) for tap in self.transients)
        return replace(self, parts=tuple(parts), transients=tuple(taps), span=span)

    def strength(self, t: Line) -> Line:
        """Return the amplitude at times, transients included: the stronger of them and the vibration counts."""
        strength = self.joined.at(t)
        for tap in self.transients:
            inside = slice(*np.searchsorted(t, [tap.time, tap.time + PULSE_S]))
            strength[inside] = np.maximum(
                strength[inside], tap.amplitude * transient_shape(t[inside] - tap.time)
            )
        return strength


def transient_shape(seconds: Line) -> Line:
    """Return a transient of amplitude 1 at times after its beginning, s."""
    return np.asarray(np.where(seconds >= 0, np.cos(np.pi / 2 * np.clip(seconds / PULSE_S, 0, 1)) ** 2, 0.0))


def joined(parts: Sequence[Part], *, strongest: bool = False) -> Part:
    """Return vibrations as one, which is no weaker than any of them.

    Its power is the sum of their powers, its frequency their mean weighted by power; or those of the ``strongest`` at
    any time. A single one is returned as it is.
    """
    if len(parts) <= 1:
        return parts[0] if parts else Part(*np.array([[0.0], [0.0], [UNKNOWN_HZ]]))
    spans = sorted((part.start, part.end) for part in parts)
    t = [points for part in parts for points in (part.times, [part.start - JUMP_S, part.end + JUMP_S])]
    reached = -np.inf
    for start, end in spans:
        if start < reached:
            t.append(np.arange(start, min(reached, end), STEP_S))  # The root of a sum of squares is no line.
        reached = max(reached, end)
    times: Line = np.unique(np.round(np.concatenate(t), 7)).astype(np.float64)
    times = times[(times >= round(spans[0][0], 7)) & (times <= round(reached, 7))]
    starts = {round(start, 6) for start, _ in spans}
    total = np.zeros((3, len(times)))  # power, frequency times weight, weight
    for part in parts:
        last = part.end + (-1e-7 if round(part.end, 6) in starts and part.end > part.start else 1e-7)
        inside = slice(*np.searchsorted(times, [part.start - 1e-7, last]))
        own = np.interp(times[inside], part.times, part.amplitude) ** 2
        # A silent vibration's frequency counts where nothing else sounds.
        new = np.stack([own, (own + 1e-12) * part.hz(times[inside]), own + 1e-12])
        old = total[:, inside]
        total[:, inside] = np.where(own > old[0], new, old) if strongest else old + new
    power, turning, weights = total
    heard = weights > 0
    return Part(times, np.sqrt(power), np.interp(times, times[heard], turning[heard] / weights[heard]))


def voices(parts: Iterable[Part]) -> list[list[Part]]:
    """Return vibrations as few lists of such as do not overlap, each in order of time."""
    found: list[list[Part]] = []
    for part in sorted(parts, key=lambda part: part.start):
        free = next((voice for voice in found if voice[-1].end <= part.start + JUMP_S), None)
        if free is None:
            found.append([part])
        else:
            free.append(part)
    return found


def stepped(edges: Line, strength: Line, hz: float) -> Part:
    """Return the vibration that is constant between ``edges`` (s), at one frequency; of one edge nothing."""
    if len(edges) < 2:
        return Part.of(edges, [0.0], 0.0, hz)
    return Part.of(np.repeat(edges, 2)[1:-1], np.repeat(strength, 2), 0.0, hz)


def densified(times: Line) -> Line:
    """Return times with more between them, at most `STEP_S` apart."""
    pieces = [
        np.linspace(a, b, int(np.ceil((b - a) / STEP_S - 1e-9)), endpoint=False)
        for a, b in pairwise(times.tolist())
    ]
    return np.concatenate([*pieces, times[-1:]])


def thinned(times: Line, values: Line, tolerance: float) -> NDArray[np.intp]:
    """Return the indices of points whose connecting lines stay within ``tolerance`` of all points.

    Douglas & Peucker (1973) with vertical distances, in pieces of `LONGEST_PIECE` points; includes the first and the
    last.
    """
    chosen = {0, len(times) - 1, *range(0, len(times), LONGEST_PIECE)}
    stack = list(pairwise(sorted(chosen)))
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        inside = slice(first + 1, last)
        line = np.interp(times[inside], times[[first, last]], values[[first, last]])
        error = np.abs(values[inside] - line)
        worst = int(np.argmax(error))
        if error[worst] > tolerance:
            middle = first + 1 + worst
            chosen.add(middle)
            stack += [(first, middle), (middle, last)]
    return np.array(sorted(chosen))


def bends(times: Line, values: Line, tolerance: float) -> list[tuple[float, float]]:
    """Return the times and values of the points that `thinned` keeps."""
    kept = thinned(times, values, tolerance)
    return list(zip(times[kept].tolist(), values[kept].tolist(), strict=True))


def spans_of(starts: Line, ends: Line, gap: float) -> list[tuple[float, float]]:
    """Return spans, which are in order, with those up to ``gap`` (s) apart as one."""
    apart, edge = starts[1:] - ends[:-1] > gap, np.ones(min(1, len(starts)), bool)
    first, last = np.append(edge, apart), np.append(apart, edge)
    return list(zip(starts[first].tolist(), ends[last].tolist(), strict=True))


def increasing(times: Line) -> Line:
    """Return times of which each is at least `JUMP_S` after the one before."""
    least = JUMP_S * np.arange(len(times))
    return np.asarray(np.maximum.accumulate(times - least) + least)

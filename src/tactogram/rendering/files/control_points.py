"""Control points of an envelope: few straight lines of amplitude and frequency, as Android 16's builders take them.

The limits are those that are taken to hold on every phone with envelopes; `VibratorEnvelopeEffectInfo` states a phone's
own. An effect begins at amplitude 0, and each point states how long the line to it takes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import has_key
from tactogram.rendering.files.envelope import STEP_S, Envelope, envelope_of
from tactogram.signal import Signal

MOST_POINTS = 16
SHORTEST_MS, LONGEST_MS = 20, 1000
"""Shortest and longest line, ms."""
CLOSE = 0.02
"""Fewer points are used where they come this close (rms) to the envelope, relative to its peak. A choice."""
STEPS = round(SHORTEST_MS / 1e3 / STEP_S)
"""Points of the analysed envelope in the shortest line."""
MOST_STEPS = LONGEST_MS // SHORTEST_MS

Milliseconds = Annotated[int, Field(ge=SHORTEST_MS, le=LONGEST_MS)]
Share = Annotated[float, Field(ge=0, le=1)]


@dataclass(frozen=True, eq=False)
class ControlPoints:
    """Ends of the lines of an envelope that begins at amplitude 0 and ``start_hz``.

    ``ms`` is the duration of each line (int64), ``amplitude`` (0 to 1) and ``hz`` its end (float64): arrays, shape
    (point,).
    """

    start_hz: float
    ms: NDArray[np.int64]
    amplitude: NDArray[np.float64]
    hz: NDArray[np.float64]

    def envelope(self) -> Envelope:
        """Return the lines as an envelope."""
        times = np.concatenate([[0], np.cumsum(self.ms)]) / 1e3
        amplitude = np.concatenate([[0.0], self.amplitude])
        return Envelope(float(times[-1]), times, amplitude, times, np.concatenate([[self.start_hz], self.hz]))


def control_points(signal: Signal, *, what: str) -> ControlPoints:
    """Return the `MOST_POINTS` or fewer lines that are closest to a signal's envelope and frequency, ending at 0.

    The ends are chosen on a grid of `SHORTEST_MS` by dynamic programming (Bellman 1961), then amplitudes and
    frequencies are fitted by least squares, those of the frequency weighted by the amplitude. ``what`` names the result
    in errors. Raises `ParameterError` if the signal is too short or too long.
    """
    length = round(1e3 * signal.seconds)
    if not 2 * SHORTEST_MS <= length <= MOST_POINTS * LONGEST_MS:
        raise ParameterError(
            f"{what} lasts {2 * SHORTEST_MS} to {MOST_POINTS * LONGEST_MS} ms, got {length} ms; cut it, or use a "
            "format without that limit"
        )
    count = length // SHORTEST_MS
    grid = SHORTEST_MS * np.arange(count + 1)
    grid[-1] = length
    source = envelope_of(signal, pulses=False)
    # The last line is stretched by up to a step.
    fine = np.interp(np.arange(STEPS * count + 1), STEPS * np.arange(count + 1), grid) / 1e3
    amplitude = np.minimum(np.interp(fine, source.times, source.amplitude), 1)
    hz = np.maximum(np.interp(fine, source.times, source.frequency), 1)
    ends = _chosen(amplitude, hz, stretched=length % SHORTEST_MS > 0)
    lines = _lines(fine, grid[ends] / 1e3)
    fitted = np.zeros(len(ends))
    free = slice(STEPS, -STEPS)
    fitted[1:-1] = np.linalg.lstsq(lines[free, 1:-1], amplitude[free])[0]
    weight = (amplitude + 1e-3 * max(float(amplitude.max()), 1e-9))[:, None]
    tuned = np.linalg.lstsq(weight * lines, weight[:, 0] * hz)[0]
    tuned = np.clip(tuned, hz.min(), hz.max())
    return ControlPoints(float(tuned[0]), np.diff(grid[ends]), np.clip(fitted[1:], 0, 1), tuned[1:])


def has_points(key: str) -> Callable[[Any], bool]:
    """Return a function that checks whether a document has control points, the first of them with ``key``."""

    def check(document: Any) -> bool:
        points = document["controlPoints"] if has_key("controlPoints")(document) else None
        return isinstance(points, list) and bool(points) and has_key(key)(points[0])

    return check


def _lines(times: NDArray[np.float64], ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the share of each end in the lines at ``times``, shape (time, end)."""
    return np.stack([np.interp(times, ends, one) for one in np.eye(len(ends))], axis=1)


def _chosen(amplitude: NDArray[np.float64], hz: NDArray[np.float64], *, stretched: bool) -> NDArray[np.intp]:
    """Return the places on the grid between which lines are closest; the fewest lines that are `CLOSE`."""
    costs = _costs(amplitude, hz, stretched=stretched)
    count = len(amplitude) // STEPS
    best = np.full((MOST_POINTS + 1, count + 1), np.inf)
    best[0, 0] = 0.0
    before = np.zeros(best.shape, np.intp)
    for lines in range(1, MOST_POINTS + 1):
        for steps, cost in enumerate(costs, 1):
            total = best[lines - 1, : len(cost)] + cost
            better = total < best[lines, steps:]
            best[lines, steps:][better] = total[better]
            before[lines, steps:][better] = np.flatnonzero(better)
    close = len(amplitude) * (CLOSE * float(amplitude.max())) ** 2
    # At least two, so that something lies between the beginning at 0 and the end at 0.
    enough = np.flatnonzero(best[2:, -1] <= close)
    lines = 2 + int(enough[0] if len(enough) else np.argmin(best[2:, -1]))
    ends = [count]
    for left in range(lines, 0, -1):
        ends.append(int(before[left, ends[-1]]))
    return np.array(ends[::-1])


def _costs(
    amplitude: NDArray[np.float64], hz: NDArray[np.float64], *, stretched: bool
) -> list[NDArray[np.float64]]:
    """Return the squared error of a line by its length in steps (from 1) and its beginning.

    The first and the last step do not count: no line could begin or end elsewhere than at 0. An octave of frequency
    counts as much as the whole amplitude. A choice.
    """
    count = len(amplitude) // STEPS
    ends = amplitude[::STEPS].copy()
    ends[[0, -1]] = 0.0
    tones = hz[::STEPS]
    costs = []
    for steps in range(1, min(MOST_STEPS, count) + 1):
        along = np.arange(steps * STEPS) / (steps * STEPS)
        wanted = sliding_window_view(amplitude[:-1], steps * STEPS)[::STEPS]
        sounding = sliding_window_view(hz[:-1], steps * STEPS)[::STEPS]
        line = ends[:-steps, None] * (1 - along) + ends[steps:, None] * along
        tone = tones[:-steps, None] * (1 - along) + tones[steps:, None] * along
        error = (line - wanted) ** 2 + (wanted * np.log2(tone / sounding)) ** 2
        error[0, :STEPS] = 0.0
        error[-1, -STEPS:] = 0.0
        cost = error.sum(axis=1)
        if steps == MOST_STEPS and stretched:
            cost[-1] = np.inf
        costs.append(cost)
    return costs

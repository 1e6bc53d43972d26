"""Estimate of a sensor's sampling rate from sample positions and arrival times."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST_POINTS = 200
"""Most points of the line; of more arrivals, the promptest of each group is used."""

_MOST_KEPT = 4096
_LEVEL = 0.98
"""Level of Sen's interval. The promptest of neighbours are not quite independent: the 95 % interval contained the true
rate in 91 to 94 of 100 simulated recordings of 5 to 60 s, the 98 % interval in 96 to 98."""


@dataclass(frozen=True)
class RateEstimate:
    """A measured rate and its 95 % interval, Hz.

    The interval covers scatter only, not the error of the computer's clock, which may be some 50 ppm.
    """

    hz: float
    low: float
    high: float
    packets: int
    """Number of arrivals."""
    seconds: float
    """From the first arrival to the last."""
    late_s: float
    """Median delay relative to the promptest arrivals."""

    def facts(self) -> dict[str, Any]:
        """Return JSON values."""
        return asdict(self)


def estimate_rate(indices: NDArray[np.int64], arrivals_s: NDArray[np.float64]) -> RateEstimate | None:
    """Return the slope of a line through (time, position), or None if there are too few points.

    A radio and a USB port can only delay packets, sometimes by much. The line therefore runs through the promptest
    arrival in each group of neighbours, and its slope is the median over all pairs of them (H. Theil, "A rank-invariant
    method of linear and polynomial regression analysis", 1950; P. K. Sen, "Estimates of the regression coefficient
    based on Kendall's tau", 1968, for the interval): a few late arrivals, or a burst of them, do not affect it.
    Tested: the true rate lies within the interval in at least 93 of 100 simulated recordings, and within 20 ppm of the
    estimate after 60 s at 330 Hz with an exponential delay of 5 ms.

    Parameters
    ----------
    indices : int64 array, shape (packet,)
        Position of each packet's last sample, increasing.
    arrivals_s : float64 array, shape (packet,)
        NaN where unknown.
    """
    timed = np.isfinite(arrivals_s)
    places, times = indices[timed].astype(np.float64), arrivals_s[timed]
    if len(places) < 5 or times[-1] <= times[0] or places[-1] <= places[0]:
        return None
    period = float(times[-1] - times[0]) / float(places[-1] - places[0])
    delays = times - period * places
    groups = np.array_split(np.arange(len(places)), min(MOST_POINTS, max(5, len(places) // 4)))
    prompt = np.array([group[np.argmin(delays[group])] for group in groups if len(group)])
    # Imported here because it takes longer to import than everything else that a source needs.
    from scipy.stats import theilslopes

    slope, _, low, high = theilslopes(times[prompt], places[prompt], _LEVEL)
    if not (slope > 0 and low > 0):
        return None
    behind = times - slope * places
    return RateEstimate(
        hz=float(1 / slope),
        low=float(1 / high),
        high=float(1 / low),
        packets=len(places),
        seconds=float(times[-1] - times[0]),
        late_s=float(np.median(behind - behind[prompt].min())),
    )


class RateMeter:
    """Live rate estimate in bounded memory: the longer it runs, the coarser its record of arrivals."""

    def __init__(self) -> None:
        self._points: list[tuple[int, float]] = []
        self._step, self._count = 1, 0
        self._last: tuple[int, RateEstimate | None] = (0, None)

    def add(self, index: int, arrival_s: float) -> None:
        """Add the position of a packet's last sample and its arrival, unless that is NaN."""
        if not np.isfinite(arrival_s):
            return
        if self._count % self._step == 0:
            self._points.append((index, arrival_s))
            if len(self._points) >= _MOST_KEPT:
                self._points = self._points[::2]
                self._step *= 2
        self._count += 1

    def restart(self) -> None:
        """Forget all arrivals, since the sensor's clock began anew."""
        self.__init__()  # type: ignore[misc]

    def estimate(self, *, fresh: bool = False) -> RateEstimate | None:
        """Return `estimate_rate` of the arrivals; unless ``fresh``, it may lack the latest 2 % of them."""
        if not self._points:
            return None
        count, last = self._last
        if count == self._count or (not fresh and last is not None and self._count < 1.02 * count):
            return last
        indices, arrivals = zip(*self._points, strict=True)
        rate = estimate_rate(np.array(indices, np.int64), np.array(arrivals, np.float64))
        self._last = (self._count, rate)
        return rate

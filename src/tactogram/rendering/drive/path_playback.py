"""Playback of a texture over displacement along a finger's path: hysteresis, band limit by speed, hold when lifted.

A pattern of k cycles per mm at v mm/s is felt at v k Hz. Nothing may exceed a highest frequency, since it would alias.
So the texture is stored in steps of detail, three per octave, among which the finger's speed chooses.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from tactogram.errors import ParameterError
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal

FINE = 4
"""Samples of a cubic spline per sample of the texture: accurate to 2e-3 up to 0.45 of the rate."""
STEPS_PER_OCTAVE = 3
LEAST_SAMPLES = 16
"""Samples in the coarsest step of detail."""


class PathPlayback:
    """Playback of a texture over displacement (one axis) at ``rate`` (Hz), along a path that arrives in blocks.

    The output has no frequency above ``highest_hz`` (at most 0.45 of ``rate``) at a steady speed. A finger that turns
    back moves by ``hysteresis_mm`` before the texture does, so that a trembling finger at rest plays nothing. Beyond
    the ends of the texture (``outside``) it is mirrored, or its last value held. Raises `ParameterError` if the
    texture is over time or has several axes, or a value is out of range.
    """

    def __init__(
        self,
        texture: Signal,
        *,
        rate: float,
        highest_hz: float = 1000.0,
        hysteresis_mm: float = 0.1,
        outside: Literal["mirror", "hold"] = "mirror",
    ) -> None:
        if texture.domain != "displacement" or len(texture.axes) != 1:
            raise ParameterError(
                f"texture must be one axis over displacement, got {len(texture.axes)} over {texture.domain}"
            )
        if not 0 < highest_hz <= 0.45 * rate:
            raise ParameterError(
                f"highest_hz must be above 0 and at most {0.45 * rate:g}, got {highest_hz:g}"
            )
        if not (hysteresis_mm >= 0 and math.isfinite(hysteresis_mm)):
            raise ParameterError(f"hysteresis_mm must be 0 or more, got {hysteresis_mm}")
        if len(texture) < 2:
            raise ParameterError("texture must have at least two samples, got one")
        self.rate, self.highest_hz = float(rate), float(highest_hz)
        self.hysteresis_mm, self.outside = float(hysteresis_mm), outside
        self._end = (len(texture) - 1) / texture.rate
        self._finest = texture.rate / 2  # cycles per mm
        self._details = _details(texture)
        self._place: float | None = None
        self._lifted = False
        self._detail = -1.0

    @property
    def place_mm(self) -> float | None:
        """Position on the texture at the last sample; None before the first touch."""
        return self._place

    def process(
        self, place_mm: ArrayLike | None, length: int, *, contact: bool = True
    ) -> NDArray[np.float64]:
        """Return the next ``length`` samples of the texture under the finger, float64, shape (time,).

        ``place_mm`` has positions along the path, evenly spread over the block, the last one at its end; None, or
        values that are not finite, are no news. While the finger is lifted (no ``contact``), position and value are
        held; it then touches down at its new position. Before the first touch the value is that at position 0.
        """
        if length < 1:
            raise ParameterError(f"a block must have at least one sample, got {length}")
        news = np.atleast_1d(np.asarray([] if place_mm is None else place_mm, np.float64))
        news = news[np.isfinite(news)]
        if len(news) == 0 or not contact:
            self._lifted = self._lifted or not contact
            places = np.full(length, self._place or 0.0)
        else:
            places = self._path(news, length)
            self._lifted = False
        return self._values(places)

    def _path(self, news: NDArray[np.float64], length: int) -> NDArray[np.float64]:
        """Return the position at each sample, after the hysteresis."""
        start = self._place
        if start is None or self._lifted:
            start = float(news[0])
        half = self.hysteresis_mm / 2
        path = [start]
        for place in news:
            path.append(min(max(path[-1], float(place) - half), float(place) + half))
        self._place = path[-1]
        at = np.arange(1, length + 1) / length
        return np.asarray(np.interp(at, np.linspace(0, 1, len(path)), path))

    def _values(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        steps = np.abs(np.diff(places))
        speed = float(steps.max()) * self.rate if len(steps) else 0.0  # mm/s
        wanted = -1.0
        if speed > 0:
            wanted = STEPS_PER_OCTAVE * math.log2(speed * self._finest / self.highest_hz)
        wanted = min(max(wanted, -1.0), len(self._details) - 2.0)
        detail = np.linspace(self._detail, wanted, len(places) + 1)[1:]
        self._detail = wanted
        folded = self._folded(places)
        # Above a whole step n the two next coarser ones are mixed: the detail is never finer than allowed.
        whole = np.floor(detail).astype(int)
        part = detail - whole
        values = np.empty(len(places))
        for step in np.unique(whole):
            here = whole == step
            coarse = min(step + 2, len(self._details) - 1)
            low = self._details[min(step + 1, len(self._details) - 1)](folded[here])
            values[here] = low + part[here] * (self._details[coarse](folded[here]) - low)
        return values

    def _folded(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.outside == "hold":
            return np.clip(places, 0, self._end)
        turned = np.mod(places, 2 * self._end)
        return np.asarray(np.where(turned > self._end, 2 * self._end - turned, turned))


def _details(texture: Signal) -> list[_ClampedSpline]:
    """Return the texture in steps of detail: band-limited at its own rate, a third of an octave lower, and so on."""
    steps = []
    step = 0
    while True:
        rate = texture.rate * 2 ** (-step / STEPS_PER_OCTAVE)
        if step and len(texture) * rate / texture.rate < LEAST_SAMPLES:
            break
        fine = resample(resample(texture, rate), FINE * rate)
        grid = np.arange(len(fine)) / (FINE * rate)
        steps.append(_ClampedSpline(grid, fine.samples[0].astype(np.float64)))
        step += 1
    mean = float(texture.samples.mean(dtype=np.float64))
    flat = _ClampedSpline(np.array([0.0, 1.0]), np.array([mean, mean]))
    return [*steps, flat, flat]


class _ClampedSpline:
    """Cubic spline with constant values outside: coarse grids end a little before the texture does."""

    def __init__(self, grid: NDArray[np.float64], values: NDArray[np.float64]) -> None:
        self._low, self._high = float(grid[0]), float(grid[-1])
        self._spline = CubicSpline(grid, values)

    def __call__(self, at: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(self._spline(np.clip(at, self._low, self._high)))

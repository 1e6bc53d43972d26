"""Playback of a texture over displacement along a finger's path, without aliasing at any speed.

A pattern of k cycles per mm under a finger at v mm/s is felt at v k Hz. What a fast finger would shift above the
highest frequency is removed in advance, in copies of the texture whose bands end half an octave apart (Williams 1983);
the two copies below the limit are blended by speed.

References
----------
- Williams, L. (1983). Pyramidal parametrics. Computer Graphics 17(3), 1-11. doi 10.1145/964967.801126
"""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from tactogram.errors import ParameterError
from tactogram.signal.signal import Signal

OVERSAMPLED = 8
"""Nodes per sample of the texture; a cubic interpolates between them (see `tactogram.signal.displacement`)."""
FASTEST_MM_S = 1000.0
"""Highest speed without aliasing."""


def copy_count(samples_per_mm: float, rate: float) -> int:
    """Return the number of copies that a texture needs to be played at ``rate`` (Hz) up to `FASTEST_MM_S`."""
    return 2 + max(0, math.ceil(2 * math.log2(FASTEST_MM_S * samples_per_mm / rate)))


def band_limited(loop: NDArray[np.floating], count: int) -> NDArray[np.float32]:
    """Return copies of a loop, oversampled, float32, shape (copy, axis, node); copy c has 2^(-c/2) of its band."""
    length = loop.shape[1]
    spectrum = fft.rfft(loop.astype(np.float64), axis=1)
    frequency = np.arange(spectrum.shape[1]) / length  # cycles per sample
    if length % 2 == 0:
        spectrum[:, -1] *= 0.5
    copies = np.empty((count, len(loop), length * OVERSAMPLED), np.float32)
    for copy in range(count):
        gain = 1.0 if copy == 0 else _low_pass(frequency, 0.5 * 2 ** (-copy / 2))
        copies[copy] = fft.irfft(spectrum * gain, n=length * OVERSAMPLED, axis=1) * OVERSAMPLED
    return copies


def _low_pass(frequency: NDArray[np.float64], edge: float) -> NDArray[np.float64]:
    """Return a gain of 1 up to 0.8 of ``edge``, 0 from ``edge`` on, and half a cosine in between."""
    share = np.clip((frequency / edge - 0.8) / 0.2, 0, 1)
    return np.asarray(0.5 + 0.5 * np.cos(np.pi * share))


@numba.njit(cache=True, nogil=True)
def play_loop(
    table: NDArray[np.float32],  # (copy, axis, node)
    place: NDArray[np.float64],
    speed: NDArray[np.float64],
    nodes_per_mm: float,
    samples_per_speed: float,
    count: int,
    out: NDArray[np.float32],
) -> None:
    """Write ``count`` samples of a loop at places (mm) and speeds (mm/s), shape (axis, time).

    ``samples_per_speed`` are the texture's samples per mm over the rate of the output, or twice its highest frequency.
    """
    copies, axes, nodes = table.shape
    for i in range(count):
        position = (place[i] * nodes_per_mm) % nodes
        node = int(position)
        if node >= nodes:
            node = 0
        r = position - node
        i0 = node - 1 if node > 0 else nodes - 1
        i2 = node + 1 if node + 1 < nodes else 0
        i3 = i2 + 1 if i2 + 1 < nodes else 0
        # Samples of the texture per sample of the output; above 1 the finest detail would alias.
        ratio = speed[i] * samples_per_speed
        copy = 2 * math.log2(ratio) if ratio > 0 else -4.0
        lower = 0
        share = 0.0
        if copy > -1:
            whole = math.floor(copy)
            share = copy - whole
            lower = int(whole) + 1
        if lower >= copies - 1:
            lower, share = copies - 1, 0.0
        upper = min(lower + 1, copies - 1)
        for a in range(axes):
            value = 0.0
            for c, weight in ((lower, 1 - share), (upper, share)):
                row = table[c, a]
                y0, y1, y2, y3 = row[i0], row[node], row[i2], row[i3]
                slope1, slope2 = 0.5 * (y2 - y0), 0.5 * (y3 - y1)
                value += weight * (
                    y1
                    + r
                    * (
                        slope1
                        + r * (3 * (y2 - y1) - 2 * slope1 - slope2 + r * (2 * (y1 - y2) + slope1 + slope2))
                    )
                )
            out[a, i] = value


class PathPlayback:
    """Playback of a texture over displacement (one axis) at ``rate`` (Hz), along a path that arrives in blocks.

    The output has no frequency above ``highest_hz`` (at most 0.45 of ``rate``) at a steady speed. A finger that turns
    back moves by ``hysteresis_mm`` before the texture does, so that a trembling finger at rest plays nothing. Beyond
    its ends the texture is mirrored. ``place_mm`` is the position on it at the last sample, None before the first
    touch. Raises `ParameterError` if the texture is over time or has several axes, or a value is out of range.
    """

    def __init__(
        self, texture: Signal, *, rate: float, highest_hz: float = 1000.0, hysteresis_mm: float = 0.1
    ) -> None:
        if texture.domain != "displacement" or len(texture.axes) != 1 or len(texture) < 2:
            raise ParameterError.must(
                "texture",
                "be one axis over displacement with at least two samples, got "
                f"{len(texture.axes)} over {texture.domain} with {len(texture)}",
            )
        if not 0 < highest_hz <= 0.45 * rate:
            raise ParameterError.must("highest_hz", f"be above 0 and at most {0.45 * rate:g}", highest_hz)
        if not (hysteresis_mm >= 0 and math.isfinite(hysteresis_mm)):
            raise ParameterError.must("hysteresis_mm", "be 0 or more", hysteresis_mm)
        x = texture.samples
        mirrored = np.concatenate([x, x[:, -2:0:-1]], axis=1)
        copies = band_limited(mirrored, copy_count(texture.rate, 2 * highest_hz))
        flat = np.broadcast_to(copies.mean(axis=2, keepdims=True)[:1], copies[:1].shape)
        self._table = np.concatenate([copies, flat])
        self._nodes_per_mm = OVERSAMPLED * texture.rate
        self._samples_per_speed = texture.rate / (2 * highest_hz)
        self._rate, self._hysteresis_mm = float(rate), float(hysteresis_mm)
        self._lifted, self._speed = False, 0.0
        self.place_mm: float | None = None

    def process(
        self, place_mm: ArrayLike | None, length: int, *, contact: bool = True
    ) -> NDArray[np.float64]:
        """Return the next ``length`` samples of the texture under the finger, float64, shape (time,).

        ``place_mm`` has positions along the path, evenly spread over the block, the last one at its end; None, or
        values that are not finite, are no news. While the finger is lifted (no ``contact``), position and value are
        held; it then touches down at its new position. Before the first touch the value is that at position 0.
        """
        news = np.atleast_1d(np.asarray([] if place_mm is None else place_mm, np.float64))
        news = news[np.isfinite(news)]
        if len(news) == 0 or not contact:
            self._lifted = self._lifted or not contact
            places = np.full(length, self.place_mm or 0.0)
        else:
            places = self._path(news, length)
            self._lifted = False
        steps = np.abs(np.diff(places))
        speed = float(steps.max(initial=0.0)) * self._rate
        speeds = np.linspace(self._speed, speed, length + 1)[1:]
        self._speed = speed
        out = np.empty((1, length), np.float32)
        play_loop(self._table, places, speeds, self._nodes_per_mm, self._samples_per_speed, length, out)
        return np.asarray(out[0], np.float64)

    def _path(self, news: NDArray[np.float64], length: int) -> NDArray[np.float64]:
        """Return the position at each sample, after the hysteresis."""
        start = float(news[0]) if self.place_mm is None or self._lifted else self.place_mm
        path, half = [start], self._hysteresis_mm / 2
        for position in news.tolist():
            path.append(min(max(path[-1], position - half), position + half))
        self.place_mm = path[-1]
        return np.asarray(np.interp(np.arange(1, length + 1) / length, np.linspace(0, 1, len(path)), path))

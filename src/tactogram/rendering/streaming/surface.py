"""Texture over displacement, played at the finger's position: f = v k.

A pattern of k cycles per mm under a finger at v mm/s is felt at v k Hz. Greenspon et al. (2020) find in skin
vibrations that speed scales the whole spectrum along frequency and that this accounts for the rise of intensity, so no
further gain by speed is added. The surface is a loop: its end is crossfaded into its beginning, so that a finger can
move on endlessly in both directions. What a fast finger would shift above half the engine's rate is removed in
advance, in copies of the surface whose bands end half an octave apart (Williams 1983); the two copies below the limit
are blended by speed.

References
----------
- Greenspon, C. M., McLellan, K. R., Lieber, J. D. & Bensmaia, S. J. (2020). Effect of scanning speed on
  texture-elicited vibrations. J. R. Soc. Interface 17, 20190892. doi 10.1098/rsif.2019.0892
- Williams, L. (1983). Pyramidal parametrics. Computer Graphics 17(3), 1-11. doi 10.1145/964967.801126
"""

from __future__ import annotations

import math
from typing import Literal

import numba
import numpy as np
from numpy.typing import NDArray
from scipy import fft

from tactogram.errors import ParameterError
from tactogram.rendering.streaming.finger_path import MotionBlock
from tactogram.signal.displacement import over_displacement
from tactogram.signal.joining import join
from tactogram.signal.signal import Signal

Block = NDArray[np.float32]
Along = Literal["path", "x", "y"]

CROSSFADE = 0.1
"""Share of a surface's length over which its end and its beginning are crossfaded."""
OVERSAMPLED = 8
"""Nodes per sample of the surface; a cubic interpolates between them (see `tactogram.signal.displacement`)."""
FASTEST_MM_S = 1000.0
"""Highest speed without aliasing."""
MOST_NODES = 20_000_000
"""Largest table, nodes of all copies and axes: 80 MB."""


class SurfaceTexture:
    """A signal over displacement, played at the finger's position by an engine at ``rate`` (Hz).

    A signal over time needs ``speed_mm_s``, at which it was recorded or generated. It is played along the finger's
    path, which never goes back, or along a coordinate: then the same position always feels the same, and a stroke back
    plays it in reverse. Its ``nodes``, float32, shape (copy, axis, node), are the loop, oversampled; the band of each
    copy ends half an octave below that of the previous one. Raises `ParameterError` if the speed is missing, or the
    surface is shorter than 20 samples or too long.
    """

    delay_s = 0.0

    def __init__(
        self,
        name: str,
        signal: Signal,
        *,
        rate: float,
        speed_mm_s: float | None = None,
        along: Along = "path",
    ) -> None:
        if along not in ("path", "x", "y"):
            raise ParameterError(f"along must be path, x or y, got {along!r}")
        if signal.domain == "time":
            if speed_mm_s is None:
                raise ParameterError(
                    f"{name} is over time: give speed_mm_s, the speed at which it was recorded or generated"
                )
            signal = over_displacement(signal, speed_mm_s)
        self.name, self.unit, self.axes, self.along = name, signal.unit, signal.axes, along
        self.holds_at_rest = signal.unit == "1"
        self.signal = signal
        """The signal over displacement."""
        loop = looped(signal)
        self.length_mm = loop.length_mm
        copies = 1 + max(0, math.ceil(2 * math.log2(FASTEST_MM_S * signal.rate / rate))) + 1
        if copies * loop.samples.size * OVERSAMPLED > MOST_NODES:
            raise ParameterError(
                f"{name} is too long for a stream: {signal.length_mm:g} mm at {signal.rate:g} samples per mm; cut it "
                "or lower its rate"
            )
        self.nodes = _copies(loop, copies)
        self.nodes_per_mm = loop.rate * OVERSAMPLED
        self.samples_per_speed = signal.rate / rate
        variance = np.var(loop.samples.astype(np.float64), axis=1)
        self.level = float(np.sqrt(variance.sum()))

    def render(self, motion: MotionBlock, out: Block) -> None:
        """Write the next ``motion.count`` samples to ``out``, float32, shape (axis, most)."""
        place = {"path": motion.path_mm, "x": motion.x_mm, "y": motion.y_mm}[self.along]
        _play(
            self.nodes,
            place,
            motion.speed_mm_s,
            self.nodes_per_mm,
            self.samples_per_speed,
            motion.count,
            out,
        )


def looped(signal: Signal) -> Signal:
    """Return ``signal`` as a loop: its end crossfaded into its beginning, at the lag where the two match best.

    Raises `ParameterError` if it is shorter than 20 samples.
    """
    length = len(signal)
    if length < 20:
        raise ParameterError(f"a surface must have at least 20 samples to be looped, got {length}")
    fade = max(2, round(CROSSFADE * length))
    head = signal.cut(0, 2 * fade + 1)
    joined = join([signal, head], overlap_s=fade / signal.rate, search_s=fade / signal.rate)
    lag = length + len(head) - fade - len(joined)
    return joined.cut(lag + fade, length)


def _copies(loop: Signal, count: int) -> NDArray[np.float32]:
    """Return the loop's copies, oversampled, shape (copy, axis, node); copy c has 2^(-c/2) of the loop's band."""
    length = len(loop)
    spectrum = fft.rfft(loop.samples.astype(np.float64), axis=1)
    frequency = np.arange(spectrum.shape[1]) / length  # cycles per sample
    if length % 2 == 0:
        spectrum[:, -1] *= 0.5
    copies = np.empty((count, len(loop.axes), length * OVERSAMPLED), np.float32)
    for copy in range(count):
        edge = 0.5 * 2 ** (-copy / 2)
        gain = np.ones_like(frequency) if copy == 0 else _low_pass(frequency, edge)
        copies[copy] = fft.irfft(spectrum * gain, n=length * OVERSAMPLED, axis=1) * OVERSAMPLED
    return copies


def _low_pass(frequency: NDArray[np.float64], edge: float) -> NDArray[np.float64]:
    """Return a gain of 1 up to 0.8 of ``edge``, 0 from ``edge`` on, and half a cosine in between."""
    share = np.clip((frequency / edge - 0.8) / 0.2, 0, 1)
    gain: NDArray[np.float64] = 0.5 + 0.5 * np.cos(np.pi * share)
    return gain


@numba.njit(cache=True, nogil=True)
def _play(
    table: NDArray[np.float32],  # (copy, axis, node)
    place: NDArray[np.float64],
    speed: NDArray[np.float64],
    nodes_per_mm: float,
    samples_per_speed: float,
    count: int,
    out: Block,
) -> None:
    copies, axes, nodes = table.shape
    for i in range(count):
        at = (place[i] * nodes_per_mm) % nodes
        node = int(at)
        if node >= nodes:
            node = 0
        r = at - node
        i0 = node - 1 if node > 0 else nodes - 1
        i2 = node + 1 if node + 1 < nodes else 0
        i3 = i2 + 1 if i2 + 1 < nodes else 0
        # Samples of the surface per sample of the engine; above 1 the finest detail would alias.
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

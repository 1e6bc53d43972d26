"""Texture over displacement, played at the finger's position: f = v k.

A pattern of k cycles per mm under a finger at v mm/s is felt at v k Hz. Greenspon et al. (2020) find in skin
vibrations that speed scales the whole spectrum along frequency and that this accounts for the rise of intensity, so no
further gain by speed is added. The surface is a loop: its end is crossfaded into its beginning, so that a finger can
move on endlessly in both directions. What a fast finger would shift above half the engine's rate is removed in
advance (`tactogram.rendering.drive.path_playback`).

References
----------
- Greenspon, C. M., McLellan, K. R., Lieber, J. D. & Bensmaia, S. J. (2020). Effect of scanning speed on
  texture-elicited vibrations. J. R. Soc. Interface 17, 20190892. doi 10.1098/rsif.2019.0892
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.displays.family import MotionBlock
from tactogram.rendering.drive.path_playback import OVERSAMPLED, band_limited, copy_count, play_loop
from tactogram.signal.displacement import over_displacement
from tactogram.signal.joining import join
from tactogram.signal.signal import Signal

Block = NDArray[np.float32]
Along = Literal["path", "x", "y"]

CROSSFADE = 0.1
"""Share of a surface's length over which its end and its beginning are crossfaded."""
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
        copies = copy_count(signal.rate, rate)
        if copies * loop.samples.size * OVERSAMPLED > MOST_NODES:
            raise ParameterError(
                f"{name} is too long for a stream: {signal.length_mm:g} mm at {signal.rate:g} samples per mm; cut it "
                "or lower its rate"
            )
        self.nodes = band_limited(loop.samples, copies)
        self.nodes_per_mm = loop.rate * OVERSAMPLED
        self.samples_per_speed = signal.rate / rate
        variance = np.var(loop.samples.astype(np.float64), axis=1)
        self.level = float(np.sqrt(variance.sum()))

    def render(self, motion: MotionBlock, out: Block) -> None:
        """Write the next ``motion.count`` samples to ``out``, float32, shape (axis, most)."""
        place = {"path": motion.path_mm, "x": motion.x_mm, "y": motion.y_mm}[self.along]
        tables = self.nodes, place, motion.speed_mm_s
        play_loop(*tables, self.nodes_per_mm, self.samples_per_speed, motion.count, out)


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

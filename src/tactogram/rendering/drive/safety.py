"""Last step before a display: no NaN, no DC where forbidden, fades, and the limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.signal.signal import Signal

HIGHPASS_HZ = 5.0


def safe(drive: Signal, display: Display, *, faded: bool = False) -> tuple[Signal, dict[str, Any]]:
    """Return a drive that may be sent: faded in and out, without DC where forbidden, within the limits; and facts.

    ``faded`` is whether the family faded it already, by `settled`. The facts are ``clipped_samples`` that lay outside,
    ``removed_dc`` (largest of the channels, in the drive's unit) and ``scaled`` (factor after the mean was removed, 1
    unless that pushed a peak over the limit). Raises `ParameterError` if rate, unit or channels are not the display's:
    a defect of the family.
    """
    expected = (display.rate, display.unit, display.channels)
    if (drive.rate, drive.unit, drive.axes) != expected:
        raise ParameterError.must("drive", f"be {expected}", (drive.rate, drive.unit, drive.axes))
    x = drive.samples.astype(np.float64)
    outside = int(np.count_nonzero((x > display.limit) | (x < display.floor)))
    x = np.clip(x, display.floor, display.limit)
    x, removed, scaled = *settled(x, display, faded=faded), 1.0
    if not display.dc:
        over = float(np.max([x.max() / display.limit, x.min() / display.floor, 1.0]))
        x, scaled = x / over, 1 / over
    low, high = bounds(display)
    done = np.clip(x.astype(np.float32), low, high)
    return drive.with_samples(done), {"clipped_samples": outside, "removed_dc": removed, "scaled": scaled}


def settled(
    x: NDArray[np.float64], display: Display, *, faded: bool = False
) -> tuple[NDArray[np.float64], float]:
    """Return a drive that begins and ends at rest, without DC where forbidden, and the largest mean removed.

    ``x`` is float64, shape (channel, time), in the drive's unit; if it is ``faded``, only the mean is removed. If the
    display's rest is 0 this is linear, so a family scales its drive to a limit afterwards.
    """
    window = fade_window(x.shape[1], round(display.fade_ms / 1e3 * display.rate))
    if not faded:
        x = display.rest + (x - display.rest) * window
    if display.dc:
        return x, 0.0
    # The removed mean has the window's shape, so that the drive still begins and ends at 0.
    mean = x.mean(axis=1, keepdims=True)
    weight = window.mean()
    x = x - mean * window / weight if weight > 0 else np.zeros_like(x)
    return x, float(np.abs(mean).max())


def fade_window(length: int, fade: int) -> NDArray[np.float64]:
    """Return a raised cosine from 0 to 1 over ``fade`` samples, 1, and back to 0; float64, shape (length,).

    The last sample is 0 even without a fade, since many devices hold it.
    """
    fade = min(fade, length // 2)
    window = np.ones(length)
    if fade > 0:
        rise = np.sin(np.pi / 2 * np.arange(fade) / fade) ** 2
        window[:fade] = rise
        window[-fade:] = rise[::-1]
    window[-1] = 0.0
    return window


def bounds(display: Display) -> tuple[np.float32, np.float32]:
    """Return the lowest and highest float32 within the display's limits."""
    low, high = np.float32(display.floor), np.float32(display.limit)
    if float(low) < display.floor:
        low = np.nextafter(low, np.float32(np.inf))
    if float(high) > display.limit:
        high = np.nextafter(high, np.float32(-np.inf))
    return low, high


class DriveGuard:
    """Guard between a stream of drive blocks and a device: the guarantees of `safe`, block by block.

    A block with NaN or infinity is a fault: it and everything after it is replaced by a fade to rest, until `reset`.
    ``missing`` returns blocks for a lost connection: a fade to rest, then rest; the next block fades in. No block
    leaves the limits, and none begins with a jump from the last sample beyond what the fade allows. If DC is forbidden,
    a first-order high-pass at `HIGHPASS_HZ` removes it.
    """

    def __init__(self, display: Display) -> None:
        self.display = display
        self.fault: str | None = None
        self._low, self._high = bounds(display)
        self._step = 1 / max(1.0, display.fade_ms / 1e3 * display.rate)
        self._pole = 0.0 if display.dc else float(np.exp(-2 * np.pi * HIGHPASS_HZ / display.rate))
        self._filter = scipy.signal.lfilter  # imported here, not in the first block of a device's callback
        self.reset()

    def reset(self) -> None:
        """Start again at rest: the next block fades in."""
        count = len(self.display.channels)
        self.fault = None
        self._gain = 0.0
        self._held = np.full((count, 1), self.display.rest)
        self._state = np.zeros((count, 1))

    def process(self, block: NDArray[np.floating]) -> NDArray[np.float32]:
        """Return the block to send, float32, shape (channel, time) as ``block``, in the display's unit.

        Raises `ParameterError` if ``block`` has another shape. NaN and infinity are no errors but fade to rest, see
        ``fault``.
        """
        if block.ndim != 2 or len(block) != len(self.display.channels):
            raise ParameterError.must("block", f"be ({len(self.display.channels)}, time)", block.shape)
        if self.fault is None and not np.isfinite(block).all():
            self.fault = "a block contains NaN or infinity"
        if self.fault is not None:
            return self.missing(block.shape[1])
        return self._sent(np.clip(block.astype(np.float64), self._low, self._high), to=1.0)

    def missing(self, length: int) -> NDArray[np.float32]:
        """Return a fade from the last sample to rest, for the time without blocks, shape (channel, time)."""
        return self._sent(np.repeat(self._held, length, axis=1), to=0.0)

    def leaving(self, block: NDArray[np.floating]) -> NDArray[np.float32]:
        """Return a block, shape (channel, time), faded to rest: for a drive that continues without motion."""
        if self.fault is not None or block.ndim != 2 or not np.isfinite(block).all():
            return self.missing(block.shape[-1])
        return self._sent(np.clip(block.astype(np.float64), self._low, self._high), to=0.0)

    def _sent(self, x: NDArray[np.float64], *, to: float) -> NDArray[np.float32]:
        count = x.shape[1]
        if count == 0:
            return np.zeros(x.shape, np.float32)
        steps = self._step * np.arange(1, count + 1)
        gain = np.clip(self._gain + np.sign(to - self._gain) * steps, 0.0, 1.0)
        self._gain = float(gain[-1])
        self._held = x[:, -1:]
        if self._pole:
            x, self._state = self._filter([1.0, -1.0], [1.0, -self._pole], x, axis=1, zi=self._state)
        rest = self.display.rest
        y = rest + (x - rest) * np.sin(np.pi / 2 * gain) ** 2
        sent: NDArray[np.float32] = np.clip(y.astype(np.float32), self._low, self._high)
        return sent

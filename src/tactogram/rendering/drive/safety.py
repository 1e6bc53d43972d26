"""Last step before a display: no NaN, no DC where forbidden, fades, and the limits."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.signal.signal import Signal


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

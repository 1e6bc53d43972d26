"""Reduction of a signal's axes to those of a display, as the display's file or the caller chooses."""

from __future__ import annotations

import numpy as np

from tactogram.errors import ParameterError
from tactogram.signal.filters import dft321
from tactogram.signal.signal import Signal

WAYS = ("dft321", "mean", "channels")


def combined(signal: Signal, how: str) -> tuple[Signal, str]:
    """Return the axes of ``signal`` that a display renders, and a sentence on them.

    - ``dft321``: three axes become one with their energy at every frequency; of two axes it has the mean power, with a
      silent third; one axis stays.
    - ``mean``: the mean of all axes; opposite signs on two of them cancel.
    - ``channels``: all axes unchanged, one for each channel of the display.
    - the name of an axis: that axis.

    Raises `ParameterError` if there is no such way or axis, or ``dft321`` is chosen for more than three axes.
    """
    count = len(signal.axes)
    if how in signal.axes:
        rest = [name for name in signal.axes if name != how]
        left_out = f", {', '.join(rest)} left out" if rest else ""
        return signal.select(how), f"axis {how} alone{left_out}"
    if how not in WAYS:
        raise ParameterError(
            f"axes must be one of {', '.join(WAYS)}, or of the signal's ({', '.join(signal.axes)}), got {how!r}"
        )
    if how == "channels":
        return signal, f"{count} axes as they are: {', '.join(signal.axes)}"
    if count == 1:
        return signal, f"the one axis, {signal.axes[0]}"
    if how == "mean":
        return signal.with_samples(signal.samples.mean(axis=0), axes=("mean",)), f"mean of {count} axes"
    if count > 3:
        raise ParameterError(
            f"dft321 is for at most three axes, got {count}; use mean, channels or an axis's name"
        )
    if count == 2:
        silent = np.vstack([signal.samples, np.zeros((1, len(signal)), np.float32)])
        signal = signal.with_samples(silent, axes=(*signal.axes, "none"))
    return dft321(signal), f"DFT321 of {count} axes: their energy at every frequency"

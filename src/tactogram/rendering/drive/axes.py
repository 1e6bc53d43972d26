"""Reduction of a signal's axes to those of a display, or to the one that a file needs."""

from __future__ import annotations

import numpy as np

from tactogram.errors import ParameterError, Remedy
from tactogram.signal import Signal
from tactogram.signal.filters import dft321

WAYS = ("dft321", "mean", "channels")
CHOICES = ("dft321", "mean")
LOST_DB = 2.0
"""Channels whose mean is that much weaker than they are on average are not of the same source. A choice."""


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
        raise ParameterError.must(
            "axes",
            f"be one of {', '.join(WAYS)}, or of the signal's ({', '.join(signal.axes)})",
            how,
            choices=(*WAYS, *signal.axes),
        )
    if how == "channels":
        return signal, f"{count} axes as they are: {', '.join(signal.axes)}"
    if count == 1:
        return signal, f"the one axis, {signal.axes[0]}"
    if how == "mean":
        return signal.with_samples(signal.samples.mean(axis=0), axes=("mean",)), f"mean of {count} axes"
    if count > 3:
        use = Remedy("use mean, channels or the name of one, e.g.", "how", signal.axes[0])
        raise ParameterError(f"dft321 is for at most three axes, got {count}", remedy=use)
    if count == 2:
        silent = np.vstack([signal.samples, np.zeros((1, len(signal)), np.float32)])
        signal = signal.with_samples(silent, axes=(*signal.axes, "none"))
    return dft321(signal), f"DFT321 of {count} axes: their energy at every frequency"


def to_one_axis(signal: Signal, choice: str | None = None) -> tuple[Signal, str | None]:
    """Return one axis of a signal, and how it was derived in words; None if it had only one.

    ``choice`` is the name of an axis, ``"dft321"`` (three axes: their energy at every frequency, the default for
    three) or ``"mean"`` (channels of the same source). The default for any other number is the mean, but the sum of
    their power, each in or against the phase of the strongest, if the mean loses `LOST_DB`. Raises `ParameterError` if
    there is no such axis, ``dft321`` is chosen for another number than three, or the mean is silent since channels
    cancel.
    """
    if choice in signal.axes:
        selected = signal.select(choice)
        return selected, f"axis {choice} of {', '.join(signal.axes)}" if len(signal.axes) > 1 else None
    if choice is not None and choice not in CHOICES:
        raise ParameterError.one_of("axis", (*signal.axes, *CHOICES), choice)
    if len(signal.axes) == 1:
        return signal, None
    names = ", ".join(signal.axes)
    if choice == "dft321" or (choice is None and len(signal.axes) == 3):
        return dft321(signal), f"DFT321 of {names}"
    x = signal.samples.astype(np.float64)
    mean, alike = x.mean(axis=0), np.cov(x, bias=True)
    power, left = float(np.trace(alike)), float(mean.var())
    if choice == "mean" and left < 1e-6 * power:
        raise ParameterError(
            f"the mean of {names} is silent, since they cancel; choose one of them, or omit axis"
        )
    if choice == "mean" or left * 10 ** (LOST_DB / 10) >= power / len(x):
        return signal.with_samples(mean, axes=("mean",)), f"mean of {names}"
    signs = np.where(alike[np.diag(alike).argmax()] < 0, -1.0, 1.0)
    total = signs @ x
    phases = ", ".join(
        f"{'-' if sign < 0 else ''}{name}" for name, sign in zip(signal.axes, signs, strict=True)
    )
    return signal.with_samples(
        total * np.sqrt(power / total.var()), axes=("sum",)
    ), f"sum of the power of {phases}"

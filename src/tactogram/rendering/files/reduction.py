"""Reduction of several axes or channels to the one that a file or an actuator needs."""

from __future__ import annotations

import numpy as np

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.filters import dft321

CHOICES = ("dft321", "mean")
LOST_DB = 2.0
"""Channels whose mean is that much weaker than they are on average are not of the same source. A choice."""


def to_one_axis(signal: Signal, choice: str | None = None) -> tuple[Signal, str | None]:
    """Return one axis of a signal, and how it was derived in words; None if it had only one.

    ``choice`` is the name of an axis, ``"dft321"`` (three axes: their energy at every frequency, the default for
    three) or ``"mean"`` (channels of the same source). The default for any other number is the mean, but the sum of
    their power, each in or against the phase of the strongest, if the mean loses `LOST_DB`. Raises `ParameterError` if
    there is no such axis, ``dft321`` is chosen for another number than three, or the mean is silent since channels
    cancel.
    """
    if choice in signal.axes:
        one = signal.select(choice)
        return one, f"axis {choice} of {', '.join(signal.axes)}" if len(signal.axes) > 1 else None
    if choice is not None and choice not in CHOICES:
        raise ParameterError(f"axis must be one of {', '.join((*signal.axes, *CHOICES))}, got {choice!r}")
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

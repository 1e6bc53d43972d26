"""Reduction of several axes or channels to the one that a file or an actuator needs."""

from __future__ import annotations

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.filters import dft321

CHOICES = ("dft321", "mean")


def to_one_axis(signal: Signal, choice: str | None = None) -> tuple[Signal, str | None]:
    """Return one axis of a signal, and how it was derived in words; None if it had only one.

    ``choice`` is the name of an axis, ``"dft321"`` (three axes: their energy at every frequency, the default for
    three) or ``"mean"`` (channels of the same source, the default for any other number). Raises `ParameterError` if
    there is no such axis, or ``dft321`` is chosen for another number than three.
    """
    if choice in signal.axes:
        one = signal.select(choice)
        return one, f"axis {choice} of {', '.join(signal.axes)}" if len(signal.axes) > 1 else None
    if choice is not None and choice not in CHOICES:
        raise ParameterError(f"axis must be one of {', '.join((*signal.axes, *CHOICES))}, got {choice!r}")
    if len(signal.axes) == 1:
        return signal, None
    if choice == "mean" or (choice is None and len(signal.axes) != 3):
        mean = signal.samples.mean(axis=0, dtype=float)
        return signal.with_samples(mean, axes=("mean",)), f"mean of {', '.join(signal.axes)}"
    return dft321(signal), f"DFT321 of {', '.join(signal.axes)}"

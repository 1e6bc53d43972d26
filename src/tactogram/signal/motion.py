"""Motion of a finger over time: its speed, its normal force, and when it rests or is lifted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of a finger, from 0 s to the last time; linear in between.

    Parameters
    ----------
    time_s : float64 array, shape (sample,)
        Ascending from 0.
    speed_mm_s : float64 array, shape (sample,)
    force_n : float64 array, shape (sample,), optional
    gain : float64 array, shape (sample,), optional
        0 while the finger rests or is lifted, 1 while it slides, in between as it lands, starts or stops. By default 1.
    contact : float64 array, shape (sample,), optional
        0 while the finger is lifted, 1 while it touches, in between as it lands or lifts. By default 1.

    Raises
    ------
    ParameterError
        If the arrays differ in length, hold fewer than two samples, or contain negative or non-finite values; if times
        do not ascend, or a gain is above 1.

    Examples
    --------
    >>> tactogram.Motion([0, 1], speed_mm_s=[50, 100]).at("speed_mm_s", [0.5])
    array([75.])
    """

    time_s: Array
    speed_mm_s: Array
    force_n: Array | None = None
    gain: Array | None = None
    contact: Array | None = None

    def __post_init__(self) -> None:
        for name in ("time_s", "speed_mm_s", "force_n", "gain", "contact"):
            if (values := getattr(self, name)) is None:
                continue
            array = np.array(values, np.float64)
            if array.ndim != 1 or len(array) < 2 or len(array) != len(self.time_s):
                raise ParameterError(
                    f"{name} of a motion must have one number for each of at least two times, got {array.shape}"
                )
            if not (np.isfinite(array).all() and (array >= 0).all()):
                raise ParameterError(f"{name} of a motion must be finite and >= 0")
            if name in ("gain", "contact") and (array > 1).any():
                raise ParameterError(f"{name} of a motion must be at most 1, got {array.max():g}")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        if self.time_s[0] != 0 or not (np.diff(self.time_s) > 0).all():
            raise ParameterError("time_s of a motion must begin with 0 and ascend")

    @property
    def seconds(self) -> float:
        """Length, s."""
        return float(self.time_s[-1])

    def lasting(self, seconds: float | None) -> float:
        """Return ``seconds``, by default all; raise `ParameterError` if the motion is shorter."""
        if seconds is not None and seconds > self.seconds:
            raise ParameterError.must("seconds", f"be at most the motion's {self.seconds:g}", seconds)
        return self.seconds if seconds is None else seconds

    def at(self, name: str, times: ArrayLike) -> Array | None:
        """Return ``speed_mm_s``, ``force_n``, ``gain`` or ``contact`` at ``times`` (s); None if unknown.

        Float64, shape (time,); held at the ends.
        """
        values = getattr(self, name)
        return None if values is None else np.interp(np.asarray(times, np.float64), self.time_s, values)

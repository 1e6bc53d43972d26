"""Amplitudes <-> the bounded numbers that a network sees, without losing the physical level."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import torch
from torch import Tensor

from tactogram.errors import ParameterError, UnitError
from tactogram.signal import UNITS, Signal
from tactogram.signal.signal import Domain

Scaling = Literal["db", "linear", "power"]


@dataclass(frozen=True, kw_only=True)
class AmplitudeScale:
    """Map from an amplitude in the unit of the signal to a value in ``low..high``, and back.

    Nothing here is ever read from the data: a signal of 1 % of the level stays one of 1 %.

    Parameters
    ----------
    rate : float
        Samples per second (Hz), or per millimetre when ``domain`` is ``"displacement"``.
    unit : str
        Unit of a sample, one of `tactogram.signal.UNITS`.
    domain : {"time", "displacement"}
    scaling : {"db", "linear", "power"}
        What is proportional to the value: the logarithm of the amplitude, the amplitude, or its square.
    floor_db, ceil_db : float, dB re ``ref``
        With ``"db"``, amplitudes at or below the floor become ``low`` and come back as 0. Amplitudes above
        the ceiling become ``high`` and come back as the ceiling. ``"linear"`` and ``"power"`` have no floor:
        amplitude 0 is ``low``.
    ref : float, ``unit``
        The amplitude that is 0 dB.
    low, high : float
        The range of values.
    """

    rate: float
    unit: str = "m/s^2"
    domain: Domain = "time"
    scaling: Scaling = "db"
    floor_db: float = -80.0
    ceil_db: float = 0.0
    ref: float = 1.0
    low: float = -1.0
    high: float = 1.0

    def __post_init__(self) -> None:
        for name in ("rate", "ref"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise ParameterError(f"{name} must be > 0 and finite, got {value}")
        for below, above in (("floor_db", "ceil_db"), ("low", "high")):
            least, most = getattr(self, below), getattr(self, above)
            if not (math.isfinite(least) and math.isfinite(most) and least < most):
                raise ParameterError(f"{below} must be < {above}, both finite, got {least} and {most}")
        if self.unit not in UNITS:
            raise ParameterError(f"unit must be one of {', '.join(UNITS)}, got {self.unit!r}")
        if self.domain not in ("time", "displacement"):
            raise ParameterError(f"domain must be 'time' or 'displacement', got {self.domain!r}")
        if self.scaling not in ("db", "linear", "power"):
            raise ParameterError(f"scaling must be 'db', 'linear' or 'power', got {self.scaling!r}")

    def value(self, amplitude: Tensor) -> Tensor:
        """Return amplitudes (>= 0, in ``unit``) as values in ``low..high``; any shape. Differentiable."""
        if self.scaling == "db":
            least = self.ref * 10 ** (self.floor_db / 20)
            db = 20 * torch.log10(amplitude.clamp_min(least) / self.ref)
            share = (db - self.floor_db) / (self.ceil_db - self.floor_db)
        else:
            share = amplitude / (self.ref * 10 ** (self.ceil_db / 20))
            share = share.square() if self.scaling == "power" else share
        return self.low + (self.high - self.low) * share.clamp(0, 1)

    def amplitude(self, value: Tensor) -> Tensor:
        """Return values, of any shape, as amplitudes in ``unit``; what is outside ``low..high`` counts as its end.

        Raises
        ------
        ParameterError
            If a value is not finite.
        """
        if not bool(torch.isfinite(value).all()):
            raise ParameterError("values must be finite, got NaN or infinity")
        share = ((value - self.low) / (self.high - self.low)).clamp(0, 1)
        if self.scaling == "db":
            db = self.floor_db + (self.ceil_db - self.floor_db) * share
            return torch.where(share > 0, self.ref * 10 ** (db / 20), torch.zeros_like(db))
        share = share.sqrt() if self.scaling == "power" else share
        return share * (self.ref * 10 ** (self.ceil_db / 20))

    def check_signal(self, signal: Signal) -> None:
        """Refuse a signal of another unit, domain or rate.

        Raises
        ------
        UnitError
            If unit or domain are others.
        ParameterError
            If the rate is.
        """
        if signal.unit != self.unit:
            raise UnitError(f"signal must be in {self.unit}, got {signal.unit}")
        if signal.domain != self.domain:
            raise UnitError(f"signal must be over {self.domain}, got one over {signal.domain}")
        if signal.rate != self.rate:
            raise ParameterError(
                f"signal must have rate {self.rate:g}, got {signal.rate:g}; resample it first"
            )

"""The admittance of a transducer, measured: a generator goes to a frequency, a converter takes voltage and current.

This is what `ResonanceTracker` asks for. Generator and converter may be one device or two, real or simulated: whatever
has the calls of `Carrier` and of `Recorder`.

What the converter must do: take both channels at a rate above `LEAST_RATIO` times the carrier, at the same instants.
One that switches a single converter from channel to channel takes the current later than the voltage; at 28 kHz a
microsecond is 10 degrees, and 45 degrees shift the resonance by half its width. ``skew_s`` takes that back.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from tactogram.errors import DeviceError, ParameterError
from tactogram.rendering.transducer.simulation import lock_in

Array = NDArray[np.float64]

LEAST_RATIO = 2.2
"""Of a converter's rate to the carrier."""
ATTEMPTS = 3
"""How often it is measured again where samples were lost."""


class Carrier(Protocol):
    """A generator of a carrier."""

    def retune(self, carrier_hz: float) -> None:
        """Move the carrier; its amplitude stays."""
        ...


class Recorder(Protocol):
    """A converter for two channels.

    Attributes
    ----------
    name : str
    rate : float
        Hz, of each channel.
    full_scale : tuple of float
        Largest magnitudes that the two can measure, V; infinite where that is not known.
    """

    name: str
    rate: float
    full_scale: tuple[float, float]

    def take(self, seconds: float, *, after_s: float) -> tuple[Array, Array]:
        """Return what is taken of both channels from ``after_s`` after this call on, V; NaN where samples were lost.

        Raises
        ------
        DeviceError
            If the device went away or stands still.
        """
        ...


class ProbeSettings(BaseModel):
    """Probe factors between the transducer and the converter."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    volts_per_volt: float = Field(default=1.0, gt=0, allow_inf_nan=False)
    """At the transducer per measured: 10 for a probe of 10:1."""
    amps_per_volt: float = Field(gt=0, allow_inf_nan=False)
    """Through the transducer per measured: 1 over the resistance of a shunt in ohm. There is no default."""
    skew_s: float = Field(default=0.0, ge=-1e-4, le=1e-4)
    """By how much the current is taken later than the voltage, s."""


class MeasurementTiming(BaseModel):
    """Time that a frequency is held, and the part of it that is measured."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    settle_s: float = Field(default=0.05, ge=0, le=5)
    """After the carrier has moved: five time constants of Q 800 at 28 kHz, and what a driver holds back."""
    window_s: float = Field(default=0.02, gt=0, le=1)


class MeasuredAdmittance:
    """Measures at a frequency, as `tactogram.rendering.transducer.resonance_tracking.MeasureAdmittance` asks.

    Parameters
    ----------
    carrier : Carrier
    recorder : Recorder
    probes : Probes
    timing : Timing, optional
    """

    def __init__(
        self,
        carrier: Carrier,
        recorder: Recorder,
        probes: ProbeSettings,
        timing: MeasurementTiming | None = None,
    ) -> None:
        self.probes, self.timing = probes, timing or MeasurementTiming()
        self.measured = self.repeated = self.lost = 0
        self._carrier, self._recorder = carrier, recorder

    def __call__(self, frequency: float) -> complex:
        """Return the admittance at ``frequency`` in Hz, S; not a number where samples were lost again and again.

        Raises
        ------
        ParameterError
            If the converter is too slow for it.
        DeviceError
            If a channel is over its range, there is no voltage, or a device went away.
        """
        recorder, probes = self._recorder, self.probes
        if recorder.rate < LEAST_RATIO * frequency:
            raise ParameterError(
                f"{recorder.name}: takes {recorder.rate:g} samples/s, a carrier of {frequency:g} Hz needs "
                f"{LEAST_RATIO * frequency:.0f}: set its rate"
            )
        self._carrier.retune(frequency)
        for _ in range(ATTEMPTS):
            voltage, current = recorder.take(self.timing.window_s, after_s=self.timing.settle_s)
            if np.isfinite(voltage).all() and np.isfinite(current).all():
                break
            self.repeated += 1
        else:
            self.lost += 1
            return complex(np.nan, np.nan)
        for name, x, most in zip(
            ("voltage", "current"), (voltage, current), recorder.full_scale, strict=True
        ):
            if float(np.abs(x).max()) >= 0.999 * most:
                raise DeviceError(
                    f"{recorder.name}: the {name} reaches the end of its range of {most:g} V: choose a wider one, or "
                    "less drive"
                )
        try:
            ratio = lock_in(voltage, current, rate=recorder.rate, frequency_hz=frequency)
        except ParameterError as error:
            raise DeviceError(
                f"{recorder.name}: {error}; is the amplifier on, the probe in its place?"
            ) from None
        self.measured += 1
        turn = np.exp(-2j * np.pi * frequency * probes.skew_s)
        return complex(ratio * turn * probes.amps_per_volt / probes.volts_per_volt)

"""Admittance of a transducer, measured with a generator and a two-channel converter.

`ResonanceTracker` needs it at one frequency after another. Generator and converter may be one device or two, real or
simulated: anything that implements `Carrier` and `Recorder`, such as a Digilent's inputs (`DigilentRecorder`; tested
against a simulated device with dwfpy's calls only).

The converter must sample both channels at the same instants, at more than `LEAST_RATIO` times the carrier. A
multiplexed converter samples the current later than the voltage; at 28 kHz a microsecond is 10 degrees, and 45 degrees
shift the resonance by half its width. ``skew_s`` corrects for that.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tactogram.errors import DeviceError, ParameterError
from tactogram.extras import device_errors
from tactogram.validation import FrozenModel

Array = NDArray[np.float64]

LEAST_RATIO = 2.2
"""Smallest ratio of the converter's rate to the carrier."""
ATTEMPTS = 3
"""Number of measurements before lost samples count as a lost measurement."""


class NoVoltageError(DeviceError):
    """The drive is off, or too weak to measure with."""


class Carrier(Protocol):
    """Generator of a carrier."""

    def retune(self, carrier_hz: float) -> None:
        """Change the carrier's frequency; its amplitude stays."""
        ...


class Recorder(Protocol):
    """Two-channel converter: name, rate per channel (Hz), and full scale of both channels (V; infinite if unknown)."""

    name: str
    rate: float
    full_scale: tuple[float, float]

    def take(self, seconds: float, *, after_s: float) -> tuple[Array, Array]:
        """Return ``seconds`` of both channels from ``after_s`` after this call, V; NaN where samples were lost.

        Raises `DeviceError` if the device is gone or delivers nothing.
        """
        ...


class ProbeSettings(FrozenModel):
    """Probe factors between the transducer and the converter."""

    volts_per_volt: float = Field(default=1.0, gt=0, allow_inf_nan=False)
    """Voltage at the transducer per measured volt: 10 for a 10:1 probe."""
    amps_per_volt: float = Field(gt=0, allow_inf_nan=False)
    """Current through the transducer per measured volt: 1 / resistance of the shunt in ohm. There is no default."""
    skew_s: float = Field(default=0.0, ge=-1e-4, le=1e-4)
    """Delay of the current's samples after the voltage's, s."""


class MeasurementTiming(FrozenModel):
    """Settling time and measuring time at each frequency."""

    settle_s: float = Field(default=0.05, ge=0, le=5)
    """Wait after each change of the carrier. The default is five time constants of Q 800 at 28 kHz, plus a driver's
    latency."""
    window_s: float = Field(default=0.02, gt=0, le=1)


class MeasuredAdmittance:
    """Measurement of the admittance at a frequency: a `resonance_tracking.MeasureAdmittance`.

    With less than ``least_v`` at the transducer (amplitude, V) nothing is measured.
    """

    def __init__(
        self,
        carrier: Carrier,
        recorder: Recorder,
        probes: ProbeSettings,
        timing: MeasurementTiming | None = None,
        *,
        least_v: float = 0.0,
    ) -> None:
        self.probes, self.timing, self.least_v = probes, timing or MeasurementTiming(), least_v
        self.measured = self.repeated = self.lost = 0
        self._carrier, self._recorder = carrier, recorder

    def __call__(self, frequency: float) -> complex:
        """Return the admittance at ``frequency`` in Hz, S; NaN if samples were lost in every attempt.

        Raises `ParameterError` if the converter is too slow; `NoVoltageError` if there is too little voltage;
        `DeviceError` if a channel reaches its full scale, or a device is gone.
        """
        recorder, probes = self._recorder, self.probes
        if recorder.rate < LEAST_RATIO * frequency:
            raise ParameterError(
                f"{recorder.name}: {recorder.rate:g} samples/s are too few; a carrier of {frequency:g} Hz needs "
                f"{LEAST_RATIO * frequency:.0f}: raise its rate"
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
        for name, x, limit in zip(
            ("voltage", "current"), (voltage, current), recorder.full_scale, strict=True
        ):
            if float(np.abs(x).max()) >= 0.999 * limit:
                raise DeviceError(
                    f"{recorder.name}: the {name} reaches its full scale of {limit:g} V: choose a wider range or "
                    "less drive"
                )
        if np.sqrt(2) * float(voltage.std()) * probes.volts_per_volt < self.least_v:
            raise NoVoltageError(f"{recorder.name}: less than {self.least_v:.3g} V at the transducer")
        try:
            ratio = lock_in(voltage, current, rate=recorder.rate, frequency_hz=frequency)
        except ParameterError as error:
            raise NoVoltageError(f"{recorder.name}: {error}; check the amplifier and the probes") from None
        self.measured += 1
        turn = np.exp(-2j * np.pi * frequency * probes.skew_s)
        return complex(ratio * turn * probes.amps_per_volt / probes.volts_per_volt)


def lock_in(voltage: Array, current: Array, *, rate: float, frequency_hz: float) -> complex:
    """Return the admittance at ``frequency_hz``, S, from samples of voltage (V) and current (A), shape (time,).

    The last whole number of periods is used. Raises `ParameterError` if there is no whole period, or no voltage at
    that frequency.
    """
    if voltage.ndim != 1 or voltage.shape != current.shape:
        raise ParameterError(
            f"voltage and current must have the same length, got {voltage.shape} and {current.shape}"
        )
    count = int(int(len(voltage) * frequency_hz / rate) * rate / frequency_hz)
    if count < 2:
        raise ParameterError(f"needs a whole period of {frequency_hz:g} Hz, got {len(voltage) / rate:g} s")
    turn = np.exp(-2j * np.pi * frequency_hz * np.arange(count) / rate) * np.hanning(count)
    volts = voltage[-count:] @ turn
    if abs(volts) <= 1e-9 * float(np.abs(voltage[-count:]).sum() + 1e-300):
        raise ParameterError(f"no voltage at {frequency_hz:g} Hz: the drive is off or at another frequency")
    return complex((current[-count:] @ turn) / volts)


POLL_S = 0.001
STALLED_S = 2.0
"""Longest time that a measurement may take beyond its window."""


class ScopeSettings(FrozenModel):
    """Settings of the inputs."""

    voltage: int = Field(default=1, ge=1, le=4)
    """Input for the voltage, as labelled on the device."""
    current: int = Field(default=2, ge=1, le=4)
    rate: float = Field(default=400_000.0, gt=0)
    """At this rate 8,192 samples, an Analog Discovery 2's buffer, are 20 ms."""
    range_v: tuple[float, float] = (50.0, 5.0)
    """Widths of the inputs' ranges, peak to peak; the device uses the next available ones."""


class DigilentRecorder:
    """An `admittance.Recorder` on a device's inputs; one buffer per measurement.

    ``device`` and ``module`` are those of `AnalogDiscovery.opened_device`. In tests, ``sleep`` and ``clock`` replace
    those of `time`. Raises `DeviceError` if the device has no such inputs.
    """

    def __init__(
        self,
        device: Any,
        module: Any,
        inputs: ScopeSettings,
        *,
        name: str,
        sleep: Callable[[float], None] = time.sleep,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.name, self._module, self._sleep, self._clock = name, module, sleep, clock
        self._scope = device.analog_input
        self._channels = (inputs.voltage - 1, inputs.current - 1)
        if max(self._channels) >= len(self._scope.channels):
            raise DeviceError(f"{name}: no input {max(self._channels) + 1}")
        with device_errors(name, library="dwfpy"):
            for channel, width in zip(self._channels, inputs.range_v, strict=True):
                self._scope.setup_channel(channel, range=width, filter="decimate", enabled=True)
            self._scope.setup_acquisition(mode="single", sample_rate=inputs.rate, configure=True)
            self.rate = float(self._scope.frequency)
            voltage, current = (float(self._scope.channels[c].range) / 2 for c in self._channels)
        self.full_scale = (voltage, current)

    def take(self, seconds: float, *, after_s: float) -> tuple[Array, Array]:
        """Return a buffer of both inputs, V; at most as many samples as the device holds.

        Raises `DeviceError` if the device is gone or the measurement does not finish.
        """
        self._sleep(after_s)
        scope, done = self._scope, self._module.Status.DONE
        with device_errors(self.name, library="dwfpy"):
            count = min(round(seconds * self.rate), int(scope.buffer_size_max))
            scope.setup_acquisition(buffer_size=count, configure=True, start=True)
            until = self._clock() + seconds + STALLED_S
            while scope.read_status(read_data=True) != done:
                if self._clock() > until:
                    raise DeviceError(f"{self.name}: its inputs delivered nothing for {STALLED_S:g} s")
                self._sleep(POLL_S)
            voltage, current = (
                np.asarray(scope.channels[c].get_data(0, count), np.float64) for c in self._channels
            )
        return voltage, current

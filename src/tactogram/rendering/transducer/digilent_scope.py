"""Inputs of the Analog Discovery whose generator is in use: voltage and current at the same instants.

A device can be opened only once, so its inputs are read through the generator's handle; both converters run
simultaneously. Tested against a simulated device with dwfpy's calls only.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from tactogram.errors import DeviceError
from tactogram.extras import device_errors

Array = NDArray[np.float64]

POLL_S = 0.001
STALLED_S = 2.0
"""Longest time that a measurement may take beyond its window."""


class ScopeSettings(BaseModel):
    """Settings of the inputs."""

    model_config = ConfigDict(frozen=True, extra="forbid")

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

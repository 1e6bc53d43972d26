"""Digilent Analog Discovery and related devices: analogue inputs by WaveForms."""

from __future__ import annotations

from contextlib import suppress
from time import monotonic, sleep
from typing import Any, Literal

import numpy as np
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.extras import device_errors, digilents, imported
from tactogram.signal import parse_unit
from tactogram.validation import FrozenModel
from tactogram_capture.source import Block, SourceKind
from tactogram_capture.stream.channels import DeviceSource, axis_names

_POLL_S = 0.002


class ScopeFormat(FrozenModel):
    """Options of ``digilent:SERIAL``: the format in which inputs are read."""

    channels: str = "1"
    """Printed numbers of the inputs, from 1, separated by commas."""
    rate: float = Field(default=10000.0, gt=0, allow_inf_nan=False)
    """Up to a few 100 kHz over USB; samples lost at higher rates are marked."""
    range: float = Field(default=5.0, gt=0, allow_inf_nan=False)
    """Width of the input's range, V peak to peak; the device chooses its next range."""
    axes: str | None = None
    unit: str = "V"
    scale: float = Field(default=1.0, allow_inf_nan=False)
    """``unit`` per V."""
    filter: Literal["decimate", "average"] = "average"
    """How the converter's own, faster samples are reduced to ``rate``."""


class DigilentSource(DeviceSource):
    """Inputs of an Analog Discovery; ``serial`` is its serial number, empty for the first device."""

    # WaveForms raises its own kinds, which cannot be imported without it.
    failures = (Exception,)

    def __init__(self, serial: str, form: ScopeFormat, *, name: str) -> None:
        super().__init__(name)
        self.form, self._serial = form, serial
        self.rate = form.rate
        self.unit, factor = parse_unit(form.unit)
        self._factor = form.scale * factor
        self.full_scale = form.range / 2 * abs(self._factor)
        self._channels = _channels(form, name)
        numbers = [f"c{channel + 1}" for channel in self._channels]
        self.axes = axis_names(len(numbers), form.axes, default=numbers, where=name)
        self.corrupted = 0

    def facts(self) -> dict[str, Any]:
        """Return the facts so far."""
        return super().facts() | {"corrupted": self.corrupted}

    def _open(self) -> Any:
        dwfpy = imported("dwfpy", extra="dwf", what="Digilent devices")
        with device_errors(self.name, library="dwfpy"):
            device = dwfpy.Device(serial_number=self._serial or None)
            device.open()
            try:
                inputs = device.analog_input
                for channel in self._channels:
                    inputs.setup_channel(
                        channel, range=self.form.range, filter=self.form.filter, enabled=True
                    )
                # A record without a length runs until it is stopped.
                inputs.setup_acquisition(
                    mode="record", sample_rate=self.form.rate, record_length=0, configure=True, start=True
                )
                self.rate = float(inputs.frequency)
            except BaseException:
                device.close()
                raise
        return device

    def _close(self, device: Any) -> None:
        with suppress(OSError, RuntimeError):
            device.close()

    def _read(self, device: Any, timeout_s: float) -> Block | None:
        until, inputs = monotonic() + timeout_s, device.analog_input
        while True:
            inputs.read_status(read_data=True)
            available, lost, corrupted = inputs.record_status
            if available or lost:
                break
            if monotonic() >= until:
                return None
            sleep(_POLL_S)
        samples = np.full((len(self.axes), lost + available), np.nan)
        if available:
            columns = [inputs.channels[c].get_data(0, available) for c in self._channels]
            samples[:, lost:] = np.stack(columns) * self._factor
        # The oldest samples are those overwritten during the read.
        corrupted = min(corrupted, available)
        samples[:, lost : lost + corrupted] = np.nan
        self.corrupted += corrupted
        return self._block(samples)


def _find(find_s: float) -> dict[str, str]:
    return digilents()


def _channels(form: ScopeFormat, name: str) -> list[int]:
    numbers = [part.strip() for part in form.channels.split(",")]
    if not all(part.isdigit() and 1 <= int(part) <= 16 for part in numbers) or len(set(numbers)) != len(
        numbers
    ):
        raise ParameterError(f"{name}: channels must be numbers from 1, like 1,2, got {form.channels!r}")
    return [int(part) - 1 for part in numbers]


SOURCE = SourceKind(
    "digilent", "Digilent input", "digilent:?channels=1,2", ScopeFormat, DigilentSource, find=_find
)

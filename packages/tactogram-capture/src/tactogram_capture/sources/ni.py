"""National Instruments: analogue inputs by NI-DAQmx."""

from __future__ import annotations

import re
from contextlib import suppress
from typing import Any, Literal

import numpy as np
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.extras import device_errors, imported
from tactogram.signal import STANDARD_GRAVITY, parse_unit
from tactogram.validation import FrozenModel
from tactogram_capture.source import Block, SourceKind
from tactogram_capture.stream.channels import DeviceSource, axis_names

WAITING_S = 10.0
"""Samples buffered by the driver, s; when its buffer is full, it stops rather than lose samples silently."""
_TIMED_OUT = -200284
_TERMINALS = {"default": "DEFAULT", "rse": "RSE", "nrse": "NRSE", "diff": "DIFF", "pseudodiff": "PSEUDO_DIFF"}


class AnalogFormat(FrozenModel):
    """Options of ``ni:CHANNELS``: the format in which analogue inputs are read."""

    rate: float = Field(default=10000.0, gt=0, allow_inf_nan=False)
    kind: Literal["voltage", "acceleration"] = "voltage"
    """``acceleration`` supplies an IEPE sensor with current and reads m/s^2, by ``sensitivity``."""
    sensitivity: float = Field(default=100.0, gt=0, allow_inf_nan=False)
    """Of an IEPE sensor, mV per g."""
    current_ma: float = Field(default=4.0, ge=0, le=20)
    """Supply of an IEPE sensor, mA."""
    range: float = Field(default=5.0, gt=0, allow_inf_nan=False)
    """Largest magnitude: V, or g."""
    terminals: Literal["default", "rse", "nrse", "diff", "pseudodiff"] = "default"
    axes: str | None = None
    """Names of the channels, separated by commas."""
    unit: str | None = None
    """Unit of the quantity that a voltage represents; needs ``scale``."""
    scale: float = Field(default=1.0, allow_inf_nan=False)
    """``unit`` per V: 98.0665 m/s^2 for a sensor of 100 mV per g."""


class NiSource(DeviceSource):
    """Analogue inputs of a National Instruments device; ``channels`` as NI-DAQmx writes them, ``Dev1/ai0:2``.

    The driver loses nothing: it stops instead.
    """

    failed = "stopped"

    def __init__(self, channels: str, form: AnalogFormat, *, name: str) -> None:
        if not re.fullmatch(r"[\w-]+/ai\d+(?:\s*[:,]\s*(?:[\w-]+/)?(?:ai)?\d+)*", channels):
            raise ParameterError(f"{name}: channels must be like Dev1/ai0:2, got {channels!r}")
        super().__init__(name)
        self.form, self._channels = form, channels
        self.rate = form.rate
        self.unit, self._factor = ("m/s^2", STANDARD_GRAVITY) if form.kind == "acceleration" else ("V", 1.0)
        if form.unit is not None:
            self.unit, factor = parse_unit(form.unit)
            self._factor = form.scale * factor
        self.full_scale = form.range * abs(self._factor)

    def _open(self) -> Any:
        nidaqmx = imported("nidaqmx", extra="daq", what="National Instruments devices")
        constants = imported("nidaqmx.constants", extra="daq", what="National Instruments devices")
        self.failures = (nidaqmx.errors.DaqError,)
        with device_errors(self.name, library="nidaqmx"):
            task = nidaqmx.Task()
            try:
                self._configure(task, constants)
                task.start()
            except BaseException:
                task.close()
                raise
        return task

    def _close(self, device: Any) -> None:
        with suppress(*self.failures):  # an unplugged device cannot be stopped
            device.close()

    def _read(self, device: Any, timeout_s: float) -> Block | None:
        count = max(1, min(int(self.form.rate * 0.01), 4096))
        available = int(device.in_stream.avail_samp_per_chan)
        if available < count and timeout_s > 0:
            # The driver waits for this many, or raises; it keeps the samples received until then.
            try:
                rows = device.read(number_of_samples_per_channel=count, timeout=timeout_s)
            except self.failures as error:
                if getattr(error, "error_code", None) != _TIMED_OUT:
                    raise
                return None
        elif available:
            rows = device.read(number_of_samples_per_channel=available, timeout=timeout_s)
        else:
            return None
        return self._block(np.atleast_2d(np.asarray(rows, np.float64)) * self._factor)

    def _configure(self, task: Any, constants: Any) -> None:
        form = self.form
        wiring = getattr(constants.TerminalConfiguration, _TERMINALS[form.terminals])
        add = task.ai_channels
        if form.kind == "acceleration":
            add.add_ai_accel_chan(
                self._channels,
                min_val=-form.range,
                max_val=form.range,
                sensitivity=form.sensitivity,
                current_excit_val=form.current_ma / 1000,
                terminal_config=wiring,
            )
        else:
            add.add_ai_voltage_chan(
                self._channels, min_val=-form.range, max_val=form.range, terminal_config=wiring
            )
        terminals = [str(channel).rpartition("/")[2] for channel in task.channel_names]
        self.axes = axis_names(len(terminals), form.axes, default=terminals, where=self.name)
        task.timing.cfg_samp_clk_timing(
            form.rate,
            sample_mode=constants.AcquisitionType.CONTINUOUS,
            samps_per_chan=int(max(1000, WAITING_S * form.rate)),
        )
        # The device rounds to a fraction of its clock rate.
        self.rate = float(task.timing.samp_clk_rate)


def _find(find_s: float) -> dict[str, str]:
    system = imported("nidaqmx.system", extra="daq", what="National Instruments devices")
    with device_errors("ni", library="nidaqmx"):
        names = [d.name for d in system.System.local().devices if len(d.ai_physical_chans)]
    return {f"ni:{name}/ai0": "National Instruments device" for name in names}


SOURCE = SourceKind(
    "ni", "National Instruments input", "ni:Dev1/ai0:2?rate=10000", AnalogFormat, NiSource, find=_find
)

"""National Instruments: analogue inputs by NI-DAQmx."""

from __future__ import annotations

import re
from time import monotonic
from types import TracebackType
from typing import Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from tactogram.capture.source import Block, SourceLost
from tactogram.capture.stream.rate_estimate import RateMeter
from tactogram.errors import ParameterError
from tactogram.extras import device_errors, imported, one_line
from tactogram.signal.units import STANDARD_GRAVITY, parse_unit

WAITING_S = 10.0
"""How much the driver keeps for whoever reads; more, and it stops rather than lose samples silently."""


class AnalogFormat(BaseModel):
    """Format in which analogue inputs are read."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    rate: float = Field(default=10000.0, gt=0, allow_inf_nan=False)
    kind: Literal["voltage", "acceleration"] = "voltage"
    """``acceleration`` feeds an IEPE sensor its current and reads m/s^2, by ``sensitivity``."""
    sensitivity: float = Field(default=100.0, gt=0, allow_inf_nan=False)
    """Of an IEPE sensor, mV per g."""
    current_ma: float = Field(default=4.0, ge=0, le=20)
    """That feeds an IEPE sensor."""
    range: float = Field(default=5.0, gt=0, allow_inf_nan=False)
    """Largest magnitude to be measured: V, or g."""
    terminals: Literal["default", "rse", "nrse", "diff", "pseudodiff"] = "default"
    axes: str | None = None
    """Names of the channels, separated by commas."""
    unit: str | None = None
    """Unit of the samples where a voltage stands for something; needs ``scale``."""
    scale: float = Field(default=1.0, allow_inf_nan=False)
    """``unit`` per V: 98.0665 m/s^2 for a sensor of 100 mV per g."""


class NiSource:
    """Analogue inputs of a National Instruments device; see `tactogram.capture.source.Source`.

    Parameters
    ----------
    channels : str
        As NI-DAQmx calls them: ``Dev1/ai0:2``.
    form : AnalogFormat
    name : str
        The address.
    """

    def __init__(self, channels: str, form: AnalogFormat, *, name: str) -> None:
        if not re.fullmatch(r"[\w-]+/ai\d+(?:\s*[:,]\s*(?:[\w-]+/)?(?:ai)?\d+)*", channels):
            raise ParameterError(f"{name}: channels must be like Dev1/ai0:2, got {channels!r}")
        self.name, self.form, self._channels = name, form, channels
        self.rate: float | None = form.rate
        self.unit, self._factor = ("m/s^2", STANDARD_GRAVITY) if form.kind == "acceleration" else ("V", 1.0)
        if form.unit is not None:
            self.unit, factor = parse_unit(form.unit)
            self._factor = form.scale * factor
        self.full_scale = form.range * abs(self._factor)
        self.axes: tuple[str, ...] = ()
        self.meter = RateMeter()
        self._task: Any = None
        self._error: type[BaseException] = OSError
        self._next = 0

    def __enter__(self) -> Self:
        """Open and start it.

        Raises
        ------
        MissingExtraError, DeviceError
            If nidaqmx or its driver is not installed, or the device is not there.
        """
        nidaqmx = imported("nidaqmx", extra="daq", what="National Instruments devices")
        constants = imported("nidaqmx.constants", extra="daq", what="National Instruments devices")
        self._error = nidaqmx.errors.DaqError
        with device_errors(self.name, library="nidaqmx"):
            task = nidaqmx.Task()
            try:
                self._configure(task, constants)
                task.start()
            except BaseException:
                task.close()
                raise
        self._task = task
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop and close it."""
        task, self._task = self._task, None
        if task is not None:
            try:
                task.close()
            except self._error:
                # A device that was unplugged cannot be told to stop.
                return

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return what has come; None if nothing did within ``timeout_s``.

        Raises
        ------
        SourceLost
            If the device went away, or the driver stopped because nobody read for `WAITING_S`.
        """
        if self._task is None:
            raise SourceLost(f"{self.name}: is not open")
        wanted = max(1, min(int(self.form.rate * 0.01), 4096))
        try:
            available = int(self._task.in_stream.avail_samp_per_chan)
            if available < wanted and timeout_s > 0:
                # The driver waits for so many, or raises; what came until then stays with it.
                try:
                    rows = self._task.read(number_of_samples_per_channel=wanted, timeout=timeout_s)
                except self._error as error:
                    if getattr(error, "error_code", None) != _TIMED_OUT:
                        raise
                    return None
            elif available:
                rows = self._task.read(number_of_samples_per_channel=available, timeout=timeout_s)
            else:
                return None
        except self._error as error:
            raise SourceLost(f"{self.name}: stopped while it was read ({one_line(error)})") from error
        samples = np.atleast_2d(np.asarray(rows, np.float64)) * self._factor
        now, first = monotonic(), self._next
        self._next += samples.shape[1]
        self.meter.add(self._next, now)
        return Block(samples.astype(np.float32), first, now)

    def facts(self) -> dict[str, Any]:
        """Return what is known. The driver loses nothing: it stops instead."""
        estimate = self.meter.estimate()
        return {
            "samples": self._next,
            "lost": 0,
            "rejected": {},
            "rate": None if estimate is None else estimate.facts(),
            "simulated": False,
        }

    def _configure(self, task: Any, constants: Any) -> None:
        form = self.form
        terminals = getattr(constants.TerminalConfiguration, _TERMINALS[form.terminals])
        add = task.ai_channels
        if form.kind == "acceleration":
            add.add_ai_accel_chan(
                self._channels,
                min_val=-form.range,
                max_val=form.range,
                sensitivity=form.sensitivity,
                current_excit_val=form.current_ma / 1000,
                terminal_config=terminals,
            )
        else:
            add.add_ai_voltage_chan(
                self._channels, min_val=-form.range, max_val=form.range, terminal_config=terminals
            )
        names = [str(channel).rpartition("/")[2] for channel in task.channel_names]
        count = len(names)
        default = ("x", "y", "z") if count == 3 else ("z",) if count == 1 else tuple(names)
        self.axes = tuple(a.strip() for a in form.axes.split(",")) if form.axes else default
        if len(self.axes) != count:
            raise ParameterError(f"{self.name}: axes must be {count} names, got {form.axes!r}")
        task.timing.cfg_samp_clk_timing(
            form.rate,
            sample_mode=constants.AcquisitionType.CONTINUOUS,
            samps_per_chan=int(max(1000, WAITING_S * form.rate)),
        )
        # The device rounds to what its clock divides into.
        self.rate = float(task.timing.samp_clk_rate)


_TIMED_OUT = -200284
_TERMINALS = {"default": "DEFAULT", "rse": "RSE", "nrse": "NRSE", "diff": "DIFF", "pseudodiff": "PSEUDO_DIFF"}


def ni_devices() -> list[str]:
    """Return the names of the National Instruments devices with analogue inputs.

    Raises
    ------
    MissingExtraError, DeviceError
        If nidaqmx or its driver is not installed.
    """
    system = imported("nidaqmx.system", extra="daq", what="National Instruments devices")
    with device_errors("ni", library="nidaqmx"):
        return [d.name for d in system.System.local().devices if len(d.ai_physical_chans)]

"""Audio inputs: PortAudio by sounddevice, and where that is missing miniaudio, which needs no system library."""

from __future__ import annotations

from collections.abc import Generator
from types import TracebackType
from typing import Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from tactogram.capture.source import Block
from tactogram.capture.stream.rate_estimate import RateMeter
from tactogram.capture.stream.sample_queue import BlockQueue
from tactogram.errors import DeviceError, MissingExtraError, ParameterError
from tactogram.extras import device_errors, imported, one_line, silenced
from tactogram.signal.units import parse_unit

WAITING_S = 10.0
"""How much may wait for whoever reads before samples are lost."""


class AudioFormat(BaseModel):
    """Format in which an audio input is opened."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    rate: int = Field(default=48000, ge=1000, le=768000)
    channels: int = Field(default=1, ge=1, le=64)
    axes: str | None = None
    """Names of the channels, separated by commas."""
    unit: str = "1"
    """Unit of the samples; 1 is full scale in -1 to 1."""
    full_scale: float = Field(default=1.0, gt=0, allow_inf_nan=False)
    """What full scale is in ``unit``: 50 where an accelerometer of 50 m/s^2 fills the input."""
    library: Literal["auto", "sounddevice", "miniaudio", "null"] = "auto"
    """``null`` is miniaudio's input without a device, which delivers silence in real time: to try things with."""


class AudioSource:
    """An audio input; see `tactogram.capture.source.Source`.

    Parameters
    ----------
    device : str
        Part of its name; empty for the default one.
    form : AudioFormat
    name : str
        The address.
    """

    def __init__(self, device: str, form: AudioFormat, *, name: str) -> None:
        self.name, self.form = name, form
        self.rate: float | None = float(form.rate)
        self.unit, factor = parse_unit(form.unit)
        self._factor = np.float32(form.full_scale * factor)
        self.full_scale = float(self._factor)
        self.axes = _names(form)
        self.library = ""
        self.overflows = 0
        self.meter = RateMeter()
        self._device = device
        self._queue = BlockQueue(form.channels, int(WAITING_S * form.rate))
        self._open: Any = None
        self._simulated = form.library == "null"

    def __enter__(self) -> Self:
        """Open it.

        Raises
        ------
        MissingExtraError, DeviceError
            If no library is installed, or the device does not open.
        """
        if self.form.library in ("auto", "sounddevice"):
            try:
                self._open_sounddevice()
            except (DeviceError, MissingExtraError):
                # A device that PortAudio knows and cannot open is an error; a missing library has an alternative.
                if self.library or self.form.library == "sounddevice":
                    raise
            else:
                return self
        self._open_miniaudio()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        device, self._open = self._open, None
        if device is not None:
            device.close()

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return what has come; None if nothing did within ``timeout_s``.

        Raises
        ------
        SourceLost
            If the device stopped.
        """
        block = self._queue.get(timeout_s)
        if block is not None:
            self.meter.add(block.first_index + len(block), block.arrival_s)
        return block

    def facts(self) -> dict[str, Any]:
        """Return what is known. An overflow stands for one lost sample: how many it was, the driver does not say."""
        estimate = self.meter.estimate()
        return {
            "samples": self._queue.received,
            "lost": self._queue.lost,
            "rejected": {},
            "overflows": self.overflows,
            "library": self.library,
            "rate": None if estimate is None else estimate.facts(),
            "simulated": self._simulated,
        }

    def _open_sounddevice(self) -> None:
        sounddevice = imported("sounddevice", extra="devices", what="audio inputs")
        self.library = "sounddevice"

        def take(data: Any, frames: int, time: Any, status: Any) -> None:
            overflow = bool(getattr(status, "input_overflow", False))
            self.overflows += overflow
            self._queue.put(np.asarray(data, np.float32).T * self._factor, lost_before=int(overflow))

        def stopped() -> None:
            self._queue.close(f"{self.name}: the audio input stopped")

        with device_errors(self.name, library="sounddevice"), silenced():
            stream = sounddevice.InputStream(
                samplerate=self.form.rate,
                channels=self.form.channels,
                device=self._device or None,
                dtype="float32",
                latency="low",
                callback=take,
                finished_callback=stopped,
            )
            stream.start()
        self._open = stream

    def _open_miniaudio(self) -> None:
        miniaudio = imported("miniaudio", extra="devices", what="audio inputs")
        self.library = "miniaudio"
        with device_errors(self.name, library="miniaudio"), silenced():
            backends = [miniaudio.Backend.NULL] if self.form.library == "null" else []
            found = miniaudio.Devices(backends).get_captures()
            there = found if backends else _real(found)
            wanted = [d for d in there if self._device.lower() in d["name"].lower()]
            if not wanted:
                known = ", ".join(d["name"] for d in there) or "none"
                named = f" called {self._device!r}" if self._device else ""
                raise DeviceError(f"{self.name.rstrip(':')}: no audio input{named}; there are: {known}")
            device = miniaudio.CaptureDevice(
                input_format=miniaudio.SampleFormat.FLOAT32,
                nchannels=self.form.channels,
                sample_rate=self.form.rate,
                buffersize_msec=10,
                device_id=wanted[0]["id"] if self._device else None,
                backends=backends,
            )
            taking = self._taking()
            next(taking)
            device.start(taking)
        self._open = device

    def _taking(self) -> Generator[None, bytes, None]:
        while True:
            data = yield
            samples = np.frombuffer(bytes(data), np.float32).reshape(-1, self.form.channels).T
            self._queue.put(samples * self._factor)


def audio_inputs() -> list[str]:
    """Return the names of the audio inputs, without the one that only plays at being one.

    Raises
    ------
    MissingExtraError, DeviceError
        If no library is installed, or none finds an audio system.
    """
    try:
        sounddevice = imported("sounddevice", extra="devices", what="audio inputs")
        with silenced():
            devices = sounddevice.query_devices()
        return [d["name"] for d in devices if d["max_input_channels"] > 0]
    except (DeviceError, MissingExtraError):
        miniaudio = imported("miniaudio", extra="devices", what="audio inputs")
    try:
        with silenced():
            found = miniaudio.Devices().get_captures()
    except miniaudio.MiniaudioError as error:
        raise DeviceError(f"audio: no audio system was found ({one_line(error)})") from error
    return [d["name"] for d in _real(found)]


def _real(devices: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Leave out devices that only play at being one: miniaudio's own and ALSA's."""
    return [d for d in devices if "null" not in d["name"].lower() and "Discard all samples" not in d["name"]]


def _names(form: AudioFormat) -> tuple[str, ...]:
    default = {1: ("z",), 3: ("x", "y", "z")}.get(
        form.channels, tuple(f"c{i + 1}" for i in range(form.channels))
    )
    names = tuple(a.strip() for a in form.axes.split(",")) if form.axes else default
    if len(names) != form.channels or len(set(names)) != len(names):
        raise ParameterError(f"axes must be {form.channels} different names, got {form.axes!r}")
    return names

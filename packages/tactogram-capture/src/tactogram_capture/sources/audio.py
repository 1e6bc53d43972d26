"""Audio inputs, by sounddevice and its PortAudio."""

from __future__ import annotations

from collections import deque
from threading import Condition
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tactogram.extras import device_errors, imported, silenced
from tactogram.signal import parse_unit
from tactogram.validation import FrozenModel
from tactogram_capture.source import Block, SourceKind, SourceLost
from tactogram_capture.stream.channels import DeviceSource, axis_names, source_facts


class BlockQueue:
    """Blocks from a driver's thread to the reader's.

    At most ``most`` samples wait; samples that do not fit are lost, marked and counted.
    """

    def __init__(self, axes: int, most: int) -> None:
        self.received = self.lost = 0
        self._axes, self._most = axes, most
        self._waiting: deque[tuple[NDArray[np.float32], float]] = deque()
        self._waiting_samples = self._next = self._gap = 0
        self._end: str | None = None
        self._changed = Condition()

    def put(self, samples: NDArray[np.float32], *, lost_before: int = 0) -> None:
        """Append a copy of samples, float32, shape (axis, n), after ``lost_before`` that the driver lost."""
        with self._changed:
            self._gap += lost_before
            if self._waiting_samples + samples.shape[1] > self._most:
                self._gap += samples.shape[1]
                return
            if self._gap:
                gap = np.full((self._axes, self._gap), np.nan, np.float32)
                self._waiting.append((gap, monotonic()))
                self.lost += self._gap
                self._gap = 0
            if samples.shape[1]:
                self._waiting.append((np.array(samples, np.float32), monotonic()))
                self._waiting_samples += samples.shape[1]
                self.received += samples.shape[1]
            self._changed.notify()

    def close(self, reason: str) -> None:
        """End the queue after the waiting samples."""
        with self._changed:
            self._end = reason
            self._changed.notify()

    def get(self, timeout_s: float) -> Block | None:
        """Return all waiting samples as one block; None if none arrived in time.

        Raises `SourceLost` if the queue is empty and closed.
        """
        with self._changed:
            if not self._waiting and self._end is None:
                self._changed.wait(timeout_s)
            if not self._waiting:
                if self._end is not None:
                    raise SourceLost(self._end)
                return None
            pieces = list(self._waiting)
            self._waiting.clear()
            self._waiting_samples = 0
        samples = np.concatenate([piece for piece, _ in pieces], axis=1)
        first, self._next = self._next, self._next + samples.shape[1]
        return Block(samples, first, pieces[-1][1])


WAITING_S = 10.0
"""Samples buffered for the reader, s; later ones are lost."""


class AudioFormat(FrozenModel):
    """Options of ``audio:NAME``: the format in which an input is opened."""

    rate: int = Field(default=48000, ge=1000, le=768000)
    channels: int = Field(default=1, ge=1, le=64)
    axes: str | None = None
    """Names of the channels, separated by commas."""
    unit: str = "1"
    """Unit of the samples; 1 is full scale in -1 to 1."""
    full_scale: float = Field(default=1.0, gt=0, allow_inf_nan=False)
    """Full scale in ``unit``: 50 if an accelerometer of 50 m/s^2 fills the input."""


class AudioSource(DeviceSource):
    """An audio input; ``device`` is part of its name, empty for the default input."""

    def __init__(self, device: str, form: AudioFormat, *, name: str) -> None:
        super().__init__(name)
        self.form = form
        self.rate = float(form.rate)
        self.unit, factor = parse_unit(form.unit)
        self._factor = np.float32(form.full_scale * factor)
        self.full_scale = float(self._factor)
        self.axes = axis_names(form.channels, form.axes, where=name)
        self.overflows = 0
        self._input = device
        self._queue = BlockQueue(form.channels, int(WAITING_S * form.rate))

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return new samples, None if none arrived within ``timeout_s``; `SourceLost` if the device stopped."""
        return self._read(None, timeout_s)

    def facts(self) -> dict[str, Any]:
        """Return the facts so far. An overflow counts as one lost sample: the driver does not report how many."""
        return source_facts(
            self.meter,
            samples=self._queue.received,
            lost=self._queue.lost,
            overflows=self.overflows,
        )

    def _open(self) -> Any:
        sounddevice = imported("sounddevice", extra="devices", what="audio inputs")

        def receive(data: Any, frames: int, time: Any, status: Any) -> None:
            overflow = bool(getattr(status, "input_overflow", False))
            self.overflows += overflow
            self._queue.put(np.asarray(data, np.float32).T * self._factor, lost_before=int(overflow))

        def stop() -> None:
            self._queue.close(f"{self.name}: the audio input stopped")

        with device_errors(self.name, library="sounddevice"), silenced():
            stream = sounddevice.InputStream(
                samplerate=self.form.rate,
                channels=self.form.channels,
                device=self._input or None,
                dtype="float32",
                latency="low",
                callback=receive,
                finished_callback=stop,
            )
            stream.start()
        return stream

    def _read(self, device: Any, timeout_s: float) -> Block | None:
        block = self._queue.get(timeout_s)
        if block is not None:
            self.meter.add(block.first_index + len(block), block.arrival_s)
        return block


def _find(find_s: float) -> dict[str, str]:
    sounddevice = imported("sounddevice", extra="devices", what="audio inputs")
    with device_errors("audio", library="sounddevice"), silenced():
        devices = sounddevice.query_devices()
    return {f"audio:{d['name']}": "audio input" for d in devices if d["max_input_channels"] > 0}


SOURCE = SourceKind("audio", "audio input", "audio:NAME?rate=48000", AudioFormat, AudioSource, find=_find)

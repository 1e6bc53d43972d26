"""Stream backends, which request blocks and pace them: a file, this computer's clock, or a sound card.

`run_unpaced` renders as fast as it can, on a clock of samples: the same motion gives the same samples. `run_clocked`
sleeps from block to block. `run_miniaudio` plays on miniaudio's null device, which has a sound card's pace without a
card, or on a real one. `run_audio` plays on a sound card through PortAudio (sounddevice) if available, else through
miniaudio.
"""

from __future__ import annotations

import gc
import math
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DeviceError, MissingExtraError, ParameterError
from tactogram.extras import device_errors, imported
from tactogram_playback.sound_card import opened_card
from tactogram_playback.streaming.output import Stream

Block = NDArray[np.float32]
Sink = Callable[[Block, float], None]
StatusCallback = Callable[[float], None]

STATUS_S = 0.25
"""Interval of the status, s."""
STALLED_S = 2.0
"""A device without requests for this long is gone, s."""
SETTLING_S = 0.05
"""Time for an ended stream to fade out, s."""


@dataclass
class Clock:
    """Seconds since `start`."""

    began: float = field(default_factory=time.perf_counter)

    def start(self) -> None:
        """Restart at 0."""
        self.began = time.perf_counter()

    def now(self) -> float:
        """Return seconds since the start."""
        return time.perf_counter() - self.began


def run_unpaced(
    stream: Stream, *, seconds: float, sink: Sink | None = None, status: StatusCallback | None = None
) -> None:
    """Render ``seconds`` as fast as possible, on a clock of samples."""
    engine = stream.engine
    total, done, status_s = round(seconds * engine.rate), 0, 0.0
    stream.ends_s = seconds
    with uninterrupted():
        while done < total and not stream.is_over:
            now = done / engine.rate
            block = stream.next(now, min(engine.most, total - done))
            done += block.shape[1]
            if sink is not None:
                sink(block, now)
            if status is not None and now >= status_s:
                status(now)
                status_s = now + 1.0


def run_clocked(
    stream: Stream,
    *,
    seconds: float,
    clock: Clock,
    sink: Sink | None = None,
    status: StatusCallback | None = None,
    realtime: bool = False,
) -> bool:
    """Render each block when it is due; return whether real-time priority was granted.

    A keyboard interrupt ends the stream after a fade, as an error does.
    """
    with priority(realtime=realtime) as granted:
        for block, now in clocked_blocks(stream, seconds=seconds, clock=clock, status=status):
            try:
                if sink is not None:
                    sink(block, now)
            except KeyboardInterrupt:
                stream.stop()
    return granted


def clocked_blocks(
    stream: Stream, *, seconds: float, clock: Clock, status: StatusCallback | None = None
) -> Iterator[tuple[Block, float]]:
    """Yield each block when it is due, and that time.

    A block that is finished after the previous one has ended is an underrun; the missed time is skipped, without a
    burst. The blocks in which the stream fades to rest are never skipped.
    """
    engine = stream.engine
    step, settling_s = engine.most / engine.rate, max(SETTLING_S, stream.ending_s)
    fading = math.ceil(stream.ending_s / step)
    stream.ends_s = seconds
    with uninterrupted():
        clock.start()
        due, status_s = 0.0, 0.0
        while due < seconds or fading > 0:
            try:
                early = due - clock.now()
                if early > 0:
                    time.sleep(early)
                now = clock.now()
                block = stream.next(now)
            except KeyboardInterrupt:
                stream.stop()
                continue
            fading -= stream.is_over or now >= stream.ends_s - stream.ending_s
            yield block, now
            end = clock.now()
            due += step
            if end > due:
                engine.latency.underruns += 1
                due += step * int((end - due) / step)
            if status is not None and now >= status_s:
                status(now)
                status_s = now + STATUS_S
            if stream.is_over and seconds > due + settling_s:
                seconds = due + settling_s


class FrameReader:
    """Reader of any number of frames from a stream's blocks, for a device whose 1.0 is a drive of ``full_scale``.

    ``realtime`` requests real-time priority for the thread that reads.
    """

    def __init__(
        self, stream: Stream, clock: Clock, *, full_scale: float = 1.0, realtime: bool = False
    ) -> None:
        self._stream, self._clock, self._full_scale = stream, clock, full_scale
        self._display = None if stream.output is None else stream.output.display
        self.channels = len(stream.channels) if self._display is None else self._display.card_width
        """Number of channels of the device."""
        self._rest = np.empty((len(stream.channels), 0), np.float32)
        self._realtime, self.granted = realtime, False
        self.frames = 0
        self.calls = 0

    def read(self, frames: int) -> Block:
        """Return the next frames, float32, shape (frames, channel of the device), C order."""
        if not self.calls:
            self.granted = self._realtime and _raise_priority()
        engine = self._stream.engine
        start = self._clock.now()
        out = np.empty((frames, len(self._stream.channels)), np.float32)
        done = min(frames, self._rest.shape[1])
        out[:done] = self._rest[:, :done].T
        self._rest = self._rest[:, done:]
        while done < frames:
            block = self._stream.next(self._clock.now(), ahead_s=done / engine.rate)
            count = min(frames - done, block.shape[1])
            out[done : done + count] = block[:, :count].T
            done += count
            self._rest = block[:, count:].copy()
        out /= np.float32(self._full_scale)
        if self._display is not None:
            out = self._display.on_card(out)
        self.frames += frames
        self.calls += 1
        if self._clock.now() - start > frames / engine.rate:
            engine.latency.underruns += 1
        return out


def run_miniaudio(
    stream: Stream,
    *,
    seconds: float,
    clock: Clock,
    null: bool,
    full_scale: float = 1.0,
    status: StatusCallback | None = None,
    realtime: bool = False,
) -> dict[str, Any]:
    """Play on miniaudio's null device or on the default sound card; return facts on the device.

    ``full_scale`` is the drive at the device's 1.0.

    Raises `MissingExtraError` or `DeviceError` if the library or a sound card is missing.
    """
    engine = stream.engine
    if engine.rate != int(engine.rate):
        raise ParameterError(f"an audio device needs an integral rate in Hz, got {engine.rate:g}")
    reader = FrameReader(stream, clock, full_scale=full_scale, realtime=realtime)
    block_ms = 1e3 * engine.most / engine.rate
    with (
        opened_card(
            reader.read, rate=engine.rate, channels=reader.channels, buffer_ms=block_ms, null=null
        ) as card,
        uninterrupted(),
    ):
        clock.start()
        card.start()
        _wait(stream, seconds, clock, status, reader)
        card.stop()
    return {
        "library": "miniaudio",
        "device": "null" if null else card.backend,
        "frames_per_call": reader.frames / reader.calls if reader.calls else 0.0,
        "realtime_priority": reader.granted,
    }


def run_audio(
    stream: Stream,
    *,
    seconds: float,
    clock: Clock,
    device: str | int | None = None,
    full_scale: float = 1.0,
    status: StatusCallback | None = None,
    realtime: bool = False,
) -> dict[str, Any]:
    """Play on a sound card through PortAudio, or without it through miniaudio; return facts on the device.

    ``full_scale`` is the drive at the card's 1.0.

    Raises `MissingExtraError` or `DeviceError` if the libraries or a device are missing.
    """
    try:
        sounddevice = imported("sounddevice", extra="devices", what="the audio backend")
    except (DeviceError, MissingExtraError) as missing:
        if device is not None:
            raise
        try:
            return run_miniaudio(
                stream,
                seconds=seconds,
                clock=clock,
                null=False,
                full_scale=full_scale,
                status=status,
                realtime=realtime,
            )
        except DeviceError as error:
            raise DeviceError(f"audio: miniaudio found no output, and {missing}") from error
    engine = stream.engine
    reader = FrameReader(stream, clock, full_scale=full_scale, realtime=realtime)
    underflows = 0

    def callback(out: NDArray[np.float32], frames: int, _time: Any, flags: Any) -> None:
        nonlocal underflows
        underflows += bool(flags.output_underflow)
        out[:] = reader.read(frames)

    with (
        device_errors(f"audio:{device if device is not None else 'default'}"),
        sounddevice.OutputStream(
            samplerate=engine.rate,
            blocksize=engine.most,
            channels=reader.channels,
            dtype="float32",
            latency="low",
            device=device,
            callback=callback,
        ) as playing,
    ):
        engine.latency.queued_s = float(playing.latency)
        with uninterrupted():
            clock.start()
            _wait(stream, seconds, clock, status, reader)
        name = str(sounddevice.query_devices(playing.device)["name"])
    engine.latency.underruns = max(engine.latency.underruns, underflows)
    return {
        "library": "sounddevice",
        "device": name,
        "latency_ms": 1e3 * engine.latency.queued_s,
        "realtime_priority": reader.granted,
    }


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Suspend garbage collection, and switch between threads quickly, so that neither delays a block."""
    collecting, interval = gc.isenabled(), sys.getswitchinterval()
    gc.disable()
    sys.setswitchinterval(5e-4)
    try:
        yield
    finally:
        sys.setswitchinterval(interval)
        if collecting:
            gc.enable()


@contextmanager
def priority(*, realtime: bool) -> Iterator[bool]:
    """Give this thread real-time priority, if requested and the system grants it; yields whether it has it."""
    granted = realtime and _raise_priority()
    try:
        yield granted
    finally:
        if granted:
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def _raise_priority() -> bool:
    if not hasattr(os, "sched_setscheduler"):
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except OSError:
        return False
    return True


def _wait(
    stream: Stream, seconds: float, clock: Clock, status: StatusCallback | None, reader: FrameReader
) -> None:
    """Wait until a device has played and faded out, or the stream is stopped, interrupted or has an error.

    Raises `DeviceError` if the device requested nothing for `STALLED_S`: the only sign of an unplugged sound card.
    """
    asleep = threading.Event()
    stream.ends_s = seconds
    frames, since = -1, clock.now()
    try:
        while (left := seconds - clock.now()) > 0 and not stream.is_over:
            asleep.wait(min(STATUS_S, left))
            if reader.frames != frames:
                frames, since = reader.frames, clock.now()
            elif clock.now() - since > STALLED_S:
                raise DeviceError(
                    f"the device has requested no samples for {STALLED_S:g} s; check that it is plugged in"
                )
            if status is not None:
                status(clock.now())
    except KeyboardInterrupt:
        stream.stop()
    if stream.is_over:
        asleep.wait(max(SETTLING_S, stream.ending_s))

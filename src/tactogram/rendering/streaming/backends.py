"""Stream backends, which take blocks and keep the time: a file, our own clock, or a sound card.

``file`` renders as fast as it can, on a clock of samples: the same motion gives the same samples. ``clock`` sleeps
from block to block. ``null`` is a device of the miniaudio library that plays to nobody at the right pace: what a sound
card asks of a program, without a card. ``audio`` is a real one, through PortAudio (sounddevice) where that is there,
else through miniaudio.
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
from tactogram.extras import device_errors, imported, silenced
from tactogram.rendering.streaming.stream import Stream

Block = NDArray[np.float32]
Sink = Callable[[Block, float], None]
StatusCallback = Callable[[float], None]

STATUS_S = 0.25
"""How often the status is told, s."""
STALLED_S = 2.0
"""A device that asks for nothing for so long is gone, s."""
SETTLING_S = 0.05
"""How much of an ended stream is still sent, so that it fades out, s."""


@dataclass
class Clock:
    """Seconds since `start`."""

    began: float = field(default_factory=time.perf_counter)

    def start(self) -> None:
        """Begin at 0 now."""
        self.began = time.perf_counter()

    def now(self) -> float:
        """Return seconds since the start."""
        return time.perf_counter() - self.began


def run_unpaced(
    stream: Stream, *, seconds: float, sink: Sink | None = None, status: StatusCallback | None = None
) -> None:
    """Render ``seconds`` as fast as possible, on a clock of samples."""
    engine = stream.engine
    total, done, told = round(seconds * engine.rate), 0, 0.0
    stream.ends_s = seconds
    with quiet():
        while done < total and stream.error is None:
            now = done / engine.rate
            block = stream.next(now, min(engine.most, total - done))
            done += block.shape[1]
            if sink is not None:
                sink(block, now)
            if status is not None and now >= told:
                status(now)
                told = now + 1.0


def run_clocked(
    stream: Stream,
    *,
    seconds: float,
    clock: Clock,
    sink: Sink | None = None,
    status: StatusCallback | None = None,
    realtime: bool = False,
) -> bool:
    """Render a block each time that one is due; return whether real-time priority was granted.

    An interrupt from the keyboard, like an error, ends it after a fade.

    A block that is ready later than when the one before it has ended is an underrun; the time missed is left out, not
    made up for by a burst.
    """
    engine = stream.engine
    step = engine.most / engine.rate
    stream.ends_s = seconds
    with quiet(), priority(asked=realtime) as granted:
        clock.start()
        due, told = 0.0, 0.0
        while due < seconds:
            try:
                early = due - clock.now()
                if early > 0:
                    time.sleep(early)
                now = clock.now()
                block = stream.next(now)
                if sink is not None:
                    sink(block, now)
                end = clock.now()
                due += step
                if end > due:
                    engine.latency.underruns += 1
                    due += step * int((end - due) / step)
                if status is not None and now >= told:
                    status(now)
                    told = now + STATUS_S
            except KeyboardInterrupt:
                stream.ends_s = -math.inf
            if (stream.error is not None or stream.ends_s < 0) and seconds > due + SETTLING_S:
                seconds = due + SETTLING_S
    return granted


class FrameReader:
    """Gives a device as many frames as it asks for, out of blocks.

    Parameters
    ----------
    stream : Stream
    clock : Clock
    realtime : bool
        Ask for real-time priority for the thread that pulls.
    """

    def __init__(self, stream: Stream, clock: Clock, *, realtime: bool = False) -> None:
        self._stream, self._clock = stream, clock
        self._left = np.empty((len(stream.channels), 0), np.float32)
        self._realtime, self.granted = realtime, False
        self._begun = False
        self.frames = 0
        self.calls = 0

    def pull(self, frames: int) -> Block:
        """Return the next frames, float32, shape (frames, channel), C order."""
        if not self._begun:
            self._begun = True
            self.granted = self._realtime and _take_priority()
        engine = self._stream.engine
        begun = self._clock.now()
        out = np.empty((frames, len(self._stream.channels)), np.float32)
        done = min(frames, self._left.shape[1])
        out[:done] = self._left[:, :done].T
        self._left = self._left[:, done:]
        while done < frames:
            block = self._stream.next(self._clock.now(), ahead_s=done / engine.rate)
            take = min(frames - done, block.shape[1])
            out[done : done + take] = block[:, :take].T
            done += take
            self._left = block[:, take:].copy()
        self.frames += frames
        self.calls += 1
        if self._clock.now() - begun > frames / engine.rate:
            engine.latency.underruns += 1
        return out


def run_miniaudio(
    stream: Stream,
    *,
    seconds: float,
    clock: Clock,
    null: bool,
    status: StatusCallback | None = None,
    realtime: bool = False,
) -> dict[str, Any]:
    """Play on miniaudio's null device or on the default sound card; return what is known of the device.

    Raises
    ------
    MissingExtraError, DeviceError
        If the library is missing, or there is no sound card.
    """
    miniaudio = imported("miniaudio", extra="devices", what="the null and audio backends")
    engine = stream.engine
    if engine.rate != int(engine.rate):
        raise ParameterError(f"an audio device needs a whole rate in Hz, got {engine.rate:g}")
    puller = FrameReader(stream, clock, realtime=realtime)

    def frames() -> Iterator[bytes]:
        asked = yield b""
        while True:
            asked = yield puller.pull(asked).tobytes()  # type: ignore[arg-type]

    with device_errors("null" if null else "audio"):
        with silenced():
            device = miniaudio.PlaybackDevice(
                output_format=miniaudio.SampleFormat.FLOAT32,
                nchannels=len(stream.channels),
                sample_rate=int(engine.rate),
                buffersize_msec=max(1, round(1e3 * engine.most / engine.rate)),
                backends=[miniaudio.Backend.NULL] if null else None,
            )
        try:
            source = frames()
            next(source)
            with quiet():
                clock.start()
                device.start(source)
                _wait(stream, seconds, clock, status, puller)
                device.stop()
        finally:
            device.close()
    asked = puller.frames / puller.calls if puller.calls else 0.0
    return {
        "library": "miniaudio",
        "device": "null" if null else str(device.backend),
        "frames_per_call": asked,
        "realtime_priority": puller.granted,
    }


def run_sounddevice(
    stream: Stream,
    *,
    seconds: float,
    clock: Clock,
    device: str | int | None = None,
    status: StatusCallback | None = None,
    realtime: bool = False,
) -> dict[str, Any]:
    """Play on a sound card through PortAudio; return what is known of the device.

    Raises
    ------
    MissingExtraError, DeviceError
        If the library, PortAudio or a device is missing.
    """
    sounddevice = imported("sounddevice", extra="devices", what="the audio backend")
    engine = stream.engine
    puller = FrameReader(stream, clock, realtime=realtime)
    flagged = 0

    def callback(out: NDArray[np.float32], frames: int, _time: Any, flags: Any) -> None:
        nonlocal flagged
        flagged += bool(flags.output_underflow)
        out[:] = puller.pull(frames)

    with (
        device_errors(f"audio:{device if device is not None else 'default'}"),
        sounddevice.OutputStream(
            samplerate=engine.rate,
            blocksize=engine.most,
            channels=len(stream.channels),
            dtype="float32",
            latency="low",
            device=device,
            callback=callback,
        ) as playing,
    ):
        engine.latency.queued_s = float(playing.latency)
        with quiet():
            clock.start()
            _wait(stream, seconds, clock, status, puller)
        name = str(sounddevice.query_devices(playing.device)["name"])
    engine.latency.underruns = max(engine.latency.underruns, flagged)
    return {
        "library": "sounddevice",
        "device": name,
        "latency_ms": 1e3 * engine.latency.queued_s,
        "realtime_priority": puller.granted,
    }


def run_audio(
    stream: Stream,
    *,
    seconds: float,
    clock: Clock,
    device: str | int | None = None,
    status: StatusCallback | None = None,
    realtime: bool = False,
) -> dict[str, Any]:
    """Play on a sound card, through PortAudio or, without that, through miniaudio.

    Raises
    ------
    DeviceError
        If neither finds a device.
    """
    try:
        imported("sounddevice", extra="devices", what="the audio backend")
    except (DeviceError, MissingExtraError) as missing:
        if device is not None:
            raise
        try:
            return run_miniaudio(
                stream, seconds=seconds, clock=clock, null=False, status=status, realtime=realtime
            )
        except DeviceError as error:
            raise DeviceError(f"audio: no output was found by miniaudio, and {missing}") from error
    return run_sounddevice(
        stream, seconds=seconds, clock=clock, device=device, status=status, realtime=realtime
    )


@contextmanager
def quiet() -> Iterator[None]:
    """Keep the collector of garbage, and switching between threads, out of the way of blocks."""
    collecting, interval = gc.isenabled(), sys.getswitchinterval()
    gc.collect()
    gc.freeze()
    gc.disable()
    sys.setswitchinterval(5e-4)
    try:
        yield
    finally:
        sys.setswitchinterval(interval)
        gc.unfreeze()
        if collecting:
            gc.enable()


@contextmanager
def priority(*, asked: bool) -> Iterator[bool]:
    """Give this thread real-time priority where the system grants it, for a while; yields whether it did."""
    granted = asked and _take_priority()
    try:
        yield granted
    finally:
        if granted:
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def _take_priority() -> bool:
    if not hasattr(os, "sched_setscheduler"):
        return False
    try:
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))
    except OSError:
        return False
    return True


def _wait(
    stream: Stream, seconds: float, clock: Clock, status: StatusCallback | None, puller: FrameReader
) -> None:
    """Wait until a device has played for so long and faded out, or the stream has an error or is interrupted.

    Raises
    ------
    DeviceError
        If the device asked for nothing for `STALLED_S`: a sound card whose plug was pulled says nothing else.
    """
    asleep = threading.Event()
    stream.ends_s = seconds
    frames, since = -1, clock.now()
    try:
        while (left := seconds - clock.now()) > 0 and stream.error is None:
            asleep.wait(min(STATUS_S, left))
            if puller.frames != frames:
                frames, since = puller.frames, clock.now()
            elif clock.now() - since > STALLED_S:
                raise DeviceError(
                    f"the device has asked for no samples for {STALLED_S:g} s; is it still plugged in?"
                )
            if status is not None:
                status(clock.now())
    except KeyboardInterrupt:
        stream.ends_s = -math.inf
    if stream.error is not None or stream.ends_s < 0:
        asleep.wait(SETTLING_S)

"""Stream: an engine and a display's output as a backend sees them, measured, and at rest after any error.

`tactogram.rendering.drive.fit` sees a whole signal; a stream sees only the past. So a *rehearsal* (seconds of the same
textures under a simulated hand) is fitted first, with its level and its report, and its factor is applied to the
stream. A family that streams a whole surface needs no rehearsal.
"""

from __future__ import annotations

import math
import time
from array import array
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering import Display, Level, MotionBlock, StreamDrive, display_family, fit
from tactogram.signal import Signal
from tactogram_playback.drive_guard import DriveGuard
from tactogram_playback.streaming.engine import LEAST_RATE, Engine
from tactogram_playback.streaming.textures import SurfaceTexture

Block = NDArray[np.float32]


def check_streams(display: Display) -> None:
    """Raise `ParameterError` if a display cannot be streamed to."""
    family = display_family(display.family)
    if family.stream_surface is None and family.stream_signal is None:
        raise ParameterError(
            display.name,
            f"displays of the family {display.family} cannot be streamed to",
            remedy="render a file instead",
        )
    if display.rate < LEAST_RATE:
        raise ParameterError(
            display.name,
            f"streaming needs a drive of at least {LEAST_RATE:g} Hz, this display takes {display.rate:g}",
            remedy="render a file instead",
        )


class DisplayOutput:
    """Drive of a display, block by block; never NaN, never over a limit, at rest after an error.

    ``rehearsed`` is some seconds of the stream at the display's rate, whose level determines the factor, or the
    surface itself for a family that streams surfaces. ``clipped`` counts the samples beyond the display's limits in
    all channels. Raises `ParameterError` or `UnitError` if the display's family cannot be streamed to, or the level
    does not apply to it.
    """

    def __init__(self, display: Display, rehearsed: Signal | SurfaceTexture, *, level: Level) -> None:
        check_streams(display)
        self.display, self.family = display, display_family(display.family)
        self.drive: StreamDrive
        self.rehearsal: dict[str, Any] | None = None
        if self.family.stream_surface is not None:
            if not isinstance(rehearsed, SurfaceTexture):
                raise ParameterError(
                    f"{display.name}: a stream needs one surface, a friction coefficient over displacement; got "
                    "a signal over time"
                )
            self.drive = self.family.stream_surface(display, rehearsed.signal, rehearsed.along, level)
        elif self.family.stream_signal is not None:
            if not isinstance(rehearsed, Signal):
                raise ParameterError(f"{display.name}: the level needs a rehearsed signal, got a surface")
            report = fit(rehearsed, display, level=level).report
            self.drive = self.family.stream_signal(display, rehearsed.unit, report.facts)
            self.rehearsal = report.as_json()
        self.guard = DriveGuard(display)
        self.clipped = 0
        self._sent, self._square, self._peak = 0, 0.0, 0.0

    def process(self, block: Block, motion: MotionBlock | None = None) -> Block:
        """Return the drive to send, float32, shape (channel, time)."""
        drive = self.drive.process(block, motion)
        # A float's rounding at the limit does not count as clipped.
        over = (drive > self.display.limit * (1 + 1e-6)) | (
            drive < self.display.floor - 1e-6 * self.display.limit
        )
        self.clipped += int(np.count_nonzero(over))
        sent = self.guard.process(drive)
        away = sent.astype(np.float64) - self.display.rest
        self._sent += away.size
        self._square += float(np.square(away).sum())
        self._peak = max(self._peak, float(np.abs(away).max()))
        return sent

    def missing(self, count: int) -> Block:
        """Return a fade to rest, then rest, for the time without motion."""
        if self.drive.runs_on:
            with suppress(Exception):
                return self.guard.leaving(self.drive.process(np.zeros((1, count), np.float32), None))
        return self.guard.missing(count)

    def facts(self) -> dict[str, Any]:
        """Return the display, its rehearsal, and what was clipped and sent (from rest, in its unit), as JSON values."""
        return {
            "display": self.display.name,
            "family": self.display.family,
            "unit": self.display.unit,
            "limit": self.display.limit,
            "rehearsal": self.rehearsal,
            "clipped_samples": self.clipped,
            "drive_rms": math.sqrt(self._square / self._sent) if self._sent else 0.0,
            "drive_peak": self._peak,
            **self.drive.facts(),
        }

    def sentence(self) -> str | None:
        """Return a sentence on the equaliser, its delay and its difference from a file's; None without one."""
        facts = self.drive.facts().get("equaliser")
        if facts is None:
            return None
        delay = f"{facts['delay_samples']:.1f} samples ({facts['delay_ms']:.2f} ms) at {facts['reference_hz']:g} Hz"
        if not facts["on"]:
            known = self.family.response_known(self.display)
            why = "is not equalised" if known else f"is not known: {self.family.measured_by}"
            return f"equaliser: none, the response of {self.display.name} {why}; the band's edges delay by {delay}"
        low, high = facts["checked_hz"]
        return (
            f"equaliser: within {facts['error_most_db']:.2f} dB of a file's from {low:.0f} to {high:.0f} Hz "
            f"({facts['error_rms_db']:.2f} dB rms, largest at {facts['error_most_hz']:.0f} Hz), raises by up to "
            f"{facts['raised_db']:.0f} dB, delays by {delay}"
        )


ENDING_S = 0.02
"""Least length of the fade before a stream's end, s."""
LONGEST_RECORD = 60_000_000
"""Most samples, of all channels, that are recorded: 240 MB."""


class Stream:
    """An engine, the display that it drives (without one: the texture itself, in its unit), and a record of both.

    The record holds the first ``record_s`` seconds of what is sent. ``on_block`` is called with the time before each
    block, to change a mix for instance. Raises `ParameterError` if the engine's rate is not the display's, or the
    record is too long.
    """

    def __init__(
        self,
        engine: Engine,
        output: DisplayOutput | None = None,
        *,
        record_s: float = 0.0,
        on_block: Callable[[float], None] | None = None,
    ) -> None:
        if output is not None and output.display.rate != engine.rate:
            raise ParameterError.must(
                "engine", f"run at the display's {output.display.rate:g} Hz", engine.rate
            )
        self.engine, self.output = engine, output
        self.channels = engine.axes if output is None else output.display.channels
        self.unit = engine.unit if output is None else output.display.unit
        self.error: Exception | None = None
        self.ends_s = float("inf")
        """From ``ending_s`` before this time on, the stream fades to rest."""
        self.ending_s = max(ENDING_S, 0.0 if output is None else 1.5e-3 * output.display.fade_ms)
        """Length of the end, s: longer than the display's fade."""
        self.stopped = False
        self._on_block = on_block
        length = round(record_s * engine.rate)
        if length * len(self.channels) > LONGEST_RECORD:
            raise ParameterError(
                f"{record_s:g} s at {engine.rate:g} Hz are too long; record at most "
                f"{LONGEST_RECORD / engine.rate / len(self.channels):.0f} s"
            )
        self._record: Block = np.empty((len(self.channels), length), np.float32)
        self._record[:] = 0.0  # written now, so that the memory is mapped before the first block
        self._track = array("d")
        self._recorded = self._sent = 0
        self._silence: Block = np.zeros((len(self.channels), engine.most), np.float32)
        self._last = np.zeros((len(self.channels), 1), np.float32)

    @property
    def recorded(self) -> Block:
        """What was sent, float32, shape (channel, time)."""
        return self._record[:, : self._recorded]

    @property
    def track(self) -> NDArray[np.float64]:
        """Time in s, speed in mm/s and force in N at the end of each block, float64, shape (block, 3)."""
        return np.array(self._track).reshape(-1, 3)

    def stop(self) -> None:
        """Fade to rest and end, wherever it is; safe to call from any thread, and before it begins."""
        self.stopped = True

    @property
    def is_over(self) -> bool:
        """Whether it was stopped or has an error."""
        return self.stopped or self.error is not None

    def next(self, now_s: float, count: int | None = None, *, ahead_s: float = 0.0) -> Block:
        """Return the next block, float32, shape (channel, count); the parameters are those of `Engine.render`.

        Never raises: after an error, stored in ``error``, the stream fades to rest, as at its end.
        """
        wall, processor = time.perf_counter(), time.thread_time()
        count = self.engine.most if count is None else count
        ended = self.is_over or now_s + ahead_s >= self.ends_s - self.ending_s
        block = self._fade(count) if ended else self._rendered(now_s, count, ahead_s)
        self._add_to_record(block)
        processor, wall = time.thread_time() - processor, time.perf_counter() - wall
        engine = self.engine
        engine.latency.add(
            wall,
            processor,
            engine.finger.age(now_s) + ahead_s if self._connected else float("inf"),
            block_s=count / engine.rate,
        )
        return block

    def warm_up(self) -> None:
        """Compile, load and allocate everything that a block needs before the first one."""
        self.engine.warm_up()
        if self.output is not None:
            self.output.process(np.zeros((len(self.engine.axes), self.engine.most), np.float32))
            self.output.guard.reset()

    def facts(self) -> dict[str, Any]:
        """Return statistics of the stream, as JSON values."""
        display = {} if self.output is None else {"display": self.output.facts()}
        return self.engine.facts() | {"drive_unit": self.unit, "channels": list(self.channels)} | display

    @property
    def _connected(self) -> bool:
        return self.engine.tracker.state != "lost"

    def _rendered(self, now_s: float, count: int, ahead_s: float) -> Block:
        try:
            if self._on_block is not None:
                self._on_block(now_s)
            rendered = self.engine.render(now_s, count, ahead_s=ahead_s)
            if not np.isfinite(rendered).all():
                raise ParameterError("a texture's samples must be finite, got NaN or infinity")  # noqa: TRY301
            if self.output is None:
                self._last[:] = rendered[:, -1:]
                return rendered
            if not self._connected:
                return self.output.missing(count)
            block = self.output.process(rendered, self.engine.tracker.block)
            if self.output.guard.fault is not None:
                raise ParameterError(self.output.guard.fault)  # noqa: TRY301
        except Exception as error:  # the actuator goes to rest after any error
            self.error = error
            return self._fade(count)
        return block

    def _fade(self, count: int) -> Block:
        if self.output is not None:
            return self.output.missing(count)
        fade = np.linspace(1, 0, count, dtype=np.float32)
        block = self._last * fade
        self._last = np.zeros_like(self._last)
        return block

    def _add_to_record(self, block: Block) -> None:
        count = min(self._record.shape[1] - self._recorded, block.shape[1])
        self._record[:, self._recorded : self._recorded + count] = block[:, :count]
        self._recorded += count
        self._sent += block.shape[1]
        motion = self.engine.tracker.block
        if motion.count:
            last = motion.count - 1
            speed = motion.speed_mm_s[last] if motion.contact[last] > 0 else 0.0
            self._track.extend((self._sent / self.engine.rate, speed, motion.force_n[last]))

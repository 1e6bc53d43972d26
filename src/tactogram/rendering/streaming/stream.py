"""Stream: an engine and a display's output as a backend sees them, measured, and at rest after any error."""

from __future__ import annotations

import time
from array import array
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.streaming.engine import Engine
from tactogram.rendering.streaming.output import DisplayOutput

Block = NDArray[np.float32]

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
            raise ParameterError(
                f"engine must run at the display's {output.display.rate:g} Hz, got {engine.rate:g}"
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

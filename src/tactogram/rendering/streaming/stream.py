"""A stream as a backend sees it: one call, one block, measured, and at rest whatever happens."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.streaming.engine import Engine
from tactogram.rendering.streaming.output import DisplayOutput

Block = NDArray[np.float32]

ENDING_S = 0.02
"""How long before its end a stream begins to fade, s: longer than a display's fade."""
LONGEST_RECORD = 60_000_000
"""Samples, of all channels, that may be kept: 240 MB."""


class Stream:
    """An engine, the display that it drives, and what is kept of both.

    Parameters
    ----------
    engine : Engine
    output : DisplayOutput, optional
        None streams the texture itself, in its unit.
    record_s : float
        How much of what was sent is kept, s.
    on_block : callable, optional
        Called with the time before each block: a mix that changes, say.

    Raises
    ------
    ParameterError
        If the engine's rate is not the display's, or more is to be kept than memory should hold.
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
        """From `ENDING_S` before this time on there is a fade to rest, and rest."""
        self._on_block = on_block
        kept = round(record_s * engine.rate)
        if kept * len(self.channels) > LONGEST_RECORD:
            raise ParameterError(
                f"{record_s:g} s at {engine.rate:g} Hz are too much to keep; record at most "
                f"{LONGEST_RECORD / engine.rate / len(self.channels):.0f} s"
            )
        self._record: Block = np.empty((len(self.channels), kept), np.float32)
        self._record[:] = 0.0  # touched now, so that no page is missing later
        self._track = np.zeros((kept // engine.most + 1 if kept else 0, 3))
        self._kept = self._tracked = 0
        self._silence: Block = np.zeros((len(self.channels), engine.most), np.float32)
        self._last = np.zeros((len(self.channels), 1), np.float32)

    @property
    def recorded(self) -> Block:
        """What was sent, float32, shape (channel, time)."""
        return self._record[:, : self._kept]

    @property
    def track(self) -> NDArray[np.float64]:
        """Time in s, speed in mm/s and force in N at the end of each block, float64, shape (block, 3)."""
        return self._track[: self._tracked]

    def next(self, now_s: float, count: int | None = None, *, ahead_s: float = 0.0) -> Block:
        """Return the next block, float32, shape (channel, count); the parameters are those of `Engine.render`.

        Never raises: after an error, kept in ``error``, comes a fade to rest and rest, as at the end.
        """
        begun, worked = time.perf_counter(), time.thread_time()
        count = self.engine.most if count is None else count
        over = self.error is not None or now_s + ahead_s >= self.ends_s - ENDING_S
        block = self._silent(count) if over else self._made(now_s, count, ahead_s)
        self._keep(block)
        worked, taken = time.thread_time() - worked, time.perf_counter() - begun
        engine = self.engine
        engine.latency.add(
            taken,
            worked,
            engine.finger.age(now_s) + ahead_s if self._heard else float("inf"),
            block_s=count / engine.rate,
        )
        return block

    def warm_up(self) -> None:
        """Let everything that a block needs be compiled, loaded and touched before the first one."""
        self.engine.warm_up()
        if self.output is not None:
            self.output.process(np.zeros((len(self.engine.axes), self.engine.most), np.float32))
            self.output.guard.reset()

    def facts(self) -> dict[str, Any]:
        """Return what the stream did, as JSON values."""
        display = {} if self.output is None else {"display": self.output.facts()}
        return self.engine.facts() | {"drive_unit": self.unit, "channels": list(self.channels)} | display

    @property
    def _heard(self) -> bool:
        return self.engine.follower.state != "lost"

    def _made(self, now_s: float, count: int, ahead_s: float) -> Block:
        try:
            if self._on_block is not None:
                self._on_block(now_s)
            rendered = self.engine.render(now_s, count, ahead_s=ahead_s)
            if not np.isfinite(rendered).all():
                raise ParameterError("a texture gave something that is not a number")  # noqa: TRY301
            if self.output is None:
                self._last[:] = rendered[:, -1:]
                return rendered
            if not self._heard:
                return self.output.missing(count)
            block = self.output.process(rendered, self.engine.follower.block)
            if self.output.guard.fault is not None:
                raise ParameterError(self.output.guard.fault)  # noqa: TRY301
        except Exception as error:  # whatever it was, the actuator goes to rest first
            self.error = error
            return self._silent(count)
        return block

    def _silent(self, count: int) -> Block:
        if self.output is not None:
            return self.output.missing(count)
        fade = np.linspace(1, 0, count, dtype=np.float32)
        block = self._last * fade
        self._last = np.zeros_like(self._last)
        return block

    def _keep(self, block: Block) -> None:
        room = self._record.shape[1] - self._kept
        if room <= 0:
            return
        count = min(room, block.shape[1])
        self._record[:, self._kept : self._kept + count] = block[:, :count]
        self._kept += count
        motion = self.engine.follower.block
        if self._tracked < len(self._track) and motion.count:
            last = motion.count - 1
            contact = motion.contact[last] > 0
            self._track[self._tracked] = (
                self._kept / self.engine.rate,
                motion.speed_mm_s[last] if contact else 0.0,
                motion.force_n[last],
            )
            self._tracked += 1

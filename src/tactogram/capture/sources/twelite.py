"""A TWE-Lite receiver as a source: live, from a log, or simulated; the same parser in all three."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any, Self

import numpy as np

from tactogram.capture.source import Block, SourceEnded
from tactogram.capture.stream.byte_stream import ByteStream
from tactogram.capture.stream.raw_log import LoggedStream
from tactogram.capture.twelite.messages import AXES, Packet
from tactogram.capture.twelite.parser import TweliteParser
from tactogram.capture.twelite.sequence import Timeline, TimelineSegment
from tactogram.errors import ParameterError
from tactogram.signal.units import STANDARD_GRAVITY

FULL_SCALE = 16 * STANDARD_GRAVITY
"""Where the ADXL345 clips, m/s^2: App_Tag sets it to 16 g."""
TRUE_STEP = 3.90625 / 4
"""What to multiply by for the sensor's typical scale (256 steps per g) instead of the firmware's 4 mg a step; between
devices it varies by 10 %, so that a calibration of one's own is better."""


class SensorTimelines:
    """The time lines of all sensors that one receiver hears."""

    def __init__(self) -> None:
        self.timelines: dict[str, Timeline] = {}

    def add(self, packets: Iterable[Packet]) -> dict[str, list[TimelineSegment]]:
        """Place ``packets``; return what that adds, by sender."""
        added: dict[str, list[TimelineSegment]] = {}
        for packet in packets:
            line = self.timelines.get(packet.sender)
            if line is None:
                line = self.timelines[packet.sender] = Timeline(packet.sender)
            added.setdefault(packet.sender, []).extend(line.add(packet))
        return added

    def finish(self) -> None:
        """Nothing more will come."""
        for line in self.timelines.values():
            line.finish()


class TweliteSource:
    """One sensor of a TWE-Lite receiver; see `tactogram.capture.source.Source`.

    Parameters
    ----------
    stream : ByteStream
        Where the receiver's bytes come from.
    name : str
        The address.
    sender : str, optional
        Serial number of the sensor, 7 digits as printed on it or 8 as in its frames; by default the first one heard.
        Others are counted in `facts`.
    rate : float, optional
        Nominal rate, Hz.
    scale : float
        What samples are multiplied by: 1 is as the firmware says, `TRUE_STEP` the sensor's data sheet.
    log : Path, optional
        A new file that all bytes go to (`RawLog`).
    simulated : bool
    """

    unit = "m/s^2"

    def __init__(
        self,
        stream: ByteStream,
        *,
        name: str,
        sender: str | None = None,
        rate: float | None = None,
        scale: float = 1.0,
        log: Path | str | None = None,
        simulated: bool = False,
    ) -> None:
        self.name, self.rate, self.simulated = name, rate, simulated
        # The firmware's scale clips at 16.4 g, the data sheet's at 16 g, one's own may lie below.
        self.full_scale = FULL_SCALE * min(1.0, scale / TRUE_STEP)
        self.axes: tuple[str, ...] = AXES
        self.parser, self.senders = TweliteParser(), SensorTimelines()
        if log is not None:
            stream = LoggedStream(stream, log, kind="twelite", address=name, simulated=simulated)
        self._stream, self._scale = stream, scale
        self._sender = None if sender is None else serial_number(sender)
        self._over: str | None = None

    def __enter__(self) -> Self:
        """Open it, and the log first."""
        self._stream.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self._stream.__exit__(kind, error, trace)

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return what has come; None if no sample did within ``timeout_s``."""
        if self._over is not None:
            raise SourceEnded(self._over)
        until = monotonic() + timeout_s
        while True:
            try:
                got = self._stream.read(max(0.0, until - monotonic()))
            except SourceEnded as end:
                self._over = str(end)
                block = self._block(self.senders.add(self.parser.finish()))
                self.senders.finish()
                if block is None:
                    raise
                return block
            if got is None:
                return None
            data, arrival = got
            block = self._block(self.senders.add(self.parser.feed(data, arrival)))
            if block is not None or monotonic() >= until:
                return block

    def facts(self) -> dict[str, Any]:
        """Return what is known: of the sensor, of the other ones, and of the bytes."""
        line = self.senders.timelines.get(self._sender or "") or Timeline(self._sender or "")
        others = {name: other.received for name, other in self.senders.timelines.items() if other is not line}
        return line.facts() | facts_of_bytes(self.parser) | {"others": others, "simulated": self.simulated}

    def _block(self, added: dict[str, list[TimelineSegment]]) -> Block | None:
        if self._sender is None and added:
            self._sender = next(iter(added))
        pieces = added.get(self._sender or "")
        if not pieces:
            return None
        self.axes = self.senders.timelines[self._sender or ""].axes
        samples = np.concatenate([piece.samples for piece in pieces], axis=1)
        if self._scale != 1:
            samples = samples * np.float32(self._scale)
        return Block(samples, pieces[0].first_index, pieces[-1].arrival_s)


def facts_of_bytes(parser: TweliteParser) -> dict[str, Any]:
    """Return what a parser made of its bytes, as JSON knows it."""
    return {
        "rejected": dict(parser.rejected),
        "other": dict(parser.other),
        "bytes": parser.bytes_taken,
        "bytes_rejected": parser.bytes_rejected,
    }


def serial_number(text: str) -> str:
    """Return a sensor's serial number as its hex frames have it: 8 digits, the first one 8.

    Raises
    ------
    ParameterError
        If it is none.
    """
    if not re.fullmatch(r"8?[0-9A-Fa-f]{7}", text):
        raise ParameterError(f"sender must be a serial number of 7 hex digits, e.g. 1013C85, got {text!r}")
    return f"8{text.upper()[-7:]}"

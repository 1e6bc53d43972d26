"""TWE-Lite receivers as sources: live, from a log, or simulated, all through the same parser."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.signal import STANDARD_GRAVITY
from tactogram_capture.source import Block
from tactogram_capture.stream.byte_source import ByteSource, ByteStream
from tactogram_capture.twelite.messages import AXES, Packet
from tactogram_capture.twelite.parser import TweliteParser
from tactogram_capture.twelite.sequence import Timeline, TimelineSegment

FULL_SCALE = 16 * STANDARD_GRAVITY
"""Where the ADXL345 clips, m/s^2: App_Tag sets it to 16 g."""
TRUE_STEP = 3.90625 / 4
"""Factor to the sensor's typical scale (256 steps per g) from the firmware's 4 mg a step; devices
vary by 10 %, so that an individual calibration is better."""


class SensorTimelines:
    """The timelines of all sensors of one receiver."""

    def __init__(self) -> None:
        self.timelines: dict[str, Timeline] = {}

    def add(self, packets: Iterable[Packet]) -> dict[str, list[TimelineSegment]]:
        """Place ``packets`` and return the new segments by sender."""
        added: dict[str, list[TimelineSegment]] = {}
        for packet in packets:
            line = self.timelines.get(packet.sender)
            if line is None:
                line = self.timelines[packet.sender] = Timeline(packet.sender)
            added.setdefault(packet.sender, []).extend(line.add(packet))
        return added

    def finish(self) -> None:
        """End all timelines."""
        for line in self.timelines.values():
            line.finish()


class TweliteSource(ByteSource):
    """One sensor of a TWE-Lite receiver; see `tactogram_capture.source.Source`.

    ``sender`` is its serial number, the 7 printed digits or the 8 of its frames; by default the first one received.
    Others are counted in `facts`. ``scale`` is a factor of the samples: 1 follows the firmware, `TRUE_STEP` the
    sensor's data sheet. ``name`` is the address, ``rate`` the nominal rate (Hz), ``log`` a new file for all bytes.
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
        super().__init__(stream, name=name, kind="twelite", log=log, simulated=simulated)
        self.rate = rate
        # The firmware's scale clips at 16.4 g, the data sheet's at 16 g, a calibrated one may clip lower.
        self.full_scale = FULL_SCALE * min(1.0, scale / TRUE_STEP)
        self.axes: tuple[str, ...] = AXES
        self.parser, self.senders = TweliteParser(), SensorTimelines()
        self._scale = scale
        self._sender = None if sender is None else serial_number(sender)

    def facts(self) -> dict[str, Any]:
        """Return the facts so far: about the sensor, the other sensors, and the bytes."""
        line = self.senders.timelines.get(self._sender or "") or Timeline(self._sender or "")
        others = {name: other.received for name, other in self.senders.timelines.items() if other is not line}
        return line.facts() | parser_facts(self.parser) | {"others": others, "simulated": self.simulated}

    def _parse(self, data: bytes, arrival_s: float) -> Block | None:
        return self._block(self.senders.add(self.parser.feed(data, arrival_s)))

    def _finish(self) -> Block | None:
        block = self._block(self.senders.add(self.parser.finish()))
        self.senders.finish()
        return block

    def _block(self, added: dict[str, list[TimelineSegment]]) -> Block | None:
        if self._sender is None and added:
            self._sender = next(iter(added))
        pieces = added.get(self._sender or "")
        if not pieces:
            return None
        samples = np.concatenate([piece.samples for piece in pieces], axis=1)
        if self._scale != 1:
            samples = samples * np.float32(self._scale)
        return Block(samples, pieces[0].first_index, pieces[-1].arrival_s)


def parser_facts(parser: TweliteParser) -> dict[str, Any]:
    """Return a parser's counts of bytes and messages, as JSON values."""
    return {
        "rejected": dict(parser.rejected),
        "other": dict(parser.other),
        "bytes": parser.bytes_taken,
        "bytes_rejected": parser.bytes_rejected,
    }


def serial_number(text: str) -> str:
    """Return a sensor's serial number in the form of its hex frames: 8 digits, the first one 8.

    Raises `ParameterError` if ``text`` is not a serial number.
    """
    if not re.fullmatch(r"8?[0-9A-Fa-f]{7}", text):
        raise ParameterError(f"sender must be a serial number of 7 hex digits, e.g. 1013C85, got {text!r}")
    return f"8{text.upper()[-7:]}"

"""TWE-Lite receivers as sources, live, from a log, or simulated, and the timelines of their packets."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal import STANDARD_GRAVITY
from tactogram_capture.source import Block
from tactogram_capture.stream.byte_source import ByteSource, ByteStream
from tactogram_capture.stream.rate_estimate import RateEstimate, RateMeter
from tactogram_capture.twelite.messages import AXES, Mode, Packet
from tactogram_capture.twelite.parser import TweliteParser

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
        raise ParameterError.must("sender", "be a serial number of 7 hex digits, e.g. 1013C85", text)
    return f"8{text.upper()[-7:]}"


SEQUENCE = 65536
"""Packets until their numbers start again."""
MOST_LOST = 100
"""Consecutive packets (3 s at 33 a second) that may be missing without a second packet to confirm it. A larger jump
may be a damaged digit (two of the three forms have no checksum) or a restarted sensor."""
CONFIRMED_AHEAD, CONFIRMED_BEHIND = 2, 5
"""Consecutive packets that confirm a jump; more of them backwards, since a relay may deliver some packets late."""
LONGEST_GAP_S, LONGEST_GAP = 3600.0, 2_000_000
"""Largest gap inserted for a silence, in s and in samples."""


@dataclass(frozen=True, eq=False, slots=True)
class TimelineSegment:
    """Next samples of a sensor, float32, shape (axis, n), m/s^2, after NaN for the missing ones before them."""

    samples: NDArray[np.float32]
    first_index: int
    arrival_s: float


class Timeline:
    """The samples of one sensor in order, NaN where lost."""

    def __init__(self, sender: str) -> None:
        self.sender = sender
        self.mode: Mode | None = None
        """Of the first packet. Packets of other modes have other units and are only counted."""
        self.received = self.lost = self.lost_packets = self.restarts = 0
        """Counts so far. A restart is a jump that is not a loss: its gap lasts as long as the silence if arrival times
        are known, else one packet, and is not in ``lost_packets``."""
        self.dropped: Counter[str] = Counter()
        """Unused packets: ``duplicate`` (two relays), ``late`` (after a later packet), ``stray`` (with an inconsistent
        number), ``another mode``."""
        self.meter = RateMeter()
        self.battery_mv = self.lqi = 0
        self._next = 0
        self._last: int | None = None
        self._last_arrival = float("nan")
        self._suspects: list[Packet] = []

    @property
    def length(self) -> int:
        """Samples so far, including missing ones."""
        return self._next

    def add(self, packet: Packet) -> list[TimelineSegment]:
        """Return the segments that ``packet`` adds: usually one, none or several around an unconfirmed jump."""
        if self.mode is None:
            self.mode = packet.mode
        if packet.mode != self.mode:
            self.dropped["another mode"] += 1
            return []
        if self._last is None:
            return [self._append(packet, 0)]
        ahead = self._ahead(packet)
        if ahead == 0:
            self.dropped["duplicate"] += 1
            return []
        if ahead <= MOST_LOST:
            self._drop_suspects()
            return [self._append(packet, ahead - 1)]
        return self._suspect(packet, ahead)

    def facts(self) -> dict[str, Any]:
        """Return the facts so far, as JSON values."""
        estimate = self.estimate()
        return {
            "sender": self.sender,
            "mode": self.mode,
            "samples": self.received,
            "lost": self.lost,
            "lost_packets": self.lost_packets,
            "dropped": dict(self.dropped),
            "restarts": self.restarts,
            "battery_mv": self.battery_mv,
            "lqi": self.lqi,
            "rate": None if estimate is None else estimate.facts(),
        }

    def estimate(self) -> RateEstimate | None:
        """Return the measured rate, since the last restart."""
        return self.meter.estimate()

    def _ahead(self, packet: Packet) -> int:
        """Return the increase of the sensor's count since the last packet, modulo 65536."""
        return (packet.sequence - (self._last or 0)) % SEQUENCE

    def _append(
        self, packet: Packet, missing_packets: int, missing_samples: int | None = None
    ) -> TimelineSegment:
        n = packet.samples.shape[1]
        gap = missing_packets * n if missing_samples is None else missing_samples
        samples = packet.samples
        if gap:
            samples = np.concatenate([np.full((len(samples), gap), np.nan, np.float32), samples], axis=1)
        broken = int(np.isnan(packet.samples).any(axis=0).sum())
        first = self._next
        self._next += gap + n
        self.received += n - broken
        self.lost += gap + broken
        self.lost_packets += missing_packets
        self.battery_mv, self.lqi = packet.battery_mv, packet.lqi
        self._last, self._last_arrival = packet.sequence, _time(packet)
        self.meter.add(self._next, self._last_arrival)
        return TimelineSegment(samples, first, packet.arrival_s)

    def _suspect(self, packet: Packet, ahead: int) -> list[TimelineSegment]:
        """Keep a packet whose number jumps until the next ones confirm it or not."""
        if self._suspects:
            step = (packet.sequence - self._suspects[-1].sequence) % SEQUENCE
            if step == 0:
                self.dropped["duplicate"] += 1
                return []
            if step > MOST_LOST:
                self._drop_suspects()
        self._suspects.append(packet)
        behind = SEQUENCE - ahead <= MOST_LOST
        if len(self._suspects) < (CONFIRMED_BEHIND if behind else CONFIRMED_AHEAD):
            return []
        first, *rest = self._suspects
        self._suspects = []
        # In order: each is counted from the preceding one.
        return [self._jump(first), *(self._append(packet, self._ahead(packet) - 1) for packet in rest)]

    def _jump(self, packet: Packet) -> TimelineSegment:
        """Append a packet after a jump: losses if the time agrees with their number, else a restart."""
        n = packet.samples.shape[1]
        ahead = self._ahead(packet) - 1
        elapsed = _time(packet) - self._last_arrival
        estimate = self.estimate()
        if np.isfinite(elapsed) and estimate is not None:
            packets = elapsed * estimate.hz / n - 1
            if abs(packets - ahead) <= 0.2 * ahead and elapsed <= LONGEST_GAP_S:
                return self._append(packet, ahead)
            gap = max(1, round(min(max(packets, 0.0) * n, LONGEST_GAP_S * estimate.hz, LONGEST_GAP)))
        elif ahead < SEQUENCE // 2 and packet.sequence > MOST_LOST:
            # Without times, only numbers that start again reveal a restart.
            return self._append(packet, ahead)
        else:
            gap = n
        self.restarts += 1
        self.meter.restart()
        return self._append(packet, 0, gap)

    def _drop_suspects(self) -> None:
        last = self._last or 0
        for packet in self._suspects:
            behind = (last - packet.sequence) % SEQUENCE <= 2 * MOST_LOST
            self.dropped["late" if behind else "stray"] += 1
        self._suspects = []

    def finish(self) -> None:
        """End the timeline: drop unconfirmed packets, and measure the rate over all others."""
        self._drop_suspects()
        self.meter.estimate(fresh=True)


def _time(packet: Packet) -> float:
    """Return the arrival of a packet by the computer's clock, else by the receiver's, if it printed one."""
    return packet.arrival_s if np.isfinite(packet.arrival_s) else packet.receiver_s

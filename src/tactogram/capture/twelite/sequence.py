"""Sequence numbers: numbered packets joined to one timeline in which lost samples keep their place."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.capture.stream.rate_estimate import RateEstimate, RateMeter
from tactogram.capture.twelite.messages import AXES, SUMMARY_AXES, Mode, Packet

SEQUENCE = 65536
"""Packets after which their numbers begin again."""
MOST_LOST = 100
"""Packets in a row (3 s at 33 a second) that may be missing without another packet that says so, too. A number that
leaps further may be a damaged digit (three of the five forms have no checksum) or a sensor that was switched on again.
"""
CONFIRMED_AHEAD, CONFIRMED_BEHIND = 2, 5
"""Packets that must follow each other before a leap is believed; of numbers just gone by more, since a relay brings
some of them late."""
LONGEST_GAP_S, LONGEST_GAP = 3600.0, 2_000_000
"""A longer silence is entered as this long, in s and in samples: what is an hour apart is no recording any more."""


@dataclass(frozen=True, eq=False, slots=True)
class TimelineSegment:
    """Samples that come next on the line of a sensor, behind NaN for those that are missing before them.

    Parameters
    ----------
    samples : float32 array, shape (axis, n), m/s^2
    """

    samples: NDArray[np.float32]
    first_index: int
    arrival_s: float


class Timeline:
    """The samples of one sensor in their order. What is lost is NaN; nothing is made up for it.

    Attributes
    ----------
    mode : str or None
        That of the first packet. Packets of another one have another unit, and are counted instead.
    received, lost : int
        Samples that came, and samples known not to have.
    dropped : Counter
        Packets that were not used: ``duplicate`` (two relays), ``late`` (behind one that came after it), ``stray`` (a
        number that fits nowhere), ``another mode``.
    restarts : int
        Leaps that a count of packets does not explain: the sensor began anew. The gap is as long as it took, if the
        times of arrival are known, else one packet; it is not in ``lost_packets``.
    """

    def __init__(self, sender: str) -> None:
        self.sender = sender
        self.mode: Mode | None = None
        self.received = self.lost = self.lost_packets = self.restarts = 0
        self.dropped: Counter[str] = Counter()
        self.meter = RateMeter()
        self.battery_mv = self.lqi = 0
        self._next = 0
        self._last: int | None = None
        self._last_arrival = float("nan")
        self._held: list[Packet] = []

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes of its samples."""
        return SUMMARY_AXES if self.mode == "summary" else AXES

    @property
    def length(self) -> int:
        """Samples so far, those that are missing included."""
        return self._next

    def add(self, packet: Packet) -> list[TimelineSegment]:
        """Return what ``packet`` adds to the line: mostly one piece, none or several where a leap is in question."""
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
            self._give_up_held()
            return [self._append(packet, ahead - 1)]
        return self._hold(packet, ahead)

    def facts(self) -> dict[str, Any]:
        """Return what is known of it, as JSON knows it."""
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
        """Return by how many packets the sensor's count has gone on since the last one, modulo 65536."""
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

    def _hold(self, packet: Packet, ahead: int) -> list[TimelineSegment]:
        """Keep a packet whose number leaps until the next ones follow it, or do not."""
        if self._held:
            step = (packet.sequence - self._held[-1].sequence) % SEQUENCE
            if step == 0:
                self.dropped["duplicate"] += 1
                return []
            if step > MOST_LOST:
                self._give_up_held()
        self._held.append(packet)
        behind = SEQUENCE - ahead <= MOST_LOST
        if len(self._held) < (CONFIRMED_BEHIND if behind else CONFIRMED_AHEAD):
            return []
        first, *rest = self._held
        self._held = []
        # One after the other: each counts from the one before it.
        return [self._leap(first), *(self._append(held, self._ahead(held) - 1) for held in rest)]

    def _leap(self, packet: Packet) -> TimelineSegment:
        """Take a packet after a leap: losses where the time agrees with their number, else a restart."""
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
            # Without times, only numbers that begin again tell a restart.
            return self._append(packet, ahead)
        else:
            gap = n
        self.restarts += 1
        self.meter.restart()
        return self._append(packet, 0, gap)

    def _give_up_held(self) -> None:
        last = self._last or 0
        for held in self._held:
            behind = (last - held.sequence) % SEQUENCE <= 2 * MOST_LOST
            self.dropped["late" if behind else "stray"] += 1
        self._held = []

    def finish(self) -> None:
        """Count what was still in question, and measure the rate over everything: nothing more will come."""
        self._give_up_held()
        self.meter.estimate(fresh=True)


def _time(packet: Packet) -> float:
    """Return when a packet arrived: by the computer's clock, else by the receiver's, if it printed one."""
    return packet.arrival_s if np.isfinite(packet.arrival_s) else packet.receiver_s

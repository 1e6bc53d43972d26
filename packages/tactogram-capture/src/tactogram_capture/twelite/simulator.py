"""A simulated TWE-Lite sensor and receiver that prints real frames, late, lost and damaged."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.signal import STANDARD_GRAVITY, Signal, resample
from tactogram.validation import FrozenModel
from tactogram_capture.source import SourceEnded, SourceLost
from tactogram_capture.stream.raw_log import RawLog
from tactogram_capture.twelite.messages import (
    FIFO_SAMPLES,
    MILLI_G,
    UNITS_BY_MODE,
    Form,
    Mode,
    battery_code,
    checksum,
)

_CODES: dict[Mode, int] = {"single": 0x00, "fifo": 0xFA, "low_energy": 0xFE}
_SECONDS_AHEAD = 1.0

Measured = Signal | Iterator[NDArray[np.float32]] | None
"""What a simulated sensor measures; see `transmissions`."""


class SimulatedReceiver(FrozenModel):
    """Timing, losses and damage of a simulated receiver; the defaults are a real one at 330 Hz without losses."""

    rate: float = Field(default=330.0, gt=0, le=1e6)
    """Samples per second of the sensor; real ones reach 690 over 115200 baud."""
    loss: float = Field(default=0.0, ge=0, lt=1)
    """Share of radio packets that do not arrive."""
    jitter_s: float = Field(default=0.002, ge=0, le=10)
    """Mean delay of a packet, s, distributed exponentially; later packets queue behind it."""
    corrupt: float = Field(default=0.0, ge=0, le=1)
    """Share of bytes that are flipped, dropped or doubled on the cable."""
    form: Form = "hex"
    mode: Mode = "fifo"
    sender: str = Field(default="81013C85", pattern="^8[0-9A-F]{7}$")
    first_sequence: int = Field(default=0, ge=0, le=65535)
    seed: int = Field(default=0, ge=0)
    seconds: float | None = Field(default=None, gt=0)
    """Duration, s; None is endless, or until the end of the signal."""

    @property
    def samples_per_packet(self) -> int:
        """Samples per radio packet."""
        return FIFO_SAMPLES if self.mode == "fifo" else 1


@dataclass(frozen=True, eq=False, slots=True)
class Transmission:
    """One radio packet and its fate."""

    time_s: float
    """Arrival of its last byte, s after the start."""
    data: bytes
    """The receiver's output; empty if the packet was lost."""
    sequence: int
    """Unwrapped: it continues beyond 65535."""
    samples: NDArray[np.float32]
    """As the sensor quantised them, float32, shape (axis, n), m/s^2."""
    damaged: bool
    """Whether a byte of ``data`` is wrong."""


def transmissions(receiver: SimulatedReceiver, measured: Measured = None) -> Iterator[Transmission]:
    """Yield the packets of a simulated sensor and receiver.

    What is ``measured`` is a signal of axes x, y, z, m/s^2 (else `ParameterError`), resampled to the sensor's rate, or
    the samples of each packet in turn; by default a finger that strokes a rough surface twice a second, with gravity
    along z.
    """
    rng = np.random.default_rng(receiver.seed)
    per_packet, period = receiver.samples_per_packet, receiver.samples_per_packet / receiver.rate
    step = UNITS_BY_MODE[receiver.mode] * (4 if receiver.mode == "fifo" else 1)
    now = 0.0
    for number, x in enumerate(_packet_samples(receiver, measured, per_packet, rng)):
        if receiver.seconds is not None and (number + 1) * period > receiver.seconds + 1e-9:
            return
        steps = np.clip(np.round(x / step), -4096 if receiver.mode == "fifo" else -1638, 4095)
        counts = (steps * (4 if receiver.mode == "fifo" else 1)).astype(np.int64)
        now = max(now, (number + 1) * period + rng.exponential(receiver.jitter_s))
        lost = rng.random() < receiver.loss
        sequence = receiver.first_sequence + number
        data = b"" if lost else printed(receiver, sequence, counts, now)
        wrong = _damaged(data, receiver.corrupt, rng) if receiver.corrupt else data
        samples = (counts * UNITS_BY_MODE[receiver.mode]).astype(np.float32)
        yield Transmission(now, wrong, sequence, samples, wrong != data)


def write_log(path: Path, receiver: SimulatedReceiver, *, start_s: float = 0.0) -> int:
    """Write what a simulated receiver sends to a new raw log, as if read live; return the number of packets."""
    sent = list(transmissions(receiver))
    with RawLog(path, kind="twelite", address="simulated:twelite", simulated=True) as log:
        for packet in sent:
            if packet.data:
                log.write(packet.data, round(start_s + packet.time_s, 6))
    return len(sent)


def printed(receiver: SimulatedReceiver, sequence: int, counts: NDArray[np.int64], time_s: float) -> bytes:
    """Return the bytes that a receiver prints for one packet at ``time_s`` on its clock.

    ``counts`` is int64, shape (axis, n), in mg (ten-sample packets) or 10 mg.
    """
    sequence %= 65536
    battery, adc1, adc2, lqi = 3330, 1399, 754, 99
    code = _CODES[receiver.mode]
    if receiver.form == "hex":
        payload = bytearray.fromhex(f"80000000{lqi:02X}{sequence:04X}{receiver.sender}0035")
        payload += bytes([battery_code(battery)]) + adc1.to_bytes(2, "big") + adc2.to_bytes(2, "big")
        payload.append(code)
        if receiver.mode == "fifo":
            payload.append(counts.shape[1])
        payload += counts.T.astype(">i2").tobytes()
        payload.append(checksum(payload))
        return f":{payload.hex().upper()}\r\n".encode()
    rows = [[f"{value:04d}" for value in column] for column in counts.T]
    if receiver.form == "standard":
        line = f"::rc=80000000:lq={lqi}:ct={sequence:04X}:ed={receiver.sender}:id=0"
        line += f":ba={battery:04d}:a1={adc1:04d}:a2={adc2:04d}"
        # The semicolon before the first z of ten is the real firmware's.
        slip = ";" if receiver.mode == "fifo" else ":"
        seps = [slip, *":" * (len(rows) - 1)]
        line += "".join(f":x={x}:y={y}{sep}z={z}" for sep, (x, y, z) in zip(seps, rows, strict=True))
        return f"{line}\r\n".encode()
    clock = f"{int(time_s)}.{int(time_s * 100) % 100:02d}" if receiver.mode == "fifo" else f"{int(time_s)}"
    head = [
        "", clock, "00000000", f"{lqi:03d}", f"{sequence:03d}", receiver.sender[1:],
        f"{battery:04d}", f"{code:04X}", "0000", f"{adc1:04d}", f"{adc2:04d}", "X",
    ]  # fmt: skip
    lines = [";".join([*head, *rows[0], ""])]
    lines += [";" * 12 + ";".join([*row, ""]) for row in rows[1:]]
    return "".join(f"{line}\r\n" for line in lines).encode()


def _packet_samples(
    receiver: SimulatedReceiver, measured: Measured, per_packet: int, rng: np.random.Generator
) -> Iterator[NDArray[np.floating]]:
    """Yield the acceleration during each packet, shape (3, per_packet), m/s^2."""
    if isinstance(measured, Iterator):
        yield from measured
        return
    if measured is not None:
        _check(measured)
        x = resample(measured, receiver.rate).samples.astype(np.float64)
        for start in range(0, x.shape[1] - per_packet + 1, per_packet):
            yield x[:, start : start + per_packet]
        return
    count, n = 0, max(per_packet, math.ceil(receiver.rate * _SECONDS_AHEAD / per_packet) * per_packet)
    gravity = np.array([[0.0], [0.0], [STANDARD_GRAVITY]])
    while True:
        times = (count + np.arange(n)) / receiver.rate
        stroking = np.sin(2 * np.pi * 2.0 * times) ** 2
        x = gravity + 2.0 * stroking * rng.standard_normal((3, n)) + 2 * MILLI_G * rng.standard_normal((3, n))
        for start in range(0, n, per_packet):
            yield x[:, start : start + per_packet]
        count += n


def _check(signal: Signal) -> None:
    if len(signal.axes) != 3 or signal.unit != "m/s^2" or signal.domain != "time":
        raise ParameterError(
            f"a simulated sensor measures 3 axes over time in m/s^2, got {len(signal.axes)} in {signal.unit} "
            f"over {signal.domain}"
        )


def _damaged(data: bytes, share: float, rng: np.random.Generator) -> bytes:
    """Return ``data`` with a share of its bytes flipped in a bit, dropped or doubled."""
    hit = np.flatnonzero(rng.random(len(data)) < share)
    if not len(hit):
        return data
    pieces, last = [], 0
    for index in hit:
        byte = data[index]
        how = rng.integers(3)
        pieces.append(data[last:index])
        pieces.append(
            bytes([byte ^ (1 << int(rng.integers(8)))]) if how == 0 else bytes([byte, byte])[: 2 * (how - 1)]
        )
        last = int(index) + 1
    return b"".join([*pieces, data[last:]])


class SimulatedPort:
    """A simulated receiver as a `ByteStream` that prints in real time.

    ``measured`` is as in `transmissions`. Unless ``paced``, packets arrive as fast as they are read.
    """

    def __init__(self, receiver: SimulatedReceiver, measured: Measured = None, *, paced: bool = True) -> None:
        if isinstance(measured, Signal):
            _check(measured)
        self.receiver, self.paced, self._measured = receiver, paced, measured
        self.name = "simulated:twelite"
        self.sent = self.lost = self.damaged = 0
        """Radio packets so far: all, the lost, and those with a wrong byte."""
        self._coming: Iterator[Transmission] | None = None
        self._next: Transmission | None = None
        self._start_s = 0.0

    def __enter__(self) -> Self:
        self._start_s, self._coming = monotonic(), transmissions(self.receiver, self._measured)
        return self

    def __exit__(self, *_: object) -> None:
        self._coming = None

    def read(self, timeout_s: float) -> tuple[bytes, float] | None:
        """Return the bytes of all packets that are due, and their arrival; None if none is due in time.

        Raises `SourceEnded` at the end of the simulation.
        """
        if self._coming is None:
            raise SourceLost(f"{self.name}: is not open")
        until, data, arrival_s = monotonic() + timeout_s, b"", 0.0
        while True:
            self._next = self._next or next(self._coming, None)
            if self._next is None and not data:
                raise SourceEnded(f"{self.name}: the simulation ended")
            due_s = self._start_s + self._next.time_s if self._next and self.paced else monotonic()
            if data and (self._next is None or not self.paced or due_s > monotonic()):
                return data, arrival_s
            sleep(max(0.0, min(due_s, until) - monotonic()))
            if self._next is None or (due_s > until and not data):
                return None
            packet, self._next = self._next, None
            self.sent += 1
            self.lost += not packet.data
            self.damaged += packet.damaged
            if packet.data:
                data, arrival_s = data + packet.data, due_s

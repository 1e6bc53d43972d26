"""The schema by which a game engine sends motion and gets blocks, as plain packets and as OSC; see docs/streaming.md.

Plain packets are little-endian and begin with four letters and a version. OSC messages are big-endian, as OSC is, but
for the samples of a block, which are little-endian float32 in both. Parsing never raises: what is not understood is
None, for the receiver to count.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.extras import imported
from tactogram.rendering.streaming.motion import MixWeights, MotionSample, Tap

VERSION = 1
MOTION = struct.Struct("<4sHHIdffff")
"""TGMO, version, which values hold (1 position, 2 speed, 4 force), sequence, time s, x mm, y mm, mm/s, force N."""
TAP = struct.Struct("<4sHHIdf")
"""TGTA, version, 0, sequence, time s, strength (1 is a landing of 1 N)."""
MIX = struct.Struct("<4sHHIdf")
"""TGMX, version, bytes of the name, sequence, time s, weight; the name in UTF-8 follows."""
BLOCK = struct.Struct("<4sHHIIqdfI")
"""TGBL, version, channels, sequence, newest motion's sequence, first sample, time s, rate Hz, samples per channel."""
POSITION, SPEED, FORCE = 1, 2, 4
NO_MOTION = 0xFFFFFFFF
"""Stands for the newest motion's sequence before there is one."""
OSC = "/tactogram/1"
LONGEST = 65_000
"""Bytes that a packet may have."""


@dataclass(frozen=True, slots=True)
class ReceivedPacket:
    """A packet that was understood.

    Parameters
    ----------
    sequence : int
        0 to 2^32 - 1, one more with each packet of a sender, of whatever kind; wraps.
    message : MotionSample, Tap or Weights
    """

    sequence: int
    message: MotionSample | Tap | MixWeights


@dataclass(frozen=True, eq=False)
class BlockPacket:
    """Samples that go out.

    Parameters
    ----------
    samples : float32 array, shape (channel, n)
    rate : float, Hz
    sequence : int
        0 to 2^32 - 1; wraps. One that is missing was lost on the way.
    first_sample : int
        Place of the first sample since the stream began.
    time_s : float
        When the block was begun, s on the engine's clock.
    motion_sequence : int
        Of the newest motion that was heard; `NO_MOTION` for none. The sender can tell the way to and fro by it.
    """

    samples: NDArray[np.float32]
    rate: float
    sequence: int
    first_sample: int
    time_s: float
    motion_sequence: int


def parse(packet: bytes, arrival_s: float) -> list[ReceivedPacket] | None:
    """Return what a packet says (an OSC bundle may say several things), or None if it is not understood."""
    if len(packet) > LONGEST:
        return None
    if packet[:2] == b"TG":
        one = _parse_plain(packet, arrival_s)
        return None if one is None else [one]
    if packet[:1] in (b"/", b"#"):
        return _parse_osc(packet, arrival_s)
    return None


def motion_packet(
    sequence: int,
    time_s: float,
    *,
    x_mm: float = math.nan,
    y_mm: float = math.nan,
    speed_mm_s: float = math.nan,
    force_n: float = math.nan,
) -> bytes:
    """Return a plain packet of motion; NaN is not known."""
    flags = POSITION * (x_mm == x_mm) + SPEED * (speed_mm_s == speed_mm_s) + FORCE * (force_n == force_n)
    values = (0.0 if v != v else v for v in (x_mm, y_mm, speed_mm_s, force_n))
    return MOTION.pack(b"TGMO", VERSION, flags, sequence & NO_MOTION, time_s, *values)


def motion_message(
    sequence: int,
    time_s: float,
    *,
    x_mm: float = math.nan,
    y_mm: float = math.nan,
    speed_mm_s: float = math.nan,
    force_n: float = math.nan,
) -> bytes:
    """Return an OSC message of motion; NaN is not known."""
    values = (("f", x_mm), ("f", y_mm), ("f", speed_mm_s), ("f", force_n))
    return _osc("motion", (("i", _signed(sequence)), ("d", time_s), *values))


def block_packet(block: BlockPacket) -> bytes:
    """Return a block as a plain packet."""
    channels, count = block.samples.shape
    head = BLOCK.pack(
        b"TGBL",
        VERSION,
        channels,
        block.sequence & NO_MOTION,
        block.motion_sequence & NO_MOTION,
        block.first_sample,
        block.time_s,
        block.rate,
        count,
    )
    return head + _interleaved(block.samples)


def block_message(block: BlockPacket) -> bytes:
    """Return a block as an OSC message."""
    return _osc(
        "block",
        (
            ("i", _signed(block.sequence)),
            ("i", _signed(block.motion_sequence)),
            ("h", block.first_sample),
            ("d", block.time_s),
            ("f", block.rate),
            ("i", len(block.samples)),
            ("b", _interleaved(block.samples)),
        ),
    )


def parse_block(packet: bytes) -> BlockPacket | None:
    """Return the block in a plain packet or an OSC message, or None: what a receiver in Python needs."""
    if packet[:4] == b"TGBL" and len(packet) >= BLOCK.size:
        _, version, channels, sequence, motion, first, time_s, rate, count = BLOCK.unpack_from(packet)
        if version != VERSION or channels == 0 or len(packet) != BLOCK.size + 4 * channels * count:
            return None
        samples = _separated(packet[BLOCK.size :], channels)
        return BlockPacket(samples, rate, sequence, first, time_s, motion)
    messages = _messages(packet) if packet[:1] == b"/" else None
    if not messages or messages[0][0] != f"{OSC}/block":
        return None
    values = messages[0][1]
    if [type(value) for value in values] != [int, int, int, float, float, int, bytes]:
        return None
    sequence, motion, first, time_s, rate, channels, data = values
    if channels < 1 or len(data) % (4 * channels):
        return None
    return BlockPacket(
        _separated(data, channels), rate, sequence & NO_MOTION, first, time_s, motion & NO_MOTION
    )


def _parse_plain(packet: bytes, arrival_s: float) -> ReceivedPacket | None:
    kind = packet[:4]
    if kind == b"TGMO" and len(packet) == MOTION.size:
        _, version, flags, sequence, time_s, x, y, speed, force = MOTION.unpack(packet)
        nan = math.nan
        x, y = (x, y) if flags & POSITION else (nan, nan)
        sample = MotionSample(
            time_s, arrival_s, x, y, speed if flags & SPEED else nan, force if flags & FORCE else nan
        )
        return ReceivedPacket(sequence, sample) if version == VERSION else None
    if kind == b"TGTA" and len(packet) == TAP.size:
        _, version, _, sequence, _, strength = TAP.unpack(packet)
        return ReceivedPacket(sequence, Tap(arrival_s, strength)) if version == VERSION else None
    if kind == b"TGMX" and len(packet) >= MIX.size:
        _, version, length, sequence, _, weight = MIX.unpack_from(packet)
        name = packet[MIX.size :]
        if version != VERSION or len(name) != length:
            return None
        try:
            return ReceivedPacket(sequence, MixWeights({name.decode(): weight}))
        except UnicodeDecodeError:
            return None
    return None


def _parse_osc(packet: bytes, arrival_s: float) -> list[ReceivedPacket] | None:
    messages = _messages(packet)
    if not messages:
        return None
    found = []
    for address, values in messages:
        kind = address.removeprefix(f"{OSC}/")
        shape = "".join(type(value).__name__[0] for value in values)
        if not address.startswith(f"{OSC}/"):
            return None
        # Some senders write a whole number as an int; the first two are what orders the packets.
        if kind == "motion" and len(shape) == 6 and shape[0] == "i" and set(shape) <= {"i", "f"}:
            sequence, time_s, *rest = values
            message: MotionSample | Tap | MixWeights = MotionSample(
                float(time_s), arrival_s, *map(float, rest)
            )
        elif kind == "tap" and len(shape) == 3 and shape[0] == "i" and set(shape) <= {"i", "f"}:
            sequence, message = values[0], Tap(arrival_s, float(values[2]))
        elif kind == "mix" and len(shape) == 4 and shape[0] == "i" and shape[2] == "s" and shape[3] in "if":
            sequence, message = values[0], MixWeights({values[2]: float(values[3])})
        else:
            return None
        found.append(ReceivedPacket(sequence & NO_MOTION, message))
    return found


def _messages(packet: bytes) -> list[tuple[str, list[Any]]] | None:
    """Return addresses and values of an OSC message or bundle, or None where it is neither."""
    try:
        osc = imported("pythonosc.osc_packet", extra="devices", what="OSC")
        read = osc.OscPacket(packet)
        return [(m.message.address, list(m.message.params)) for m in read.messages]
    except Exception:
        # Whatever its bytes lead the parser to, none of it is ours; or the parser is not installed.
        return None


def _osc(kind: str, values: tuple[tuple[str, object], ...]) -> bytes:
    builder = imported("pythonosc.osc_message_builder", extra="devices", what="OSC").OscMessageBuilder(
        address=f"{OSC}/{kind}"
    )
    for letter, value in values:
        builder.add_arg(value, letter)
    packed: bytes = builder.build().dgram
    return packed


def _signed(sequence: int) -> int:
    """Return 32 bits as OSC's int32 has them."""
    low = sequence & NO_MOTION
    return low - (1 << 32) if low >= 1 << 31 else low


def _interleaved(samples: NDArray[np.float32]) -> bytes:
    return np.ascontiguousarray(samples.T, "<f4").tobytes()


def _separated(data: bytes, channels: int) -> NDArray[np.float32]:
    return np.frombuffer(data, "<f4").reshape(-1, channels).T.astype(np.float32)

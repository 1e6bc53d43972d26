"""Packets by which a game engine sends motion and receives blocks, plain and as OSC; see docs/streaming.md.

Plain packets are little-endian and begin with four letters and a version. OSC messages are big-endian as OSC requires,
except for a block's samples, which are little-endian float32 in both. Parsing never raises: the result is None for an
invalid packet.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.extras import imported
from tactogram.rendering.streaming.motion import MixWeights, MotionSample, Tap

Form = Literal["osc", "udp"]

VERSION = 1
MOTION = struct.Struct("<4sHHIdffff")
"""TGMO, version, flags of valid values (1 position, 2 speed, 4 force), sequence, time s, x mm, y mm, mm/s, force N."""
TAP = struct.Struct("<4sHHIdf")
"""TGTA, version, 0, sequence, time s, strength (1 is a landing of 1 N)."""
MIX = struct.Struct("<4sHHIdf")
"""TGMX, version, length of the name in bytes, sequence, time s, weight; the name in UTF-8 follows."""
BLOCK = struct.Struct("<4sHHIIqdfI")
"""TGBL, version, channels, sequence, newest motion's sequence, first sample, time s, rate Hz, samples per channel."""
POSITION, SPEED, FORCE = 1, 2, 4
NO_MOTION = 0xFFFFFFFF
"""Replaces the newest motion's sequence before there is any."""
OSC = "/tactogram/1"
LONGEST = 65_000
"""Largest packet that is parsed, bytes."""


@dataclass(frozen=True, slots=True)
class ReceivedPacket:
    """A valid packet; ``sequence`` increases with each of a sender's packets of any kind, and wraps at 2^32."""

    sequence: int
    message: MotionSample | Tap | MixWeights


@dataclass(frozen=True, eq=False)
class BlockPacket:
    """A block of samples to send, float32, shape (channel, n), with the time on the engine's clock at which it begins.

    ``sequence`` wraps at 2^32, and a gap is a lost packet; ``first_sample`` counts samples since the stream began;
    ``motion_sequence`` is that of the newest motion received, for measuring the round trip, `NO_MOTION` before any.
    """

    samples: NDArray[np.float32]
    rate: float
    sequence: int
    first_sample: int
    time_s: float
    motion_sequence: int


def parse(packet: bytes, arrival_s: float) -> list[ReceivedPacket] | None:
    """Return a packet's messages (an OSC bundle may hold several), or None if it is invalid."""
    if len(packet) > LONGEST:
        return None
    if packet[:2] == b"TG":
        received = _parse_plain(packet, arrival_s)
        return None if received is None else [received]
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
    form: Form = "udp",
) -> bytes:
    """Return a packet of motion, plain or OSC; NaN marks missing values."""
    values = (x_mm, y_mm, speed_mm_s, force_n)
    if form == "osc":
        return _osc("motion", (("i", _signed(sequence)), ("d", time_s), *(("f", value) for value in values)))
    flags = sum(
        flag
        for flag, value in ((POSITION, x_mm), (SPEED, speed_mm_s), (FORCE, force_n))
        if not math.isnan(value)
    )
    known = (0.0 if math.isnan(value) else value for value in values)
    return MOTION.pack(b"TGMO", VERSION, flags, sequence & NO_MOTION, time_s, *known)


def block_packet(block: BlockPacket, form: Form = "udp") -> bytes:
    """Return a block as a packet, plain or OSC."""
    channels, count = block.samples.shape
    if form == "osc":
        return _osc(
            "block",
            (
                ("i", _signed(block.sequence)),
                ("i", _signed(block.motion_sequence)),
                ("h", block.first_sample),
                ("d", block.time_s),
                ("f", block.rate),
                ("i", channels),
                ("b", _interleaved(block.samples)),
            ),
        )
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


def parse_block(packet: bytes) -> BlockPacket | None:
    """Return the block in a plain packet or an OSC message, or None if it is invalid: for receivers in Python."""
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
    received = []
    for address, values in messages:
        kind = address.removeprefix(f"{OSC}/")
        shape = "".join(type(value).__name__[0] for value in values)
        if not address.startswith(f"{OSC}/"):
            return None
        # Some senders write integral floats as ints.
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
        received.append(ReceivedPacket(sequence & NO_MOTION, message))
    return received


def _messages(packet: bytes) -> list[tuple[str, list[Any]]] | None:
    """Return addresses and values of an OSC message or bundle, or None if it is neither."""
    try:
        osc = imported("pythonosc.osc_packet", extra="devices", what="OSC")
        read = osc.OscPacket(packet)
        return [(m.message.address, list(m.message.params)) for m in read.messages]
    except Exception:
        # Arbitrary bytes may raise anything in the parser; or it is not installed.
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
    """Return 32 bits as OSC's int32."""
    low = sequence & NO_MOTION
    return low - (1 << 32) if low >= 1 << 31 else low


def _interleaved(samples: NDArray[np.float32]) -> bytes:
    return np.ascontiguousarray(samples.T, "<f4").tobytes()


def _separated(data: bytes, channels: int) -> NDArray[np.float32]:
    return np.frombuffer(data, "<f4").reshape(-1, channels).T.astype(np.float32)

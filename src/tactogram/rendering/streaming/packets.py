"""OSC messages by which a game engine sends motion and receives blocks; see docs/streaming.md.

They are big-endian as OSC requires, except for a block's samples, which are little-endian float32. Parsing never
raises: the result is None for an invalid packet.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.extras import imported
from tactogram.rendering.streaming.motion import MixWeights, MotionSample, Tap

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


def block_packet(block: BlockPacket) -> bytes:
    """Return a block as a message."""
    return _osc(
        "block",
        (
            ("i", _signed(block.sequence)),
            ("i", _signed(block.motion_sequence)),
            ("h", block.first_sample),
            ("d", block.time_s),
            ("f", block.rate),
            ("i", len(block.samples)),
            ("b", np.ascontiguousarray(block.samples.T, "<f4").tobytes()),
        ),
    )


def parse(packet: bytes, arrival_s: float) -> list[ReceivedPacket] | None:
    """Return a packet's messages (a bundle may hold several), or None if it is invalid."""
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
    """Return addresses and values of a message or bundle, or None if it is neither."""
    if len(packet) > LONGEST or packet[:1] not in (b"/", b"#"):
        return None
    try:
        osc = imported("pythonosc.osc_packet", extra="devices", what="OSC")
        read = osc.OscPacket(packet)
        return [(m.message.address, list(m.message.params)) for m in read.messages]
    except Exception:
        # Arbitrary bytes may raise anything in the parser.
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

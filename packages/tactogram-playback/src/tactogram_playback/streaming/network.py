"""Motion from game engines, and blocks to them: OSC messages over one UDP port; see docs/streaming.md.

Messages are big-endian as OSC requires, except for a block's samples, which are little-endian float32. Parsing never
raises: the result is None for an invalid packet.
"""

from __future__ import annotations

import socket
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DeviceError, ParameterError, one_line
from tactogram.extras import imported
from tactogram.rendering import MixWeights, MotionSample, Tap

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
    builders = imported("pythonosc.osc_message_builder", extra="devices", what="OSC")
    builder = builders.OscMessageBuilder(address=f"{OSC}/block")
    for letter, value in (
        ("i", _signed(block.sequence)),
        ("i", _signed(block.motion_sequence)),
        ("h", block.first_sample),
        ("d", block.time_s),
        ("f", block.rate),
        ("i", len(block.samples)),
        ("b", np.ascontiguousarray(block.samples.T, "<f4").tobytes()),
    ):
        builder.add_arg(value, letter)
    packed: bytes = builder.build().dgram
    return packed


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


def _signed(sequence: int) -> int:
    """Return 32 bits as OSC's int32."""
    low = sequence & NO_MOTION
    return low - (1 << 32) if low >= 1 << 31 else low


PORT = 9120
WAITING = 256
"""Most messages waiting for the next block; the oldest are dropped beyond that."""


class NetworkMotion:
    """Motion from game engines, received by a thread; ``clock`` returns the time on the engine's clock, s.

    It listens on this computer only by default, since anyone who reaches the port moves the actuator. Port 0 is any
    free port, see `address`. Raises `MissingExtraError` without python-osc, `DeviceError` if the port cannot be opened.
    """

    simulated = False

    def __init__(self, *, host: str = "127.0.0.1", port: int = PORT, clock: Callable[[], float]) -> None:
        imported("pythonosc", extra="devices", what="OSC")
        self._clock = clock
        self._waiting: deque[MotionSample | Tap | MixWeights] = deque(maxlen=WAITING)
        self.not_understood = 0
        self.overflowed = 0
        self.missing = 0
        """Sequence numbers that never arrived, or arrived too late."""
        self.sender: tuple[str, int] | None = None
        self.sequence = NO_MOTION
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise DeviceError(f"osc:{host}:{port}: cannot listen ({one_line(error)})") from error
        self._socket.settimeout(0.1)
        self.address: tuple[str, int] = self._socket.getsockname()
        self.name = f"osc:{self.address[0]}:{self.address[1]}"
        self._ended = False
        self._thread = threading.Thread(target=self._listen, name="motion", daemon=True)
        self._thread.start()

    def poll(self, now_s: float) -> list[MotionSample | Tap | MixWeights]:
        """Return the messages since the last call."""
        messages = []
        while self._waiting:
            messages.append(self._waiting.popleft())
        return messages

    def send(self, packet: bytes, to: tuple[str, int]) -> None:
        """Send from this port, so that replies come from the address that the sender used."""
        self._socket.sendto(packet, to)

    def close(self) -> None:
        """Stop listening."""
        self._ended = True
        self._thread.join(1.0)
        self._socket.close()

    def facts(self) -> dict[str, Any]:
        """Return counts of invalid, dropped and missing packets, and the sender."""
        return {
            "not_understood": self.not_understood,
            "overflowed": self.overflowed,
            "missing": self.missing,
            "sender": None if self.sender is None else f"{self.sender[0]}:{self.sender[1]}",
        }

    def _listen(self) -> None:
        while not self._ended:
            try:
                packet, sender = self._socket.recvfrom(65_535)
            except (TimeoutError, ConnectionError):  # Windows reports here that a sent block was refused
                continue
            except OSError:
                return
            received = parse(packet, self._clock())
            if received is None:
                self.not_understood += 1
                continue
            if sender != self.sender:
                self.sender, self.sequence = sender, NO_MOTION
            for part in received:
                self._count(part.sequence)
                if len(self._waiting) == WAITING:
                    self.overflowed += 1
                self._waiting.append(part.message)

    def _count(self, sequence: int) -> None:
        if self.sequence != NO_MOTION:
            step = (sequence - self.sequence) & NO_MOTION
            if step == 0 or step > 1 << 31:  # older than the newest: its time stamp makes the finger drop it
                return
            self.missing += step - 1
        self.sequence = sequence


class NetworkBlocks:
    """Blocks to a game engine: to the address ``to``, or to the sender of ``motion``, from its port.

    Raises `MissingExtraError` without python-osc, `DeviceError` if the host is unknown.
    """

    def __init__(
        self, *, rate: float, to: tuple[str, int] | None = None, motion: NetworkMotion | None = None
    ) -> None:
        if to is None and motion is None:
            raise ParameterError.must("to", "be an address if the motion does not come from the network")
        imported("pythonosc", extra="devices", what="OSC")
        self._rate, self._motion = rate, motion
        # Resolved only once: a name server may take seconds.
        self._to = None if to is None else _resolved(to)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._sequence = 0
        self._first = 0
        self.sent = 0
        self.unsent = 0
        """Blocks without an address yet, or refused by the network."""

    def __call__(self, samples: NDArray[np.float32], now_s: float) -> None:
        """Send a block, float32, shape (channel, n)."""
        to = self._to or (self._motion.sender if self._motion else None)
        newest = self._motion.sequence if self._motion else NO_MOTION
        block = BlockPacket(samples, self._rate, self._sequence, self._first, now_s, newest)
        self._first += samples.shape[1]
        self._sequence = (self._sequence + 1) & NO_MOTION
        if to is None:
            self.unsent += 1
            return
        try:
            packet = block_packet(block)
            if self._motion is not None:
                self._motion.send(packet, to)
            else:
                self._socket.sendto(packet, to)
            self.sent += 1
        except OSError:
            self.unsent += 1

    def close(self) -> None:
        """Close the port."""
        self._socket.close()


def _resolved(to: tuple[str, int]) -> tuple[str, int]:
    try:
        addresses = socket.getaddrinfo(*to, family=socket.AF_INET, type=socket.SOCK_DGRAM)
    except OSError as error:
        raise DeviceError(f"osc:{to[0]}:{to[1]}: unknown host ({one_line(error)})") from error
    host, port = addresses[0][4][:2]
    return str(host), int(port)


def parse_address(text: str, *, default_port: int = PORT) -> tuple[str, int]:
    """Return host and port of ``"HOST:PORT"``, ``"HOST"`` or ``":PORT"``; `ParameterError` if the port is invalid."""
    host, _, port = text.rpartition(":") if ":" in text else (text, "", str(default_port))
    if not (port.isdigit() and 0 <= int(port) < 1 << 16):
        raise ParameterError.must("address", "be HOST:PORT with a port below 65536", text)
    return host or "127.0.0.1", int(port)

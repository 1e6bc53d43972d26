"""Motion from the network and blocks to it: one UDP port, plain packets and OSC alike."""

from __future__ import annotations

import socket
import threading
from collections import deque
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DeviceError, ParameterError
from tactogram.extras import imported, one_line
from tactogram.rendering.streaming.motion import MixWeights, MotionSample, Tap
from tactogram.rendering.streaming.packets import (
    NO_MOTION,
    BlockPacket,
    block_message,
    block_packet,
    parse,
)

Form = Literal["osc", "udp"]

PORT = 9120
WAITING = 256
"""Messages that may wait for the next block; with more the oldest are dropped."""


class NetworkMotion:
    """Motion that game engines send; heard by a thread that does nothing else.

    Parameters
    ----------
    host : str
        Address to listen at. Only this computer unless said otherwise: whoever reaches the port moves the actuator.
    port : int
        0 takes a free one, see `address`.
    clock : callable
        The engine's clock: seconds now.

    Raises
    ------
    DeviceError
        If the port cannot be opened.
    """

    simulated = False

    def __init__(self, *, host: str = "127.0.0.1", port: int = PORT, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._waiting: deque[MotionSample | Tap | MixWeights] = deque(maxlen=WAITING)
        self.not_understood = 0
        self.overflowed = 0
        self.missing = 0
        """Sequence numbers that never came, or came too late to count."""
        self.sender: tuple[str, int] | None = None
        self.sequence = NO_MOTION
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise DeviceError(f"udp:{host}:{port}: cannot listen ({one_line(error)})") from error
        self._socket.settimeout(0.1)
        self.address: tuple[str, int] = self._socket.getsockname()
        self.name = f"udp:{self.address[0]}:{self.address[1]}"
        self._ended = False
        self._thread = threading.Thread(target=self._listen, name="motion", daemon=True)
        self._thread.start()

    def poll(self, now_s: float) -> list[MotionSample | Tap | MixWeights]:
        """Return what has come since the last call."""
        found = []
        while self._waiting:
            found.append(self._waiting.popleft())
        return found

    def send(self, packet: bytes, to: tuple[str, int]) -> None:
        """Send from this port, so that the answer comes from where the question went."""
        self._socket.sendto(packet, to)

    def close(self) -> None:
        """Stop listening."""
        self._ended = True
        self._thread.join(1.0)
        self._socket.close()

    def facts(self) -> dict[str, Any]:
        """Return what was not understood, what overflowed and what never came."""
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
            except (TimeoutError, ConnectionError):  # Windows tells here of blocks that nobody took
                continue
            except OSError:
                return
            found = parse(packet, self._clock())
            if found is None:
                self.not_understood += 1
                continue
            if sender != self.sender:
                self.sender, self.sequence = sender, NO_MOTION
            for one in found:
                self._count(one.sequence)
                if len(self._waiting) == WAITING:
                    self.overflowed += 1
                self._waiting.append(one.message)

    def _count(self, sequence: int) -> None:
        if self.sequence != NO_MOTION:
            step = (sequence - self.sequence) & NO_MOTION
            if step == 0 or step > 1 << 31:  # older than the newest: the finger drops it by its time
                return
            self.missing += step - 1
        self.sequence = sequence


class NetworkBlocks:
    """Blocks to a game engine: to a fixed address, or to whoever sends the motion.

    Parameters
    ----------
    form : {"osc", "udp"}
    rate : float, Hz
    to : tuple of str and int, optional
        Host and port; by default where the motion comes from.
    motion : NetworkMotion, optional
        Where the motion comes from; its port is sent from.

    Raises
    ------
    MissingExtraError
        If the form is osc and python-osc is not installed.
    DeviceError
        If the host is not known.
    """

    def __init__(
        self,
        form: Form,
        *,
        rate: float,
        to: tuple[str, int] | None = None,
        motion: NetworkMotion | None = None,
    ) -> None:
        if form not in ("osc", "udp"):
            raise ParameterError(f"form must be osc or udp, got {form!r}")
        if to is None and motion is None:
            raise ParameterError(
                "blocks need an address to go to where the motion does not come from the network"
            )
        if form == "osc":
            imported("pythonosc", extra="devices", what="OSC")
        self._write = block_message if form == "osc" else block_packet
        self._rate, self._motion = rate, motion
        # Once, and not with every block: a name server may take seconds.
        self._to = None if to is None else _resolved(to)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._sequence = 0
        self._first = 0
        self.sent = 0
        self.unsent = 0
        """Blocks for which there was no address yet, or which the network did not take."""

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
            if self._motion is not None:
                self._motion.send(self._write(block), to)
            else:
                self._socket.sendto(self._write(block), to)
            self.sent += 1
        except OSError:
            self.unsent += 1

    def close(self) -> None:
        """Let go of the port."""
        self._socket.close()


def _resolved(to: tuple[str, int]) -> tuple[str, int]:
    try:
        found = socket.getaddrinfo(*to, family=socket.AF_INET, type=socket.SOCK_DGRAM)
    except OSError as error:
        raise DeviceError(f"udp:{to[0]}:{to[1]}: the host is not known ({one_line(error)})") from error
    host, port = found[0][4][:2]
    return str(host), int(port)


def parse_address(text: str, *, default_port: int = PORT) -> tuple[str, int]:
    """Return host and port of ``"HOST:PORT"``, ``"HOST"`` or ``":PORT"``.

    Raises
    ------
    ParameterError
        If the port is no port.
    """
    host, _, port = text.rpartition(":") if ":" in text else (text, "", str(default_port))
    if not (port.isdigit() and 0 <= int(port) < 1 << 16):
        raise ParameterError(f"address must be HOST:PORT with a port below 65536, got {text!r}")
    return host or "127.0.0.1", int(port)

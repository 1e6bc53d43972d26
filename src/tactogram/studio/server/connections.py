"""Connections to the server: how many there may be, how long each may take, and which gives way to another.

uvicorn's own limit answers everybody with 503 once there are too many connections, so that idle ones shut people out.
Here one that nobody waits for is closed instead.
"""

from __future__ import annotations

import asyncio
import functools
import logging
import ssl
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from socket import socket
from typing import Any, Protocol

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

MOST_FILES = 8192
"""Open files that a process asks the system for: connections, and what the studio reads."""
MOST_WRITTEN = 64 * 1024
"""Bytes of an answer that wait for the other side. Where more do, a quarter of it has to be reached in time."""


@dataclass(frozen=True)
class ConnectionLimits:
    """Limits of connections.

    Parameters
    ----------
    connections : int
        At once, without websockets, which need the token. A tablet takes up to six.
    handshake_s : float
        For the beginning of TLS, and for its end.
    head_s : float
        For the head of a request, from its first byte on; of the first one from the connection on.
    idle_s : float
        Between requests. People think longer than uvicorn's 5 s.
    write_s : float
        For 48 KiB of an answer to be taken.
    """

    connections: int = 512
    handshake_s: float = 10.0
    head_s: float = 10.0
    idle_s: int = 65
    write_s: float = 60.0


class _Deadline:
    """Something that is done unless it is ended in time."""

    def __init__(self, loop: asyncio.AbstractEventLoop, seconds: float, then: Callable[[], None]) -> None:
        self._loop, self._seconds, self._then = loop, seconds, then
        self._handle: asyncio.TimerHandle | None = None

    def begin(self) -> None:
        """Begin, unless it was begun."""
        if self._handle is None:
            self._handle = self._loop.call_later(self._seconds, self._then)

    def end(self) -> None:
        """End, in time."""
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None


class SlotHolder(Protocol):
    """Holder of a connection slot."""

    sender: str
    since: float

    @property
    def waits(self) -> bool:
        """Whether it is the other side's turn: to ask, or to send the rest of what it asks."""

    @property
    def asked(self) -> bool:
        """Whether anything was asked on it, to the end."""

    def abort(self) -> None:
        """Hang up at once."""


@dataclass(eq=False)
class PendingConnection:
    """A connection before its handshake is over."""

    sender: str
    since: float
    task: asyncio.Task[None]
    waits: bool = True
    asked: bool = False

    def abort(self) -> None:
        """Hang up at once."""
        self.task.cancel()


class Connection(H11Protocol):
    """A connection that ends by itself where its other side is too slow."""

    def __init__(
        self, *args: Any, sender: str, limits: ConnectionLimits, among: set[SlotHolder], **kwargs: Any
    ) -> None:
        super().__init__(*args, **kwargs)
        self.sender, self.among = sender, among
        self.since = self.loop.time()
        self._head = _Deadline(self.loop, limits.head_s, self.abort)
        self._write = _Deadline(self.loop, limits.write_s, self.abort)

    @property
    def waits(self) -> bool:
        """Whether it is the other side's turn: to ask, or to send the rest of what it asks."""
        return bool(self.cycle.more_body) if self._asks else not self.flow.write_paused

    @property
    def asked(self) -> bool:
        """Whether anything was asked on it, to the end."""
        return self.cycle is not None and not self.cycle.more_body

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin."""
        super().connection_made(transport)
        transport.set_write_buffer_limits(MOST_WRITTEN)  # over TLS, asyncio would hold eight times that
        self.among.add(self)
        self._head.begin()

    def connection_lost(self, exc: Exception | None) -> None:
        """End."""
        self._left()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Take what came; a head that has begun has to end in time, however slowly it drips."""
        self._head.begin()
        super().data_received(data)
        if self._asks:
            self._head.end()

    def on_response_complete(self) -> None:
        """Wait for the next request."""
        self.since = self.loop.time()
        self._head.end()
        super().on_response_complete()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand over to a websocket, which has limits of its own."""
        self._left()
        super().handle_websocket_upgrade(event)

    def pause_writing(self) -> None:
        """Wait until the other side takes what was written, but not for ever."""
        super().pause_writing()
        self._write.begin()

    def resume_writing(self) -> None:
        """Go on writing."""
        self._write.end()
        super().resume_writing()

    def abort(self) -> None:
        """Hang up at once."""
        self._left()
        self.transport.abort()

    @property
    def _asks(self) -> bool:
        """Whether a request's head is through, and its answer is not."""
        return self.cycle is not None and not self.cycle.response_complete

    def _left(self) -> None:
        self.among.discard(self)
        self._head.end()
        self._write.end()


class Websocket(WebSocketsSansIOProtocol):
    """A websocket that also ends while its other side is closing it.

    uvicorn's sends a close frame then, too, which its protocol refuses; the exception would end the server.
    """

    def shutdown(self) -> None:
        """Close it; abort the connection where it is being closed already, as nothing more can be said on it."""
        if self.transport.is_closing():
            self.transport.abort()
        else:
            super().shutdown()


def gives_way(held: set[SlotHolder]) -> list[SlotHolder]:
    """Return the connections that are closed where there are too many.

    They are of the sender with the most that wait for it: first those on which nothing was asked yet, then those that
    have waited longest. An eighth of them, so that of many that come at once not each is weighed against all. Where all
    are being answered it is the newest.
    """
    waiting = [one for one in held if one.waits]
    if not waiting:
        return [max(held, key=lambda one: one.since)]
    ((sender, count),) = Counter(one.sender for one in waiting).most_common(1)
    theirs = sorted((one for one in waiting if one.sender == sender), key=lambda one: (one.asked, one.since))
    return theirs[: max(1, count // 8)]


class LimitedServer(uvicorn.Server):
    """uvicorn, with limits that are kept on connections.

    Parameters
    ----------
    app : ASGI application
    listener : socket
    context : ssl.SSLContext, optional
    limits : Limits
    ready : callable
        Called when it answers.
    options
        Others of `uvicorn.Config`.
    """

    def __init__(
        self,
        app: Any,
        listener: socket,
        *,
        context: ssl.SSLContext | None = None,
        limits: ConnectionLimits | None = None,
        ready: Callable[[], None] = lambda: None,
        **options: Any,
    ) -> None:
        self.listener, self.context, self.ready = listener, context, ready
        self.limits = limits or ConnectionLimits()
        self._held: set[SlotHolder] = set()
        config = uvicorn.Config(
            app,
            log_level="warning",
            access_log=False,  # tickets and the token stand in addresses
            server_header=False,
            http=Connection,  # of h11: httptools takes headers without end
            ws=Websocket,
            timeout_keep_alive=self.limits.idle_s,
            timeout_graceful_shutdown=2,
            **options,
        )
        super().__init__(config)

    def serve_until_ended(self) -> None:
        """Serve until it is interrupted or told to exit."""
        with suppress(KeyboardInterrupt):  # the usual way to end it
            self.run(sockets=[self.listener])

    async def startup(self, sockets: Sequence[socket] | None = None) -> None:
        """Begin to take connections."""
        await super().startup(sockets=[])
        self.listener.setblocking(False)
        self.listener.listen(self.config.backlog)
        self._accepting = asyncio.get_running_loop().create_task(self._accept())
        self.ready()

    async def shutdown(self, sockets: list[socket] | None = None) -> None:
        """End, without waiting for whose turn it is: over TLS, a tablet that sleeps does not say that it hung up."""
        self._accepting.cancel()
        for one in list(self._held):
            if one.waits:
                one.abort()
        # What is not answered in time is cancelled, and uvicorn would tell it as an error. Real ones are the guard's.
        logging.getLogger("uvicorn.error").setLevel(logging.CRITICAL)
        await super().shutdown(sockets)

    async def _accept(self) -> None:
        """Give each that comes a place. asyncio's own servers do not say who is still shaking hands."""
        loop = asyncio.get_running_loop()
        while True:
            try:
                accepted, address = await loop.sock_accept(self.listener)
            except OSError:  # gone again, or no file is left
                await asyncio.sleep(0.05)
                continue
            if len(self._held) >= self.limits.connections:
                for one in gives_way(self._held):
                    one.abort()
            sender = str(address[0])
            task = loop.create_task(self._connect(accepted, sender))
            arriving = PendingConnection(sender, loop.time(), task)
            self._held.add(arriving)
            task.add_done_callback(functools.partial(self._arrived, arriving))
            await asyncio.sleep(0)  # others have their turn, however many come

    async def _connect(self, accepted: socket, sender: str) -> None:
        def connection() -> Connection:
            return Connection(
                self.config,
                self.server_state,
                self.lifespan.state,
                sender=sender,
                limits=self.limits,
                among=self._held,
            )

        handshake_s = None if self.context is None else self.limits.handshake_s
        with suppress(OSError):  # no handshake, or none in time
            await asyncio.get_running_loop().connect_accepted_socket(
                connection,
                accepted,
                ssl=self.context,
                ssl_handshake_timeout=handshake_s,
                ssl_shutdown_timeout=handshake_s,  # until then asyncio goes on taking what comes
            )

    def _arrived(self, arriving: PendingConnection, task: asyncio.Task[None]) -> None:
        self._held.discard(arriving)


def limits_here() -> ConnectionLimits:
    """Return the limits, and let this process have the files open that they take, where the system allows it.

    macOS gives 256, which 50 tablets use up. Where no more can be had, half of them are for connections.
    """
    limits = ConnectionLimits()
    try:
        import resource
    except ImportError:  # Windows, which has no such limit
        return limits
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = MOST_FILES if hard == resource.RLIM_INFINITY else min(MOST_FILES, hard)
    if soft != resource.RLIM_INFINITY and soft < most:
        with suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft == resource.RLIM_INFINITY:
        return limits
    return replace(limits, connections=min(limits.connections, soft // 2))

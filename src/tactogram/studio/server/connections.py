"""Connections to the server: limits on their number and duration, and which one is closed when there are too many.

uvicorn's own limit answers everybody with 503 once there are too many connections, so that idle ones lock people out.
Here an idle one is closed instead.
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
from typing import Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

MOST_FILES = 8192
"""Open files that the process requests from the system, for connections and for reading."""
MOST_BUFFERED = 64 * 1024
"""Unsent bytes of a response; above, writing pauses until only a quarter is left, within ``write_s``."""


@dataclass(frozen=True)
class ConnectionLimits:
    """Limits of connections; websockets, which need the token or a ticket, do not count.

    A tablet opens up to six. ``handshake_s`` is for the start and the end of TLS, ``head_s`` for the head of a request
    from its first byte (of the first request, from the connection), ``idle_s`` between requests (people think longer
    than uvicorn's 5 s), ``write_s`` for the client to accept 48 KiB of a response.
    """

    connections: int = 512
    handshake_s: float = 10.0
    head_s: float = 10.0
    idle_s: int = 65
    write_s: float = 60.0


class _Deadline:
    """Calls ``then`` unless it is cancelled in time."""

    def __init__(self, loop: asyncio.AbstractEventLoop, seconds: float, then: Callable[[], None]) -> None:
        self._loop, self._seconds, self._then = loop, seconds, then
        self._handle: asyncio.TimerHandle | None = None

    def start(self) -> None:
        if self._handle is None:
            self._handle = self._loop.call_later(self._seconds, self._then)

    def cancel(self) -> None:
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None


@dataclass(eq=False)
class PendingConnection:
    """A connection before its handshake is over."""

    sender: str
    since: float
    task: asyncio.Task[None]
    idle: bool = True
    served: bool = False

    def abort(self) -> None:
        """Close the connection immediately."""
        self.task.cancel()


class Connection(H11Protocol):
    """A connection that closes itself if the client is too slow."""

    def __init__(
        self, *args: Any, sender: str, limits: ConnectionLimits, slots: set[AnyConnection], **kwargs: Any
    ) -> None:
        super().__init__(*args, **kwargs)
        self.sender, self.slots = sender, slots
        self.since = self.loop.time()
        self._head = _Deadline(self.loop, limits.head_s, self.abort)
        self._write = _Deadline(self.loop, limits.write_s, self.abort)

    @property
    def idle(self) -> bool:
        """Whether the server waits for the client: for a request, or the rest of one."""
        return bool(self.cycle.more_body) if self._in_request else not self.flow.write_paused

    @property
    def served(self) -> bool:
        """Whether a complete request came."""
        return self.cycle is not None and not self.cycle.more_body

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a slot."""
        super().connection_made(transport)
        transport.set_write_buffer_limits(MOST_BUFFERED)  # over TLS, asyncio would buffer eight times that
        self.slots.add(self)
        self._head.start()

    def connection_lost(self, exc: Exception | None) -> None:
        """Release the slot."""
        self._release()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Read data; the head of a request must be complete in time, however slowly it comes."""
        self._head.start()
        super().data_received(data)
        if self._in_request:
            self._head.cancel()

    def on_response_complete(self) -> None:
        """Wait for the next request."""
        self.since = self.loop.time()
        self._head.cancel()
        super().on_response_complete()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Release the slot: a websocket has limits of its own."""
        self._release()
        super().handle_websocket_upgrade(event)

    def pause_writing(self) -> None:
        """Wait until the client accepts the data, for a limited time."""
        super().pause_writing()
        self._write.start()

    def resume_writing(self) -> None:
        """Resume writing."""
        self._write.cancel()
        super().resume_writing()

    def abort(self) -> None:
        """Close the connection immediately."""
        self._release()
        self.transport.abort()

    @property
    def _in_request(self) -> bool:
        """Whether the head of a request is complete and its response is not."""
        return self.cycle is not None and not self.cycle.response_complete

    def _release(self) -> None:
        self.slots.discard(self)
        self._head.cancel()
        self._write.cancel()


class Websocket(WebSocketsSansIOProtocol):
    """A websocket that can shut down while the client is closing it.

    uvicorn's would send a close frame then, which its protocol refuses; the exception would end the server.
    """

    def shutdown(self) -> None:
        """Close the websocket, or abort its connection if that is closing already."""
        if self.transport.is_closing():
            self.transport.abort()
        else:
            super().shutdown()


AnyConnection = PendingConnection | Connection


def connections_to_close(slots: set[AnyConnection]) -> list[AnyConnection]:
    """Return the connections to close when there are too many.

    They belong to the sender with the most idle ones: first those without a request, then those that have been idle
    longest. An eighth at once, so that a flood of connections does not compare each with all others. If none is idle,
    the newest.
    """
    idle = [one for one in slots if one.idle]
    if not idle:
        return [max(slots, key=lambda one: one.since)]
    ((sender, count),) = Counter(one.sender for one in idle).most_common(1)
    candidates = sorted(
        (one for one in idle if one.sender == sender), key=lambda one: (one.served, one.since)
    )
    return candidates[: max(1, count // 8)]


class LimitedServer(uvicorn.Server):
    """uvicorn with limits on connections; ``options`` go to `uvicorn.Config`."""

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
        self._slots: set[AnyConnection] = set()
        config = uvicorn.Config(
            app,
            log_level="warning",
            access_log=False,  # addresses hold tickets and the token
            server_header=False,
            http=Connection,  # h11: httptools accepts headers of any length
            ws=Websocket,
            timeout_keep_alive=self.limits.idle_s,
            timeout_graceful_shutdown=2,
            **options,
        )
        super().__init__(config)

    def serve_until_ended(self) -> None:
        """Serve until interrupted or `should_exit` is set."""
        with suppress(KeyboardInterrupt):  # the usual way to stop it
            self.run(sockets=[self.listener])

    async def startup(self, sockets: Sequence[socket] | None = None) -> None:
        """Accept connections."""
        await super().startup(sockets=[])
        self.listener.setblocking(False)
        self.listener.listen(self.config.backlog)
        self._accepting = asyncio.get_running_loop().create_task(self._accept())
        self.ready()

    async def shutdown(self, sockets: list[socket] | None = None) -> None:
        """Stop without waiting for idle connections: over TLS, a sleeping tablet does not announce its end."""
        self._accepting.cancel()
        for one in list(self._slots):
            if one.idle:
                one.abort()
        # uvicorn logs requests that it cancels as errors; real errors are logged by the guard.
        logging.getLogger("uvicorn.error").setLevel(logging.CRITICAL)
        await super().shutdown(sockets)

    async def _accept(self) -> None:
        """Accept connections and give each a slot; asyncio's own servers do not expose pending handshakes."""
        loop = asyncio.get_running_loop()
        while True:
            try:
                accepted, address = await loop.sock_accept(self.listener)
            except OSError:  # disconnected again, or no file descriptor is left
                await asyncio.sleep(0.05)
                continue
            if len(self._slots) >= self.limits.connections:
                for one in connections_to_close(self._slots):
                    one.abort()
            sender = str(address[0])
            task = loop.create_task(self._connect(accepted, sender))
            pending = PendingConnection(sender, loop.time(), task)
            self._slots.add(pending)
            task.add_done_callback(functools.partial(self._connected, pending))
            await asyncio.sleep(0)  # lets other tasks run, however many connections come

    async def _connect(self, accepted: socket, sender: str) -> None:
        def connection() -> Connection:
            return Connection(
                self.config,
                self.server_state,
                self.lifespan.state,
                sender=sender,
                limits=self.limits,
                slots=self._slots,
            )

        handshake_s = None if self.context is None else self.limits.handshake_s
        with suppress(OSError):  # no handshake in time
            await asyncio.get_running_loop().connect_accepted_socket(
                connection,
                accepted,
                ssl=self.context,
                ssl_handshake_timeout=handshake_s,
                ssl_shutdown_timeout=handshake_s,  # until then asyncio keeps reading
            )

    def _connected(self, pending: PendingConnection, task: asyncio.Task[None]) -> None:
        self._slots.discard(pending)


def system_limits() -> ConnectionLimits:
    """Return the limits for this machine, after raising the process's limit of open files as far as possible.

    macOS allows 256, which 50 tablets exhaust. At most half of the files are for connections.
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

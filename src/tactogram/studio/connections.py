"""Connections to the server: how many there may be, how long each may take, and which gives way to another.

uvicorn's own limit answers everybody with 503 once there are too many connections, so that idle ones shut people out.
Here one that nobody waits for is closed instead.
"""

from __future__ import annotations

import asyncio
import ssl
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from socket import socket
from typing import Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

MOST_FILES = 8192
"""Open files that a process asks the system for: connections, and what the studio reads."""


@dataclass(frozen=True)
class Limits:
    """What connections are held to.

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


class Connection(H11Protocol):
    """A connection that ends by itself where its other side is too slow."""

    def __init__(self, *args: Any, limits: Limits, among: set[Connection], **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.limits, self.among = limits, among
        self.since = self.loop.time()
        self._head = _Deadline(self.loop, limits.head_s, self.abort)
        self._write = _Deadline(self.loop, limits.write_s, self.abort)

    @property
    def waits(self) -> bool:
        """Whether nothing is being answered on it."""
        return self.cycle is None or (self.cycle.response_complete and not self.flow.write_paused)

    @property
    def asked(self) -> bool:
        """Whether anything was asked on it."""
        return self.cycle is not None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin, in the place of another where there are too many."""
        super().connection_made(transport)
        self.among.add(self)
        self._head.begin()
        if len(self.among) > self.limits.connections:
            gives_way(self.among).abort()

    def connection_lost(self, exc: Exception | None) -> None:
        """End."""
        self._left()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Take what came; a head that has begun has to end in time, however slowly it drips."""
        self._head.begin()
        super().data_received(data)
        if not self.waits:
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

    def _left(self) -> None:
        self.among.discard(self)
        self._head.end()
        self._write.end()


def gives_way(connections: set[Connection]) -> Connection:
    """Return the connection that is closed first where there are too many.

    One that waits before one that is answered, from the sender with the most that wait, one on which nothing was asked
    yet, the one that has waited longest. Where all are being answered it is the newest.
    """
    waiting = [one for one in connections if one.waits]
    if not waiting:
        return max(connections, key=lambda one: one.since)
    of = Counter(_sender(one) for one in waiting)
    return min(waiting, key=lambda one: (-of[_sender(one)], one.asked, one.since))


class Server(uvicorn.Server):
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
        limits: Limits | None = None,
        ready: Callable[[], None] = lambda: None,
        **options: Any,
    ) -> None:
        self.listener, self.context, self.ready = listener, context, ready
        self.limits = limits or Limits()
        config = uvicorn.Config(
            app,
            log_level="warning",
            access_log=False,  # tickets and the token stand in addresses
            server_header=False,
            http=Connection,  # of h11: httptools takes headers without end
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
        """Begin to listen, with a time limit for TLS, which uvicorn has none for."""
        await super().startup(sockets=[])
        among: set[Connection] = set()

        def connection() -> Connection:
            return Connection(
                self.config, self.server_state, self.lifespan.state, limits=self.limits, among=among
            )

        handshake_s = None if self.context is None else self.limits.handshake_s
        server = await asyncio.get_running_loop().create_server(
            connection,
            sock=self.listener,
            backlog=self.config.backlog,
            ssl=self.context,
            ssl_handshake_timeout=handshake_s,
            ssl_shutdown_timeout=handshake_s,  # until then asyncio goes on taking what comes
        )
        self.servers.append(server)
        self.ready()


def more_files() -> None:
    """Let this process have more files open, where the system allows it: macOS gives 256, which 50 tablets use up."""
    try:
        import resource
    except ImportError:  # Windows, which has no such limit
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = MOST_FILES if hard == resource.RLIM_INFINITY else min(MOST_FILES, hard)
    if soft != resource.RLIM_INFINITY and soft < most:
        with suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))


def _sender(connection: Connection) -> str:
    return connection.client[0] if connection.client else ""

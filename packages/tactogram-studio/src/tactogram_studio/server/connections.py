"""Server of the guarded application: uvicorn, with limits on the number of connections and on waiting for clients."""

from __future__ import annotations

import logging
import ssl
import time
from collections.abc import Callable
from contextlib import suppress
from socket import socket
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

MOST_FILES = 8192
"""Open files that the process requests from the system, for connections and for reading."""
MOST_CONNECTIONS = 2048
"""Including websockets; above, requests are answered with 503. A tablet opens up to six."""
MOST_MESSAGE_BYTES = 4 * 2**20
"""Of a websocket message."""
HEAD_S, IDLE_S, WRITE_S = 10.0, 65, 60.0
"""Longest wait for a connection's first request, between requests, and while a client accepts nothing of a response."""


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


class StudioServer(uvicorn.Server):
    """uvicorn that aborts connections whose client keeps it waiting; ``options`` go to `uvicorn.Config`."""

    def __init__(
        self,
        app: Any,
        listener: socket,
        *,
        context: ssl.SSLContext | None = None,
        ready: Callable[[], None] = lambda: None,
        head_s: float = HEAD_S,
        write_s: float = WRITE_S,
        **options: Any,
    ) -> None:
        self.listener, self.ready = listener, ready
        self.head_s, self.write_s = head_s, write_s
        self._waiting: dict[tuple[object, ...], float] = {}
        config = uvicorn.Config(
            app,
            log_level="warning",
            access_log=False,  # addresses hold tickets and the token
            server_header=False,
            http="h11",  # httptools accepts headers of any length
            ws=Websocket,
            ws_max_size=MOST_MESSAGE_BYTES,
            limit_concurrency=most_connections(),
            timeout_keep_alive=IDLE_S,
            timeout_graceful_shutdown=2,
            ssl_context_factory=None if context is None else lambda config, default: context,
            **options,
        )
        super().__init__(config)

    def serve_until_ended(self) -> None:
        """Serve until interrupted or `should_exit` is set."""
        with suppress(KeyboardInterrupt):  # the usual way to stop it
            self.run()

    async def startup(self, sockets: list[socket] | None = None) -> None:
        """Accept connections."""
        await super().startup([self.listener])
        self.ready()

    async def on_tick(self, counter: int) -> bool:
        """Abort the connections whose client has kept the server waiting for too long."""
        now = time.monotonic()
        waiting: dict[tuple[object, ...], float] = {}
        for one in self.server_state.connections:
            if not isinstance(one, H11Protocol):  # a websocket, which needed the token or a ticket
                continue
            if unsent := one.transport.get_write_buffer_size():
                most = self.write_s
            elif one.cycle is None or one.cycle.response_complete:
                most = self.head_s if one.cycle is None else IDLE_S + self.head_s
            else:
                continue
            state = (one, one.cycle, unsent)
            waiting[state] = self._waiting.get(state, now)
            if now - waiting[state] > most:
                one.transport.abort()
        self._waiting = waiting
        return await super().on_tick(counter)

    async def shutdown(self, sockets: list[socket] | None = None) -> None:
        """Stop without waiting for clients: over TLS, a sleeping tablet does not announce its end."""
        for one in list(self.server_state.connections):
            if isinstance(one, H11Protocol) and (
                one.cycle is None or one.cycle.response_complete or one.cycle.more_body
            ):
                one.transport.abort()
        # uvicorn logs requests that it cancels as errors; real errors are logged by the guard.
        logging.getLogger("uvicorn.error").setLevel(logging.CRITICAL)
        await super().shutdown(sockets)


def most_connections() -> int:
    """Return the limit of connections here, after raising the process's limit of open files as far as possible.

    macOS allows 256, which 50 tablets exhaust. At most half of the files are for connections.
    """
    try:
        import resource
    except ImportError:  # Windows, which has no such limit
        return MOST_CONNECTIONS
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = MOST_FILES if hard == resource.RLIM_INFINITY else min(MOST_FILES, hard)
    if soft != resource.RLIM_INFINITY and soft < most:
        with suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return MOST_CONNECTIONS if soft == resource.RLIM_INFINITY else min(MOST_CONNECTIONS, soft // 2)

"""Server of the guarded application: uvicorn, with the limits that it offers, and an end that waits for nobody."""

from __future__ import annotations

import ssl
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
IDLE_S = 65
"""Longest wait between the requests of a connection."""


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
    """uvicorn over TLS with a context, which ends without waiting for clients; ``options`` as of `uvicorn.Config`."""

    def __init__(self, app: Any, *, context: ssl.SSLContext | None = None, **options: Any) -> None:
        config = uvicorn.Config(
            app,
            log_level="critical",  # the guard logs errors; uvicorn those, too, of requests that it cancels at the end
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

    async def shutdown(self, sockets: list[socket] | None = None) -> None:
        """Stop without waiting for clients: over TLS, a sleeping tablet does not announce its end."""
        for one in list(self.server_state.connections):
            if isinstance(one, H11Protocol) and (
                one.cycle is None or one.cycle.response_complete or one.cycle.more_body
            ):
                one.transport.abort()
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

import asyncio
import socket

import pytest

from tactogram_studio.server.listening import (
    MOST_CONNECTIONS,
    MOST_FILES,
    StudioServer,
    most_connections,
)

UPGRADE = (
    b"GET / HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
CLOSE = bytes([0x88, 0x82, 0, 0, 0, 0, 0x03, 0xE8])  # mserved, 1000


def test_the_server_ends_while_a_websocket_is_closing():
    heard = []

    async def sends_much(scope, receive, send):
        heard.append((await receive())["type"])
        await send({"type": "websocket.accept"})
        # More than the system holds for a client that does not read, so that the connection stays until it does.
        await send({"type": "websocket.send", "bytes": bytes(2**25)})
        client.sendall(CLOSE)
        heard.append((await receive())["type"])
        server.should_exit = True  # as Ctrl-C does

    with socket.create_server(("127.0.0.1", 0)) as listener, socket.socket() as client:
        server = StudioServer(sends_much, lifespan="off")
        client.connect(listener.getsockname())
        client.sendall(UPGRADE)
        asyncio.run(server.serve([listener]))
    assert heard == ["websocket.connect", "websocket.disconnect"]
    assert not server.server_state.connections


def test_connections_leave_files_to_the_rest(monkeypatch):
    resource = pytest.importorskip("resource")
    has = [256, 400]
    monkeypatch.setattr(resource, "getrlimit", lambda which: tuple(has))
    monkeypatch.setattr(resource, "setrlimit", lambda which, limits: has.__setitem__(0, limits[0]))
    assert (most_connections(), has) == (200, [400, 400])
    has[:] = [256, 10_000]
    assert (most_connections(), has) == (MOST_CONNECTIONS, [MOST_FILES, 10_000])
    has[:] = [256, resource.RLIM_INFINITY]
    assert (most_connections(), has[0]) == (MOST_CONNECTIONS, MOST_FILES)
    has[:] = [resource.RLIM_INFINITY] * 2
    assert (most_connections(), has[0]) == (MOST_CONNECTIONS, resource.RLIM_INFINITY)

import asyncio
import socket
from dataclasses import dataclass
from unittest.mock import Mock

import pytest
import uvicorn
from uvicorn.server import ServerState

from tactogram.studio.server.connections import (
    MOST_BUFFERED,
    MOST_FILES,
    Connection,
    ConnectionLimits,
    LimitedServer,
    connections_to_close,
    system_limits,
)


@dataclass(frozen=True)
class Held:
    """A connection as far as the choice of one to close needs it."""

    name: str
    sender: str = "a"
    idle: bool = True
    served: bool = True
    since: float = 0.0


MANY = [Held(f"x{n}", served=n % 2 == 0, since=-n) for n in range(24)]


@pytest.mark.parametrize(
    ("held", "first"),
    [
        # Who has waited longest, of those that wait.
        ([Held("new", since=3), Held("old", since=1), Held("busy", idle=False)], ["old"]),
        # One on which nothing was served, before one between two answers.
        ([Held("person", since=1), Held("idle", served=False, since=2)], ["idle"]),
        # One of the sender's with the most, whoever came first.
        ([Held("person", "b", since=0), Held("x", since=1), Held("y", since=2)], ["x"]),
        ([Held("person", "", served=False), Held("x", since=1), Held("y", since=2)], ["x"]),
        # An eighth of many.
        ([Held("person", "b", served=False, since=-99), *MANY], ["x23", "x21", "x19"]),
        # All are answered: the newest.
        ([Held("person", idle=False, since=1), Held("new", idle=False, since=2)], ["new"]),
    ],
)
def test_which_connections_are_closed(held, first):
    assert [one.name for one in connections_to_close(set(held))] == first


async def answers_later(scope, receive, send):
    while (await receive()).get("more_body"):
        pass
    await asyncio.sleep(0)
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"0")]})
    await send({"type": "http.response.body", "body": b""})


def test_a_connection_idle_while_it_is_the_other_side_s_turn():
    async def states():
        found, held = [], set()
        config = uvicorn.Config(answers_later, lifespan="off", access_log=False, log_level="warning")
        one = Connection(config, ServerState(), {}, sender="a", limits=ConnectionLimits(), slots=held)
        transport = Mock(spec=asyncio.Transport, **{"is_closing.return_value": False})
        one.connection_made(transport)
        transport.set_write_buffer_limits.assert_called_once_with(MOST_BUFFERED)
        for piece in (b"POST / HT", b"TP/1.1\r\nHost: a\r\nContent-Length: 2\r\n\r\n{", b"}"):
            found.append((one.idle, one.served))
            one.data_received(piece)
        found.append((one.idle, one.served))
        while not transport.write.called:
            await asyncio.sleep(0)
        found.append((one.idle, one.served))
        one.abort()
        return found, held

    found, held = asyncio.run(states())
    # Nothing, half a head, half a body, all of it, and after the answer.
    assert found == [(True, False), (True, False), (True, False), (False, True), (True, True)]
    assert held == set()


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
        server = LimitedServer(
            sends_much,
            listener,
            ready=lambda: (client.connect(listener.getsockname()), client.sendall(UPGRADE)),
            lifespan="off",
        )
        asyncio.run(server.serve())
    assert heard == ["websocket.connect", "websocket.disconnect"]
    assert not server.server_state.connections


def test_connections_leave_files_to_the_rest(monkeypatch):
    resource = pytest.importorskip("resource")
    has = [256, 400]
    monkeypatch.setattr(resource, "getrlimit", lambda which: tuple(has))
    monkeypatch.setattr(resource, "setrlimit", lambda which, limits: has.__setitem__(0, limits[0]))
    assert (system_limits().connections, has) == (200, [400, 400])
    has[:] = [256, 10_000]
    assert (system_limits().connections, has) == (512, [MOST_FILES, 10_000])
    has[:] = [256, resource.RLIM_INFINITY]
    assert (system_limits().connections, has[0]) == (512, MOST_FILES)
    has[:] = [resource.RLIM_INFINITY] * 2
    assert (system_limits().connections, has[0]) == (512, resource.RLIM_INFINITY)

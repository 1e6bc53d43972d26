import asyncio
import ipaddress
import re
import socket
from urllib.parse import unquote

import pytest

from tactogram.errors import DeviceError, ParameterError
from tactogram_studio.server import listening as module
from tactogram_studio.server.certificates import self_signed_certificate
from tactogram_studio.server.listening import (
    MOST_CONNECTIONS,
    MOST_FILES,
    ListeningPort,
    StudioServer,
    addresses,
    is_loopback,
    most_connections,
    open_port,
    svg_qr_code,
    terminal_qr_code,
)

NUMBERS = ("192.0.2.7", "198.51.100.7")


UPGRADE = (
    b"GET / HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)


CLOSE = bytes([0x88, 0x82, 0, 0, 0, 0, 0x03, 0xE8])  # mserved, 1000


segno = pytest.importorskip("segno")


ADDRESS = "https://192.0.2.7:8123/join/abcdefghijklmnopqrstuv"


@pytest.fixture
def lan(monkeypatch):
    """Make this machine have two addresses, one more of IPv6, and a name."""
    monkeypatch.setattr(
        module, "addresses", lambda *, ipv6=False: (*NUMBERS, *(["2001:db8::7"] if ipv6 else []))
    )
    monkeypatch.setattr(module, "_host_names", lambda: ("lab-pc", "lab-pc.example"))


@pytest.fixture
def listener():
    """Give a socket that listens."""
    with socket.create_server(("127.0.0.1", 0)) as opened:
        yield opened


def test_on_loopback_it_is_reached_from_this_machine_alone():
    with open_port(port=0) as port:
        assert (port.loopback, port.https) == (True, False)
        assert port.roots == (port.here,) == (f"http://127.0.0.1:{port.port}",)
        assert set(port.names) == {"127.0.0.1", "localhost", "::1"}
        with socket.create_connection(("127.0.0.1", port.port)):
            pass
    assert port.socket.fileno() == -1  # given back


def test_behind_a_proxy_loopback_is_reached_from_elsewhere():
    with open_port(port=0, proxies=("192.0.2.0/24", "::1")) as port:
        assert (port.loopback, port.proxies) == (False, ("192.0.2.0/24", "::1"))
    for proxy in ("*", "proxy.example", "192.0.2.1/24"):
        with (
            pytest.raises(ParameterError, match="proxies must be addresses"),
            open_port(port=0, proxies=(proxy,)),
        ):
            pass


def test_everywhere_others_are_given_numbers_and_this_machine_its_own(listener, lan):
    number = listener.getsockname()[1]
    port = ListeningPort(listener, "0.0.0.0")
    assert port.roots == tuple(f"http://{one}:{number}" for one in NUMBERS)
    assert port.here == f"http://127.0.0.1:{number}"
    assert {*NUMBERS, "lab-pc", "lab-pc.example", "localhost"} <= set(port.names)
    assert ListeningPort(listener, "::", https=True).roots[-1] == f"https://[2001:db8::7]:{number}"
    one = ListeningPort(listener, NUMBERS[1])
    assert one.roots == (one.here,) == (f"http://{NUMBERS[1]}:{number}",)
    assert NUMBERS[0] not in one.names


def test_without_a_network_others_are_given_the_name(listener, lan, monkeypatch):
    monkeypatch.setattr(module, "addresses", lambda *, ipv6=False: ())
    assert ListeningPort(listener, "0.0.0.0").roots == (f"http://lab-pc:{listener.getsockname()[1]}",)


def test_https_has_a_certificate_for_all_names_which_is_kept(listener, lan, tmp_path):
    port = ListeningPort(listener, "0.0.0.0", https=True)
    secured = port.with_certificate(tmp_path)
    assert set(secured.certificate.names) == set(port.names)
    assert secured.roots == port.roots == tuple(f"https://{one}:{port.port}" for one in NUMBERS)
    assert port.with_certificate(tmp_path).certificate == secured.certificate
    assert ListeningPort(listener, "0.0.0.0").with_certificate(tmp_path).certificate is None


def test_a_laboratory_s_certificate_says_by_which_names_it_is_reached(lan, tmp_path):
    file = self_signed_certificate(tmp_path / "own.pem", ["touch.lab.example", NUMBERS[1]]).file
    with open_port("0.0.0.0", 0, certificate=file) as port:
        assert port.https
        assert port.roots == tuple(f"https://{one}:{port.port}" for one in ("touch.lab.example", NUMBERS[1]))
        assert port.here == port.roots[0]
        assert "touch.lab.example" in port.names
        assert port.with_certificate(tmp_path / "none") == port
    assert not (tmp_path / "none").exists()
    with pytest.raises(ParameterError, match="key needs certificate"), open_port(port=0, key=file):
        pytest.fail("listened")


@pytest.mark.parametrize(
    ("host", "port", "kind", "told"),
    [
        ("203.0.113.9", 0, DeviceError, "address of this machine: .*127.0.0.1"),
        ("", 0, ParameterError, "host must be a name or address of this machine, got nothing"),
        ("127.0.0.1", 65536, ParameterError, "port must be 0 to 65535, got 65536"),
        ("127.0.0.1", -1, ParameterError, "port must be 0 to 65535, got -1"),
    ],
)
def test_where_nothing_can_be_listened_on_it_is_told_in_a_line(host, port, kind, told):
    with pytest.raises(kind, match=told) as caught, open_port(host, port):
        pytest.fail("listened")
    assert "\n" not in str(caught.value)


def test_a_name_that_nobody_knows_is_told(monkeypatch):
    def unknown(*args, **kwargs):
        raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")

    monkeypatch.setattr("socket.getaddrinfo", unknown)
    with pytest.raises(DeviceError, match="host lab-pd: unknown name"), open_port("lab-pd", 0):
        pytest.fail("listened")


def resolving(monkeypatch, *found):
    """Let every name stand for these addresses, as /etc/hosts may."""
    entries = [(socket.AF_INET, socket.SOCK_STREAM, 6, "", (address, 0)) for address in found]
    monkeypatch.setattr("socket.getaddrinfo", lambda *args, **kwargs: entries)


def test_a_name_that_is_loopback_here_is_told_with_what_others_reach(lan, monkeypatch):
    resolving(monkeypatch, "127.0.1.1")  # Debian's /etc/hosts
    told = (
        "host lab-pc: this name stands for 127.0.1.1 here, which other machines cannot reach; for them use 0.0.0.0 or "
        "an address of this machine (192.0.2.7, 198.51.100.7), for this machine alone 127.0.0.1"
    )
    with pytest.raises(DeviceError) as caught, open_port("lab-pc", 0):
        pytest.fail("listened")
    assert str(caught.value) == told


def test_of_several_addresses_of_a_name_one_that_others_reach_is_listened_on(monkeypatch):
    resolving(monkeypatch, "127.0.1.1", "192.0.2.7")
    monkeypatch.setattr("socket.create_server", lambda place, **kwargs: place)
    assert module._listener("lab-pc", 8123) == ("192.0.2.7", 8123)


def test_localhost_is_this_machine_alone_whatever_the_name_stands_for_here(monkeypatch):
    resolving(monkeypatch, "192.0.2.7")
    monkeypatch.setattr("socket.create_server", lambda place, **kwargs: place)
    assert module._listener("localhost", 8123) == ("127.0.0.1", 8123)  # no token is asked for there


def test_another_number_of_loopback_is_loopback_too(listener):
    port = ListeningPort(listener, "127.0.0.2")
    assert port.loopback
    assert port.roots == (port.here,) == (f"http://127.0.0.2:{port.port}",)
    assert "127.0.0.2" in port.names


@pytest.mark.parametrize(
    ("host", "alone"),
    [
        *(("localhost", True), ("127.0.0.1", True), ("127.0.1.1", True), ("::1", True)),
        *(("0.0.0.0", False), ("::", False), ("192.0.2.7", False), ("lab-pc", False), ("", False)),
    ],
)
def test_what_is_reached_from_this_machine_alone_is_known(host, alone):
    assert is_loopback(host) is alone


def test_a_taken_port_is_told(listener):
    number = listener.getsockname()[1]
    for host in ("127.0.0.1", "0.0.0.0"):
        with (
            pytest.raises(DeviceError, match=f"cannot listen on port {number} of {host} "),
            open_port(host, number),
        ):
            pytest.fail("listened")


def test_addresses_of_this_machine_are_no_loopback_and_each_is_there_once():
    found = addresses(ipv6=True)
    assert len(set(found)) == len(found)
    assert found[: len(addresses())] == addresses()
    for one in found:
        number = ipaddress.ip_address(one)
        assert not any((number.is_loopback, number.is_link_local, number.is_unspecified))
    assert {ipaddress.ip_address(one).version for one in addresses()} <= {4}


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


def test_the_terminal_shows_the_modules_that_the_code_has():
    drawn = terminal_qr_code(ADDRESS, 80)
    lines = [re.fullmatch("\x1b\\[40;97m([█▀▄ ]+)\x1b\\[0m", line)[1] for line in drawn.splitlines()]
    light = []
    for line in lines:
        light += [[c in "█▀" for c in line], [c in "█▄" for c in line]]
    expected = [[not dark for dark in row] for row in segno.make_qr(ADDRESS, error="l").matrix_iter(border=4)]
    assert light[: len(expected)] == expected


def test_where_a_terminal_is_too_narrow_there_is_none():
    width = len(terminal_qr_code(ADDRESS, 80).splitlines()[0]) - len("\x1b[40;97m\x1b[0m")
    assert terminal_qr_code(ADDRESS, width)
    assert terminal_qr_code(ADDRESS, width - 1) == ""


def test_the_picture_is_dark_on_light_and_asks_no_other_host():
    kind, _, data = svg_qr_code(ADDRESS).partition(",")
    svg = unquote(data)
    assert kind.startswith("data:image/svg+xml")
    assert ("fill='#fff'" in svg, "stroke='#000'" in svg) == (True, True)
    assert re.findall("https?://[^'\"]*", svg) == ["http://www.w3.org/2000/svg"]

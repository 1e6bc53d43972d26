"""Server: a bound port, the addresses that lead to it, their QR codes, and uvicorn with limits of its own."""

from __future__ import annotations

import errno
import io
import ipaddress
import os
import socket
import ssl
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import psutil
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from tactogram.errors import DeviceError, ParameterError
from tactogram.extras import imported
from tactogram_studio.server.certificates import Certificate, load_certificate, self_signed_certificate

LOCALHOST = "localhost"
LOOPBACK = ("127.0.0.1", LOCALHOST, "::1")
EVERYWHERE = ("0.0.0.0", "::")
CERTIFICATE = "https.pem"
_BLACK_AND_WHITE, _RESET = "\x1b[40;97m", "\x1b[0m"
MOST_FILES = 8192
"""Open files that the process requests from the system, for connections and for reading."""
MOST_CONNECTIONS = 2048
"""Including websockets; above, requests are answered with 503. A tablet opens up to six."""
MOST_MESSAGE_BYTES = 4 * 2**20
"""Of a websocket message."""
IDLE_S = 65
"""Longest wait between the requests of a connection."""


@dataclass(frozen=True)
class ListeningPort:
    """A bound port of the ``host`` that the user chose; `with_certificate` adds a certificate for ``https``.

    Of ``proxies``, addresses or networks, the headers that name a client's address and scheme are believed.
    """

    socket: socket.socket
    host: str = "127.0.0.1"
    https: bool = False
    certificate: Certificate | None = None
    proxies: tuple[str, ...] = ()

    @property
    def port(self) -> int:
        """Port number, also if the system chose it."""
        return int(self.socket.getsockname()[1])

    @property
    def loopback(self) -> bool:
        """Whether only this machine can connect; a proxy connects for others."""
        return is_loopback(self.host) and not self.proxies

    @property
    def names(self) -> tuple[str, ...]:
        """All names and addresses that lead here."""
        if self.loopback:
            return tuple(dict.fromkeys((self.host, *LOOPBACK)))
        return tuple(dict.fromkeys((*self._certified_names, *self._addresses, *_host_names(), *LOOPBACK)))

    @property
    def roots(self) -> tuple[str, ...]:
        """Beginnings of addresses for other machines, such as ``https://192.0.2.7:8123``, the best first.

        A laboratory's certificate names the hosts; without one they are numeric: tablets can rarely look up a name.
        """
        return tuple(
            self._root(name) for name in self._certified_names or self._addresses or _host_names()[:1]
        )

    @property
    def here(self) -> str:
        """Beginning of addresses for a browser on this machine, which trusts loopback without encryption, too."""
        if self.host in EVERYWHERE and not self._certified_names:
            return self._root(LOOPBACK[0])
        return self.roots[0]

    def with_certificate(self, folder: Path) -> ListeningPort:
        """Return the port with a certificate if it needs one: self-signed, stored in ``folder``."""
        if not self.https or self.certificate is not None:
            return self
        return replace(self, certificate=self_signed_certificate(folder / CERTIFICATE, self.names))

    @property
    def _certified_names(self) -> tuple[str, ...]:
        if self.certificate is None or self.certificate.self_signed or self.loopback:
            return ()
        return self.certificate.names

    @property
    def _addresses(self) -> tuple[str, ...]:
        return addresses(ipv6=self.host == "::") if self.host in EVERYWHERE else (self.host,)

    def _root(self, name: str) -> str:
        shown = f"[{name}]" if ":" in name else name
        return f"{'https' if self.https else 'http'}://{shown}:{self.port}"


@contextmanager
def open_port(
    host: str = "127.0.0.1",
    port: int = 8123,
    *,
    https: bool = False,
    certificate: Path | str | None = None,
    key: Path | str | None = None,
    proxies: tuple[str, ...] | None = None,
) -> Iterator[ListeningPort]:
    """Bind a port of this machine and release it at the end; port 0 lets the system choose.

    Host ``0.0.0.0`` or ``::`` stands for all addresses. A certificate of the laboratory's own implies ``https``; by
    default its key is in the same file.

    Raises `DeviceError` if the port is taken, or the host is not this machine's or cannot be reached from others;
    `ParameterError` if ``host``, ``port`` or ``proxies`` are invalid, or a key has no certificate; `DataError` if
    certificate and key cannot be used.
    """
    if key is not None and certificate is None:
        raise ParameterError("key needs certificate, got only key; give both")
    for proxy in proxies or ():
        try:
            ipaddress.ip_network(proxy)
        except ValueError:
            raise ParameterError.must(
                "proxies", "be addresses or networks, such as 192.0.2.7", proxy
            ) from None
    if https:  # before anything starts
        imported("cryptography", extra="studio", what="certificates")
    loaded = None if certificate is None else load_certificate(Path(certificate), Path(key or certificate))
    with _listener(host, port) as listener:
        yield ListeningPort(listener, host, https or loaded is not None, loaded, tuple(proxies or ()))


def addresses(*, ipv6: bool = False) -> tuple[str, ...]:
    """Return the addresses by which other machines may reach this one, the likeliest first, IPv6 last."""
    families = [socket.AF_INET, socket.AF_INET6] if ipv6 else [socket.AF_INET]
    up = {name for name, stats in psutil.net_if_stats().items() if stats.isup}
    return tuple(
        dict.fromkeys(
            address
            for family in families
            for address in (
                *_outgoing_address(family),
                *sorted(
                    entry.address
                    for name, entries in psutil.net_if_addrs().items()
                    for entry in entries
                    if name in up and entry.family == family
                ),
            )
            if _reaches_others(address)
        )
    )


def _outgoing_address(family: socket.AddressFamily) -> tuple[str, ...]:
    """Return the address from which this machine sends to others; connecting a datagram socket sends nothing."""
    # Addresses for documentation: RFC 5737, 3849.
    elsewhere = "192.0.2.1" if family == socket.AF_INET else "2001:db8::1"
    with suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as datagrams:
        datagrams.connect((elsewhere, 9))
        return (str(datagrams.getsockname()[0]),)
    return ()


def _reaches_others(address: str) -> bool:
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return False
    # Link-local IPv6 addresses need a zone, which browsers do not accept.
    return not (parsed.is_loopback or parsed.is_link_local or parsed.is_unspecified)


def _host_names() -> tuple[str, str]:
    return socket.gethostname(), socket.getfqdn()


def _listener(host: str, port: int) -> socket.socket:
    if not 0 <= port <= 65535:
        raise ParameterError.must("port", "be 0 to 65535", port)
    if not host:
        raise ParameterError.must("host", "be a name or address of this machine, got nothing")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    address = _address(host, family)
    both = host == "::" and socket.has_dualstack_ipv6()
    try:
        return socket.create_server((address, port), family=family, dualstack_ipv6=both)
    except OSError as error:
        failure = f"cannot listen on port {port} of {host} ({os.strerror(error.errno or 0)})"
        if error.errno == errno.EADDRNOTAVAIL:
            known = ", ".join((*addresses(ipv6=family == socket.AF_INET6), LOOPBACK[0]))
            raise DeviceError(f"{failure}: use an address of this machine: {known}") from None
        raise DeviceError(f"{failure}: use another port, or 0 for a free one") from None


def _address(host: str, family: socket.AddressFamily) -> str:
    """Return the address of a host name, preferably one that other machines reach.

    Debian maps the machine's own name to ``127.0.1.1`` in /etc/hosts. A user who names it means its network address,
    and only they know which. ``localhost`` is always this machine alone (RFC 6761, section 6.3), since it needs no
    token.
    """
    if host == LOCALHOST:
        return LOOPBACK[0]
    try:
        entries = socket.getaddrinfo(host, None, family=family, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError):
        raise DeviceError(f"host {host}: unknown name; use an address of this machine") from None
    resolved = [str(entry[4][0]) for entry in entries]
    address = next((candidate for candidate in resolved if not is_loopback(candidate)), resolved[0])
    if is_loopback(address) and host != address:
        others = ", ".join(addresses(ipv6=family == socket.AF_INET6)) or "none at present"
        raise DeviceError(
            f"host {host}: this name stands for {address} here, which other machines cannot reach; for them use "
            f"{EVERYWHERE[0]} or an address of this machine ({others}), for this machine alone {LOOPBACK[0]}"
        )
    return address


def is_loopback(host: str) -> bool:
    """Return whether a name or address can be reached from this machine only."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == LOCALHOST


def svg_qr_code(address: str) -> str:
    """Return a QR code as an SVG data URI for the ``src`` of an ``img``."""
    segno = imported("segno", extra="studio", what="QR codes")
    return str(segno.make_qr(address, error="m").svg_data_uri(scale=4, light="#fff"))


def terminal_qr_code(address: str, columns: int) -> str:
    """Return a QR code of half blocks, dark on light in any colour scheme; "" if wider than ``columns``."""
    segno = imported("segno", extra="studio", what="QR codes")
    # Low error correction: each level makes the code larger, and a screen has no scratches.
    code = segno.make_qr(address, error="l")
    if code.symbol_size()[0] > columns:
        return ""
    drawn = io.StringIO()
    code.terminal(drawn, compact=True)
    return "\n".join(f"{_BLACK_AND_WHITE}{line}{_RESET}" for line in drawn.getvalue().splitlines())


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
    """uvicorn over TLS with a context, which ends without waiting for clients; ``options`` as of `uvicorn.Config`.

    Headers that state another address or scheme are believed of ``proxies`` only, whatever FORWARDED_ALLOW_IPS says.
    """

    def __init__(
        self,
        app: Any,
        *,
        context: ssl.SSLContext | None = None,
        proxies: tuple[str, ...] = (),
        **options: Any,
    ) -> None:
        config = uvicorn.Config(
            app,
            log_level="critical",  # the guard logs errors; uvicorn those, too, of requests that it cancels at the end
            access_log=False,  # addresses hold tickets and the token
            server_header=False,
            proxy_headers=bool(proxies),
            forwarded_allow_ips=list(proxies),
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

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Stop without waiting for clients: over TLS, a sleeping tablet does not announce its end."""
        for connection in list(self.server_state.connections):
            if isinstance(connection, H11Protocol) and (
                connection.cycle is None or connection.cycle.response_complete or connection.cycle.more_body
            ):
                connection.transport.abort()
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

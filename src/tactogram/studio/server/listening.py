"""Listening port of a server, bound before anything starts, and the addresses that lead to it."""

from __future__ import annotations

import errno
import ipaddress
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import psutil

from tactogram.errors import DeviceError, ParameterError
from tactogram.extras import imported
from tactogram.studio.server.certificates import Certificate, given_certificate, kept_certificate

LOCALHOST = "localhost"
LOOPBACK = ("127.0.0.1", LOCALHOST, "::1")
EVERYWHERE = ("0.0.0.0", "::")
CERTIFICATE = "https.pem"


@dataclass(frozen=True)
class ListeningPort:
    """A port that is listened on.

    Parameters
    ----------
    socket : socket.socket
        Bound and listening.
    host : str
        As it was asked for.
    https : bool
        Whether connections are encrypted.
    certificate : Certificate, optional
        What is shown then; `with_certificate` makes one where the laboratory gave none.
    """

    socket: socket.socket
    host: str = "127.0.0.1"
    https: bool = False
    certificate: Certificate | None = None

    @property
    def port(self) -> int:
        """The port, also where a free one was asked for."""
        return int(self.socket.getsockname()[1])

    @property
    def loopback(self) -> bool:
        """Whether it is reached from this machine alone."""
        return is_loopback(self.host)

    @property
    def names(self) -> tuple[str, ...]:
        """All names and addresses that lead here."""
        if self.loopback:
            return tuple(dict.fromkeys((self.host, *LOOPBACK)))
        return tuple(dict.fromkeys((*self._given, *self._reached, *_named(), *LOOPBACK)))

    @property
    def roots(self) -> tuple[str, ...]:
        """How addresses begin, ``https://192.0.2.7:8123``, for people on other machines; the best first.

        A laboratory's certificate says by which names it holds. Without one they are numbers: names that a tablet can
        look up are rare.
        """
        return tuple(self._root(name) for name in self._given or self._reached or _named()[:1])

    @property
    def here(self) -> str:
        """How addresses begin for a browser on this machine. There a page is trusted without encryption, too."""
        if self.host in EVERYWHERE and not self._given:
            return self._root(LOOPBACK[0])
        return self.roots[0]

    def with_certificate(self, folder: Path) -> ListeningPort:
        """Return it with a certificate where it needs one: the one that is kept in ``folder``, or a new one."""
        if not self.https or self.certificate is not None:
            return self
        return replace(self, certificate=kept_certificate(folder / CERTIFICATE, self.names))

    @property
    def _given(self) -> tuple[str, ...]:
        if self.certificate is None or self.certificate.own or self.loopback:
            return ()
        return self.certificate.names

    @property
    def _reached(self) -> tuple[str, ...]:
        return addresses(ipv6=self.host == "::") if self.host in EVERYWHERE else (self.host,)

    def _root(self, name: str) -> str:
        shown = f"[{name}]" if ":" in name else name
        return f"{'https' if self.https else 'http'}://{shown}:{self.port}"


@contextmanager
def listening(
    host: str = "127.0.0.1",
    port: int = 8123,
    *,
    https: bool = False,
    certificate: Path | str | None = None,
    key: Path | str | None = None,
) -> Iterator[ListeningPort]:
    """Take a port, and give it back at the end.

    Parameters
    ----------
    host : str
        A name or address of this machine; ``0.0.0.0`` or ``::`` for all.
    port : int
        0 takes a free one.
    https : bool
        Whether connections are encrypted; they are in any case with a certificate.
    certificate, key : path, optional
        A laboratory's own, as PEM.

    Raises
    ------
    DeviceError
        If the port is taken, the host is not this machine's, or it is a name by which no other machine finds it.
    ParameterError
        If certificate and key cannot be used.
    """
    if key is not None and certificate is None:
        raise ParameterError("--key belongs to --certificate; give both")
    if https:  # before anything is begun
        imported("cryptography", extra="studio", what="certificates")
    own = None if certificate is None else given_certificate(Path(certificate), Path(key or certificate))
    with _listener(host, port) as listener:
        yield ListeningPort(listener, host, https or own is not None, own)


def addresses(*, ipv6: bool = False) -> tuple[str, ...]:
    """Return the addresses of this machine that others may reach it by, the likeliest first. Nothing is sent.

    Parameters
    ----------
    ipv6 : bool
        Whether those of IPv6 come, too, after the others.
    """
    families = [socket.AF_INET, socket.AF_INET6] if ipv6 else [socket.AF_INET]
    up = {name for name, facts in psutil.net_if_stats().items() if facts.isup}
    return tuple(
        dict.fromkeys(
            address
            for family in families
            for address in (
                *_towards_others(family),
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


def _towards_others(family: socket.AddressFamily) -> tuple[str, ...]:
    """Return from which address this machine would send to others; connecting a datagram socket sends nothing."""
    # Addresses for documentation: RFC 5737, 3849.
    elsewhere = "192.0.2.1" if family == socket.AF_INET else "2001:db8::1"
    with suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as asked:
        asked.connect((elsewhere, 9))
        return (str(asked.getsockname()[0]),)
    return ()


def _reaches_others(address: str) -> bool:
    try:
        found = ipaddress.ip_address(address)
    except ValueError:
        return False
    # Link-local ones of IPv6 need a zone, which browsers do not take.
    return not (found.is_loopback or found.is_link_local or found.is_unspecified)


def _named() -> tuple[str, str]:
    return socket.gethostname(), socket.getfqdn()


def _listener(host: str, port: int) -> socket.socket:
    if not 0 <= port <= 65535:
        raise ParameterError(f"--port must be 0 to 65535, got {port}")
    if not host:
        raise ParameterError("--host must be a name or address of this machine, got nothing")
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    address = _address(host, family)
    both = host == "::" and socket.has_dualstack_ipv6()
    try:
        return socket.create_server((address, port), family=family, dualstack_ipv6=both)
    except OSError as error:
        what, why = f"port {port} of {host} cannot be listened on", os.strerror(error.errno or 0)
        if error.errno == errno.EADDRNOTAVAIL:
            known = ", ".join((*addresses(ipv6=family == socket.AF_INET6), LOOPBACK[0]))
            raise DeviceError(f"{what} ({why}): give an address of this machine: {known}") from None
        raise DeviceError(f"{what} ({why}): give another --port, or 0 for a free one") from None


def _address(host: str, family: socket.AddressFamily) -> str:
    """Return which address a host stands for: of several, one that others reach.

    Debian writes ``127.0.1.1 NAME`` into /etc/hosts. Who asks for the name means its address on the network; which one
    that is, and whether all of them are meant, only they know. ``localhost`` is this machine alone, whatever
    /etc/hosts says (RFC 6761, section 6.3): no token is asked for there.
    """
    if host == LOCALHOST:
        return LOOPBACK[0]
    try:
        entries = socket.getaddrinfo(host, None, family=family, type=socket.SOCK_STREAM)
    except (OSError, UnicodeError):
        raise DeviceError(f"--host {host}: no such name is known; give an address of this machine") from None
    found = [str(entry[4][0]) for entry in entries]
    address = next((one for one in found if not is_loopback(one)), found[0])
    if is_loopback(address) and host != address:
        others = ", ".join(addresses(ipv6=family == socket.AF_INET6)) or "no address of its own at present"
        raise DeviceError(
            f"--host {host}: that name stands for {address} here, which no other machine reaches: for others give "
            f"{EVERYWHERE[0]}, or an address of this machine ({others}); for this machine alone {LOOPBACK[0]}"
        )
    return address


def is_loopback(host: str) -> bool:
    """Return whether a name or address is reached from this machine alone."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == LOCALHOST

"""Rules of the request guard: pure functions of an ASGI scope and the guard's settings.

Host header against DNS rebinding, Origin and Sec-Fetch-Site against forged requests of other pages, as
https://cheatsheetseries.owasp.org describes them; sizes before anything is read.
"""

from __future__ import annotations

import hmac
import ipaddress
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qsl, quote, urlencode, urlsplit

from starlette.requests import cookie_parser

from tactogram.errors import ParameterError

Scope = Mapping[str, Any]

COOKIE = "tactogram_token"
"""Over https with ``__Host-`` before it: browsers take such a cookie from no answer that came without (RFC 6265bis)."""
METHODS = ("GET", "HEAD", "POST")
LONGEST_PATH = 2048
MOST_HEADER_BYTES = 32 * 1024
KIB, MIB = 2**10, 2**20
PARTICIPANTS = ("/join/", "/take/", "/participants/")
"""What begins so is for participants: a ticket stands in for the token, and their pages get the strict policy."""

_HOST = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9._-]+)(?::([0-9]{1,5}))?")
_LOOPBACK = ("localhost", "127.0.0.1", "::1")


@dataclass(frozen=True)
class GuardSettings:
    """Settings of the request guard.

    Parameters
    ----------
    loopback : bool
        Whether the server is reached from this machine only.
    token : str, optional
        What a browser has to know; needed where it is not.
    hosts : tuple of str
        Names by which the server is reached beyond loopback. Addresses need none: no name can be bound to another
        address where none is used.
    open_to_all : tuple of str
        Beginnings of paths that need no token.
    bodies : tuple of (str, int)
        Most bytes of a body by the beginning of its path; the first that fits counts.
    body : int
        Most bytes of any other body.
    message : int
        Most bytes of a message through a websocket.
    body_seconds : float
        For each piece of a body; a sender that stalls is sent away.
    body_rate : float
        Bytes per second; less than that on the whole, beyond the first ``body_seconds``, is stalling, too.

    Raises
    ------
    ParameterError
        If the server is reached from elsewhere and there is no token, or one that can be guessed.
    """

    loopback: bool = True
    token: str | None = None
    hosts: tuple[str, ...] = ()
    open_to_all: tuple[str, ...] = (*PARTICIPANTS, "/static/")
    bodies: tuple[tuple[str, int], ...] = (
        *((path, 64 * KIB) for path in PARTICIPANTS),
        ("/_nicegui/client/", 512 * MIB),
    )
    body: int = MIB
    message: int = 4 * MIB
    body_seconds: float = 20.0
    body_rate: float = float(KIB)

    def __post_init__(self) -> None:
        if not self.loopback and self.token is None:
            raise ParameterError("a server beyond loopback needs a token, got none; draw one and print it")
        if self.token is not None and len(self.token) < 16:
            raise ParameterError(f"a token must have at least 16 characters, got {len(self.token)}")

    def most_bytes(self, path: str) -> int:
        """Return how long a body sent to ``path`` may be."""
        return next((most for start, most in self.bodies if path.startswith(start)), self.body)


@dataclass(frozen=True)
class Refusal:
    """An HTTP status, and one sentence: what was expected, what came, what to do."""

    status: int
    sentence: str


def refusal(scope: Scope, settings: GuardSettings) -> Refusal | None:
    """Return why a request is refused before its body is read; None lets it through to the token's check."""
    return (
        malformed(scope)
        or foreign_host(scope, settings)
        or wrong_method(scope)
        or foreign_origin(scope)
        or too_long(scope, settings)
    )


def malformed(scope: Scope) -> Refusal | None:
    """Refuse paths with control characters or ``..``, long ones, and piles of headers."""
    path = str(scope["path"])
    if len(path) + len(scope.get("query_string", b"")) > LONGEST_PATH:
        return Refusal(414, f"An address must have at most {LONGEST_PATH} characters; shorten it.")
    if any(ord(c) < 32 or ord(c) == 127 for c in path) or "\\" in path or ".." in path.split("/"):
        return Refusal(400, "An address holds no control characters, backslashes or '..'; correct it.")
    if sum(len(name) + len(value) for name, value in scope["headers"]) > MOST_HEADER_BYTES:
        return Refusal(
            431, f"Headers must have at most {MOST_HEADER_BYTES} bytes; clear this site's cookies."
        )
    return None


def foreign_host(scope: Scope, settings: GuardSettings) -> Refusal | None:
    """Refuse a Host header that is not this server's: a name of another that was bound to this address."""
    hosts = headers(scope, "host")
    found = _HOST.fullmatch(hosts[0]) if len(hosts) == 1 else None
    if found is None:
        return Refusal(400, "A request must say exactly one host; send one Host header.")
    name = _name(found[1])
    if name in _LOOPBACK or _is_loopback(name):
        return None
    if not settings.loopback and (_is_address(name) or name in {_name(host) for host in settings.hosts}):
        return None
    return Refusal(421, f"This server is not called {name[:100]}; open the address that the command printed.")


def wrong_method(scope: Scope) -> Refusal | None:
    """Refuse every method but those that are used; what overrides a method is not looked at."""
    if scope["type"] == "http" and scope["method"] not in METHODS:
        return Refusal(
            405, f"The method must be one of {', '.join(METHODS)}, got {str(scope['method'])[:20]}."
        )
    return None


def foreign_origin(scope: Scope) -> Refusal | None:
    """Refuse what another site's page sends: everything but following a link to a page.

    A request without Origin and Sec-Fetch-Site is no browser's, and carries no cookie that the sender lacks.
    """
    refused = Refusal(403, "This was sent by a page of another site; open the page here and do it there.")
    reads = scope["type"] == "http" and scope["method"] in ("GET", "HEAD")
    site = header(scope, "sec-fetch-site")
    if site not in (None, "same-origin", "none"):
        follows = (
            header(scope, "sec-fetch-mode") == "navigate" and header(scope, "sec-fetch-dest") == "document"
        )
        if not (reads and follows):
            return refused
    origins = headers(scope, "origin")
    if origins and not reads:
        host, secure = header(scope, "host") or "", is_secure(scope)
        if not (len(origins) == 1 and is_own(origins[0], host, secure=secure)):
            return refused
    return None


def is_secure(scope: Scope) -> bool:
    """Return whether a request came over https, or a websocket over wss."""
    return scope.get("scheme") in ("https", "wss")


def is_own(origin: str, host: str, *, secure: bool = False) -> bool:
    """Return whether an Origin header is that of the host that was asked.

    Parameters
    ----------
    origin, host : str
        Headers.
    secure : bool
        Whether it was asked over https: a page of this host that came without is another site then. The other way round
        a proxy stands between that speaks https to browsers and http to this server.
    """
    try:
        parts = urlsplit(origin)
        port = parts.port
    except ValueError:
        return False
    usual = {"https": 443}.get(parts.scheme) if secure else {"http": 80, "https": 443}.get(parts.scheme)
    asked = _HOST.fullmatch(host)
    if usual is None or asked is None or not parts.hostname:
        return False
    same_port = (port or usual) == (int(asked[2]) if asked[2] else usual)
    return same_port and _name(parts.hostname) == _name(asked[1])


def too_long(scope: Scope, settings: GuardSettings) -> Refusal | None:
    """Refuse a body that is announced as longer than its path takes, or in two ways at once."""
    lengths = headers(scope, "content-length")
    if not lengths:
        return None
    if (
        len(set(lengths)) > 1
        or headers(scope, "transfer-encoding")
        or not re.fullmatch("[0-9]{1,18}", lengths[0])
    ):
        return Refusal(400, "A body must say its length once, as a whole number; send it again.")
    return body_refusal(scope, settings) if int(lengths[0]) > settings.most_bytes(scope["path"]) else None


def body_refusal(scope: Scope, settings: GuardSettings) -> Refusal:
    """Return what is said of a body that is too long."""
    most = settings.most_bytes(scope["path"])
    told = f"{most // MIB} MiB" if most >= MIB else f"{most // KIB} KiB"
    return Refusal(413, f"At most {told} can be sent here; send less, or cut it.")


def needs_token(scope: Scope, settings: GuardSettings) -> bool:
    """Return whether a request has to show the token, and does not."""
    if settings.token is None or str(scope["path"]).startswith(settings.open_to_all):
        return False
    cookies = (cookie_parser(text) for text in headers(scope, "cookie"))
    return not any(is_token(found.get(cookie_name(scope), ""), settings) for found in cookies)


def cookie_name(scope: Scope) -> str:
    """Return the name of the cookie that holds the token."""
    return f"__Host-{COOKIE}" if is_secure(scope) else COOKIE


def is_token(text: str, settings: GuardSettings) -> bool:
    """Return whether ``text`` is the token, in the same time whatever it is."""
    return hmac.compare_digest(text.encode(), (settings.token or "").encode()) and settings.token is not None


def token_in_query(scope: Scope) -> tuple[str, str] | None:
    """Return the token that stands in an address, and the address without it; None where none stands."""
    pairs = parse_qsl(scope.get("query_string", b"").decode("latin-1"), keep_blank_values=True)
    tokens = [value for name, value in pairs if name == "token"]
    if len(tokens) != 1:
        return None
    rest = urlencode([(name, value) for name, value in pairs if name != "token"])
    # One slash: a path that begins with two would be another host.
    path = "/" + quote(str(scope["path"]).lstrip("/"))
    return tokens[0], path + (f"?{rest}" if rest else "")


def header(scope: Scope, name: str) -> str | None:
    """Return the first header of a name."""
    return next(iter(headers(scope, name)), None)


def headers(scope: Scope, name: str) -> list[str]:
    """Return all headers of a name."""
    wanted = name.encode()
    return [value.decode("latin-1") for key, value in scope["headers"] if key.lower() == wanted]


def _name(host: str) -> str:
    return host.strip("[]").rstrip(".").lower()


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _is_loopback(name: str) -> bool:
    return _is_address(name) and ipaddress.ip_address(name).is_loopback

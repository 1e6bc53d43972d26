"""Rules of the request guard: pure functions of an ASGI scope and the guard's settings.

The Host header is checked against DNS rebinding, Origin and Sec-Fetch-Site against forged requests from other sites
(https://cheatsheetseries.owasp.org); sizes are checked before a body is read.
"""

from __future__ import annotations

import hmac
import ipaddress
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qsl, quote, unquote, urlencode, urlsplit

from starlette.datastructures import Headers
from starlette.requests import cookie_parser

from tactogram.errors import ParameterError

Scope = Mapping[str, Any]

COOKIE = "tactogram_token"
"""Prefixed with ``__Host-`` over https: browsers accept such a cookie over encrypted connections only (RFC 6265bis)."""
METHODS = ("GET", "HEAD", "POST")
KIB, MIB = 2**10, 2**20
PARTICIPANTS = ("/join/", "/take/", "/participants/", "/feel/")
"""Prefixes of participants' paths, and of files felt on a phone: these need a ticket instead of the token and get the
strict policy."""

RECEIVED = "/materials/received"
"""Path that takes folders of recordings."""

LONGEST_NAME = 255
"""Bytes of a name in a path, as in most file systems."""
_CONTROL = re.compile(r"[\0-\x1f\x7f\ud800-\udfff]")
_HOST = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9._-]+)(?::([0-9]{1,5}))?")
_OTHER_SITE = "This request comes from a page of another site; open the page here and do it there."


@dataclass(frozen=True)
class GuardSettings:
    """Settings of the request guard.

    Raises `ParameterError` if the server is reached from elsewhere without a token, or the token can be guessed.

    Parameters
    ----------
    loopback : bool
        Whether the server is reached from this machine only.
    token : str, optional
        Secret that a browser must present; required unless ``loopback``.
    hosts : tuple of str
        Names of the server beyond loopback. IP addresses are always accepted: DNS rebinding needs a name.
    open_to_all : tuple of str
        Prefixes of paths that need no token.
    path_bytes : tuple of (str, int)
        Largest body by path prefix; the first match counts.
    body_bytes : int
        Largest other body.
    body_seconds : float
        Longest wait for each chunk of a body, s.
    body_rate : float
        Least average rate of a body after the first ``body_seconds``, bytes/s.
    """

    loopback: bool = True
    token: str | None = None
    hosts: tuple[str, ...] = ()
    open_to_all: tuple[str, ...] = (*PARTICIPANTS, "/static/")
    path_bytes: tuple[tuple[str, int], ...] = (
        *((path, 64 * KIB) for path in PARTICIPANTS),
        ("/_nicegui/client/", 512 * MIB),
        (RECEIVED, 520 * MIB),  # with the names of the files
    )
    body_bytes: int = MIB
    body_seconds: float = 20.0
    body_rate: float = float(KIB)

    def __post_init__(self) -> None:
        if not self.loopback and self.token is None:
            raise ParameterError("a server beyond loopback needs a token, got none; create one and print it")
        if self.token is not None and len(self.token) < 16:
            raise ParameterError(f"a token must have at least 16 characters, got {len(self.token)}")

    def most_bytes(self, path: str) -> int:
        """Return the largest body that ``path`` accepts."""
        return next((most for start, most in self.path_bytes if path.startswith(start)), self.body_bytes)


@dataclass(frozen=True)
class Refusal:
    """HTTP status, and one sentence: what was expected, what came, what to do."""

    status: int
    sentence: str


def refusal(scope: Scope, settings: GuardSettings) -> Refusal | None:
    """Return why a request is refused before its body is read, or None; the token is checked separately."""
    return (
        _foreign_host(scope, settings)
        or _wrong_method(scope)
        or _wrong_address(scope)
        or _foreign_origin(scope)
        or _too_long(scope, settings)
    )


def _foreign_host(scope: Scope, settings: GuardSettings) -> Refusal | None:
    """Refuse a name that is not this server's: another site's name could be bound to this address."""
    hosts = _headers(scope).getlist("host")
    match = _HOST.fullmatch(hosts[0]) if len(hosts) == 1 else None
    if match is None:
        return Refusal(400, "A request must name exactly one host; send one Host header.")
    name = _name(match[1])
    try:
        address = ipaddress.ip_address(name)
    except ValueError:
        address = None
    if name == "localhost" or (address is not None and address.is_loopback):
        return None
    if not settings.loopback and (address is not None or name in map(_name, settings.hosts)):
        return None
    return Refusal(421, f"This server is not called {name[:100]}; open the address that the command printed.")


def _wrong_method(scope: Scope) -> Refusal | None:
    if scope["type"] == "http" and scope["method"] not in METHODS:
        return Refusal(
            405, f"The method must be one of {', '.join(METHODS)}, got {str(scope['method'])[:20]}."
        )
    return None


def _wrong_address(scope: Scope) -> Refusal | None:
    """Refuse characters and lengths that no name of a file, study or page has; routes need not expect them."""
    path, query = str(scope["path"]), scope.get("query_string", b"").decode("latin-1")
    if _CONTROL.search(path + unquote(query)):
        return Refusal(400, "An address must not hold control characters; remove them.")
    if (longest := max(len(part.encode(errors="replace")) for part in path.split("/"))) > LONGEST_NAME:
        return Refusal(400, f"A name in an address must have at most {LONGEST_NAME} bytes, got {longest}.")
    return None


def _foreign_origin(scope: Scope) -> Refusal | None:
    """Refuse what another site's page sends, except following a link to a page.

    A request without Origin and Sec-Fetch-Site is not from a browser, and carries no cookie that the sender lacks.
    """
    headers = _headers(scope)
    reads = scope["type"] == "http" and scope["method"] in ("GET", "HEAD")
    if headers.get("sec-fetch-site") not in (None, "same-origin", "none"):
        navigates = headers.get("sec-fetch-mode") == "navigate"
        if not (reads and navigates and headers.get("sec-fetch-dest") == "document"):
            return Refusal(403, _OTHER_SITE)
    origins = headers.getlist("origin")
    if origins and not reads:
        host, secure = headers.get("host", ""), is_secure(scope)
        if not (len(origins) == 1 and is_same_origin(origins[0], host, secure=secure)):
            return Refusal(403, _OTHER_SITE)
    return None


def is_secure(scope: Scope) -> bool:
    """Return whether a request came over https, or a websocket over wss."""
    return scope.get("scheme") in ("https", "wss")


def is_same_origin(origin: str, host: str, *, secure: bool = False) -> bool:
    """Return whether an Origin header names the requested host.

    With ``secure`` (a request over https), a page of this host that was loaded over http is another site. Without it,
    an https origin is accepted: a proxy may speak https to browsers and http to this server.
    """
    try:
        parts = urlsplit(origin)
        port = parts.port
    except ValueError:
        return False
    default = {"https": 443}.get(parts.scheme) if secure else {"http": 80, "https": 443}.get(parts.scheme)
    requested = _HOST.fullmatch(host)
    if default is None or requested is None or not parts.hostname:
        return False
    same_port = (port or default) == (int(requested[2]) if requested[2] else default)
    return same_port and _name(parts.hostname) == _name(requested[1])


def _too_long(scope: Scope, settings: GuardSettings) -> Refusal | None:
    """Refuse an announced length above the path's limit, and ambiguous lengths."""
    headers = _headers(scope)
    lengths = headers.getlist("content-length")
    if not lengths:
        return None
    ambiguous = len(set(lengths)) > 1 or "transfer-encoding" in headers
    if ambiguous or not re.fullmatch("[0-9]{1,18}", lengths[0]):
        return Refusal(400, "A body must state its length once, as a whole number; send it again.")
    return body_refusal(scope, settings) if int(lengths[0]) > settings.most_bytes(scope["path"]) else None


def announces_body(scope: Scope) -> bool:
    """Return whether a request has a body (RFC 9112, section 6.3)."""
    headers = _headers(scope)
    return "content-length" in headers or "transfer-encoding" in headers


def body_refusal(scope: Scope, settings: GuardSettings) -> Refusal:
    """Return the refusal of a body that is too long."""
    most = settings.most_bytes(scope["path"])
    size = f"{most // MIB} MiB" if most >= MIB else f"{most // KIB} KiB"
    return Refusal(413, f"At most {size} can be sent here; send less.")


def needs_token(scope: Scope, settings: GuardSettings) -> bool:
    """Return whether a request must present the token, but does not."""
    if settings.token is None or str(scope["path"]).startswith(settings.open_to_all):
        return False
    cookies = (cookie_parser(text) for text in _headers(scope).getlist("cookie"))
    return not any(is_token(cookie.get(cookie_name(scope), ""), settings) for cookie in cookies)


def cookie_name(scope: Scope) -> str:
    """Return the name of the cookie that holds the token."""
    return f"__Host-{COOKIE}" if is_secure(scope) else COOKIE


def is_token(text: str, settings: GuardSettings) -> bool:
    """Return whether ``text`` is the token; takes the same time for every text."""
    return hmac.compare_digest(text.encode(), (settings.token or "").encode()) and settings.token is not None


def token_in_query(scope: Scope) -> tuple[str, str] | None:
    """Return the token in an address and the address without it; None if it holds no token, or several."""
    pairs = parse_qsl(scope.get("query_string", b"").decode("latin-1"), keep_blank_values=True)
    tokens = [value for name, value in pairs if name == "token"]
    if len(tokens) != 1:
        return None
    rest = urlencode([(name, value) for name, value in pairs if name != "token"])
    # One slash: a path that begins with two would be another host.
    path = "/" + quote(str(scope["path"]).lstrip("/"))
    return tokens[0], path + (f"?{rest}" if rest else "")


def accepts_html(scope: Scope) -> bool:
    """Return whether a browser asks for a page."""
    return "text/html" in _headers(scope).get("accept", "")


def _headers(scope: Scope) -> Headers:
    return Headers(raw=[(name.lower(), value) for name, value in scope["headers"]])


def _name(host: str) -> str:
    return host.strip("[]").rstrip(".").lower()

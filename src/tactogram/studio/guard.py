"""The guard around the whole server: who may ask, how much may be sent, and what every answer says to the browser.

Pure ASGI, so that it stands before everything, websockets too, and never reads a body itself. What it checks is
`tactogram.studio.guard_rules`. An exception inside never ends the server, and its traceback goes to the log only.
"""

from __future__ import annotations

import asyncio
import html
import json
import logging
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import SimpleCookie
from typing import Any
from urllib.parse import quote

from tactogram.studio.guard_rules import (
    PARTICIPANTS,
    Guarding,
    Refusal,
    body_refusal,
    cookie_name,
    header,
    is_secure,
    is_token,
    needs_token,
    refusal,
    token_in_query,
)

Message = MutableMapping[str, Any]
Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

STRICT = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; media-src 'self' blob:; "
    "connect-src 'self'; font-src 'self'; worker-src 'self' blob:; manifest-src 'self'; base-uri 'none'; "
    "form-action 'self'; frame-ancestors 'none'"
)
"""Of participants' pages: nothing but this server's own files, no inline script or style."""
STUDIO = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' blob: data:; media-src 'self' blob: data:; font-src 'self' data:; connect-src 'self' blob: data:; "
    "worker-src 'self' blob:; object-src 'none'; base-uri 'self'; form-action 'self'; frame-ancestors 'none'"
)
"""Of the rest. NiceGUI writes scripts and styles into its pages and compiles templates; no other host is named."""
REPORT = (
    "sandbox; default-src 'none'; img-src 'self' data:; media-src data:; style-src 'unsafe-inline'; font-src data:; "
    "frame-ancestors 'self'"
)
"""For a route to set on an HTML report that a run holds: shown, never run; within a page of this server."""
ALWAYS = (
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("permissions-policy", "camera=(self), microphone=(self), geolocation=(), payment=(), usb=()"),
    ("cache-control", "no-store"),
)
"""Set where an answer does not say otherwise."""
FAILED = Refusal(
    500, "This did not work because of an error in the program; it was written to the server's log."
)
STALLED = Refusal(408, "What was being sent stopped on its way; send it again.")
TOKEN_NEEDED = Refusal(
    401,
    "This needs the token that the command printed: open the address with it; if you just did, open this again.",
)

log = logging.getLogger("tactogram.studio")


class Guard:
    """An ASGI application around another.

    Parameters
    ----------
    app : ASGI application
    settings : Guarding
    """

    def __init__(self, app: App, settings: Guarding) -> None:
        self.app, self.settings = app, settings

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a connection through, or refuse it."""
        if scope["type"] == "http":
            await self._http(scope, receive, send)
        elif scope["type"] == "websocket":
            await self._websocket(scope, receive, send)
        else:
            await self.app(scope, receive, send)

    async def _http(self, scope: Scope, receive: Receive, send: Send) -> None:
        refused = refusal(scope, self.settings)
        if refused is None and needs_token(scope, self.settings):
            if await self._exchanged(scope, send):
                return
            refused = TOKEN_NEEDED
        if refused is not None:
            await refuse(refused, scope, send)
            return
        body = _Body(scope, receive, self.settings)
        answer = _Answer(scope, send, body)
        try:
            await self.app(scope, body.receive, answer.send)
        except Exception:
            if body.refused is None:
                log.exception("%s %s failed", scope["method"], _place(scope))
        if not answer.started:
            await refuse(body.refused or FAILED, scope, send)

    async def _websocket(self, scope: Scope, receive: Receive, send: Send) -> None:
        if refusal(scope, self.settings) or needs_token(scope, self.settings):
            await receive()
            await send({"type": "websocket.close", "code": 1008})
            return
        most = self.settings.message

        async def limited() -> Message:
            message = await receive()
            if message["type"] == "websocket.receive":
                length = len(message.get("bytes") or b"") + len((message.get("text") or "").encode())
                if length > most:
                    await send({"type": "websocket.close", "code": 1009})
                    return {"type": "websocket.disconnect", "code": 1009}
            return message

        try:
            await self.app(scope, limited, send)
        except Exception:
            log.exception("websocket %s failed", _place(scope))

    async def _exchanged(self, scope: Scope, send: Send) -> bool:
        """Take the token out of an address into a cookie; return whether it was there and right."""
        found = token_in_query(scope)
        if found is None or scope["method"] != "GET" or not is_token(found[0], self.settings):
            return False
        named = cookie_name(scope)
        cookie: SimpleCookie = SimpleCookie({named: found[0]})
        flags = {"httponly": True, "samesite": "Strict", "path": "/", "secure": is_secure(scope)}
        for name, value in flags.items():
            cookie[named][name] = value
        headers = [
            ("location", found[1]),
            ("set-cookie", cookie[named].OutputString()),
            ("content-length", "0"),
        ]
        await send(
            {"type": "http.response.start", "status": 303, "headers": _encoded([*headers, *_usual(scope)])}
        )
        await send({"type": "http.response.body", "body": b""})
        return True


class _Body:
    """What comes in, counted and timed. After a refusal the application is told that the sender is gone."""

    def __init__(self, scope: Scope, receive: Receive, settings: Guarding) -> None:
        self._scope, self._receive, self._settings = scope, receive, settings
        self._bytes, self._whole = 0, False
        self._waited = 0.0
        self.refused: Refusal | None = None

    async def receive(self) -> Message:
        if self._whole:
            return await self._receive()
        most, loop = self._settings.body_seconds, asyncio.get_running_loop()
        in_all = most + self._bytes / self._settings.body_rate
        begun = loop.time()
        try:
            message = await asyncio.wait_for(self._receive(), min(most, in_all - self._waited))
        except TimeoutError:
            return self._refuse(STALLED)
        self._waited += loop.time() - begun
        if message["type"] == "http.request":
            self._bytes += len(message.get("body", b""))
            if self._bytes > self._settings.most_bytes(self._scope["path"]):
                return self._refuse(body_refusal(self._scope, self._settings))
        self._whole = not message.get("more_body", False)
        return message

    def _refuse(self, why: Refusal) -> Message:
        self.refused, self._whole = why, True
        return {"type": "http.disconnect"}


class _Answer:
    """What goes out, with the headers that every answer has; nothing of the application's after a refusal."""

    def __init__(self, scope: Scope, send: Send, body: _Body) -> None:
        self._scope, self._send, self._body = scope, send, body
        self.started = False

    async def send(self, message: Message) -> None:
        if self._body.refused is not None and not self.started:
            return
        if message["type"] == "http.response.start":
            self.started = True
            own = list(message.get("headers", []))
            said = {name.lower() for name, _ in own}
            usual = [(name, value) for name, value in _encoded(_usual(self._scope)) if name not in said]
            message = {**message, "headers": [*own, *usual]}
        await self._send(message)


async def refuse(why: Refusal, scope: Scope, send: Send) -> None:
    """Answer with a status and a sentence: a page for a browser that asks for one, else JSON; then hang up."""
    if "text/html" in (header(scope, "accept") or ""):
        kind = "text/html; charset=utf-8"
        text = html.escape(why.sentence)
        # After a link from elsewhere a browser sends the cookie only from here on: followed from this page, it does.
        again = quote("/" + str(scope["path"]).lstrip("/"))
        body = (
            "<!doctype html><html lang='en'><meta charset='utf-8'><title>tactogram</title>"
            f"<p>{text}</p><p><a href='{again}'>Open this page again</a></p></html>"
        ).encode()
    else:
        kind, body = "application/json", json.dumps({"error": why.sentence}).encode()
    headers = [("content-type", kind), ("content-length", str(len(body))), ("connection", "close")]
    await send(
        {"type": "http.response.start", "status": why.status, "headers": _encoded([*headers, *_usual(scope)])}
    )
    await send({"type": "http.response.body", "body": b"" if scope.get("method") == "HEAD" else body})


def _usual(scope: Scope) -> list[tuple[str, str]]:
    policy = STRICT if str(scope["path"]).startswith(PARTICIPANTS) else STUDIO
    return [*ALWAYS, ("content-security-policy", policy)]


def _encoded(pairs: list[tuple[str, str]]) -> list[tuple[bytes, bytes]]:
    return [(name.encode("latin-1"), value.encode("latin-1")) for name, value in pairs]


def _place(scope: Scope) -> str:
    """Return a path for the log, without the secrets that stand in participants' addresses."""
    parts = str(scope["path"]).split("/")
    if len(parts) > 2 and parts[1] in ("join", "take"):
        parts[2] = "…"
    return "/".join(parts)[:200]

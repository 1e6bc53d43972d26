"""The guard around the whole server: who may ask, how much may be sent, and what every answer says to the browser.

Pure ASGI, so that it stands before everything, websockets too, and never reads a body itself. What it checks is
`studio.server.guard_rules`. An exception inside never ends the server, and its traceback goes to the log only.
"""

from __future__ import annotations

import asyncio
import html
import logging
from urllib.parse import quote

from starlette.datastructures import MutableHeaders
from starlette.responses import HTMLResponse, JSONResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from tactogram.studio.server.guard_rules import (
    PARTICIPANTS,
    GuardSettings,
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


class RequestGuard:
    """An ASGI application around another.

    Parameters
    ----------
    app : ASGI application
    settings : Guarding
    """

    def __init__(self, app: ASGIApp, settings: GuardSettings) -> None:
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
        send = with_usual_headers(scope, send)
        refused = refusal(scope, self.settings)
        if refused is None and needs_token(scope, self.settings):
            if (exchanged := self._exchanged(scope)) is not None:
                await exchanged(scope, receive, send)
                return
            refused = TOKEN_NEEDED
        if refused is not None:
            await refuse(refused, scope)(scope, receive, send)
            return
        body = _RequestBody(scope, receive, self.settings)
        answer = _GuardedResponse(send, body)
        try:
            await self.app(scope, body.receive, answer.send)
        except Exception:
            if body.refused is None:
                log.exception("%s %s failed", scope["method"], _place(scope))
        if not answer.started:
            await refuse(body.refused or FAILED, scope)(scope, receive, send)

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

    def _exchanged(self, scope: Scope) -> Response | None:
        """Take the token out of an address into a cookie; None if it is not there, or not right."""
        found = token_in_query(scope)
        if found is None or scope["method"] != "GET" or not is_token(found[0], self.settings):
            return None
        answer = RedirectResponse(found[1], 303)
        answer.set_cookie(
            cookie_name(scope), found[0], secure=is_secure(scope), httponly=True, samesite="strict"
        )
        return answer


class _RequestBody:
    """Request body, counted and timed. After a refusal the application is told that the sender is gone."""

    def __init__(self, scope: Scope, receive: Receive, settings: GuardSettings) -> None:
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


class _GuardedResponse:
    """Guarded response: nothing of the application's after a refusal."""

    def __init__(self, send: Send, body: _RequestBody) -> None:
        self._send, self._body = send, body
        self.started = False

    async def send(self, message: Message) -> None:
        if self.started or self._body.refused is None:
            self.started = True
            await self._send(message)


def with_usual_headers(scope: Scope, send: Send) -> Send:
    """Return ``send`` with the headers that every answer has; those that an answer sets itself stay."""
    policy = STRICT if str(scope["path"]).startswith(PARTICIPANTS) else STUDIO

    async def headed(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(
                raw=[(name.lower(), value) for name, value in message.get("headers", [])]
            )
            for name, value in (*ALWAYS, ("content-security-policy", policy)):
                headers.setdefault(name, value)
            message = {**message, "headers": headers.raw}
        await send(message)

    return headed


def refuse(why: Refusal, scope: Scope) -> Response:
    """Return an answer of one sentence: a page for a browser that asks for one, else JSON; then the server hangs up."""
    ends = {"connection": "close"}
    if "text/html" not in (header(scope, "accept") or ""):
        return JSONResponse({"error": why.sentence}, why.status, ends)
    # After a link from elsewhere a browser sends the cookie only from here on: followed from this page, it does.
    again = quote("/" + str(scope["path"]).lstrip("/"))
    return HTMLResponse(
        "<!doctype html><html lang='en'><meta charset='utf-8'><title>tactogram</title>"
        f"<p>{html.escape(why.sentence)}</p><p><a href='{again}'>Open this page again</a></p></html>",
        why.status,
        ends,
    )


def _place(scope: Scope) -> str:
    """Return a path for the log, without the secrets that stand in participants' addresses."""
    parts = str(scope["path"]).split("/")
    if len(parts) > 2 and parts[1] in ("join", "take"):
        parts[2] = "…"
    return "/".join(parts)[:200]

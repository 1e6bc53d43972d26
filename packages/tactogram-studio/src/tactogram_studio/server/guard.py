"""Request guard around the whole server: access, size limits and security headers.

Pure ASGI, so that it also covers websockets and never buffers a body. Its rules are in `studio.server.guard_rules`. An
exception inside never ends the server; its traceback goes to the log only.
"""

from __future__ import annotations

import asyncio
import html
import logging
import secrets
from urllib.parse import quote

from starlette.datastructures import MutableHeaders
from starlette.responses import HTMLResponse, JSONResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from tactogram_studio.server.guard_rules import (
    PARTICIPANTS,
    GuardSettings,
    Refusal,
    accepts_html,
    announces_body,
    body_refusal,
    cookie_name,
    is_secure,
    is_token,
    needs_token,
    refusal,
    token_in_query,
)
from tactogram_study.wording import paragraphs

PARTICIPANT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; media-src 'self' blob:; "
    "connect-src 'self'; font-src 'self'; worker-src 'self' blob:; manifest-src 'self'; base-uri 'none'; "
    "form-action 'self'; frame-ancestors 'none'"
)
"""Content policy of participants' pages: only this server's own files, no inline scripts or styles."""
STUDIO_POLICY = (
    "default-src 'self'; script-src 'self' 'nonce-{nonce}' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' blob: data:; media-src 'self' blob: data:; font-src 'self' data:; connect-src 'self' blob: data:; "
    "worker-src 'self' blob:; object-src 'none'; base-uri 'self'; form-action 'self'; frame-ancestors 'none'"
)
"""Content policy of all other pages. NiceGUI compiles templates, evaluates what the server sends, and writes inline
styles; of inline scripts only its own run, which carry the response's nonce."""
REPORT_POLICY = (
    "sandbox; default-src 'none'; img-src 'self' data:; media-src data:; style-src 'unsafe-inline'; font-src data:; "
    "frame-ancestors 'self'"
)
"""For routes that send a run's HTML report: displayed within a page of this server, never executed."""
DEFAULT_HEADERS = (
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("permissions-policy", "camera=(self), microphone=(self), geolocation=(), payment=(), usb=()"),
    ("cache-control", "no-store"),
)
FAILED = Refusal(500, "This failed because of an error in the program; details are in the server's log.")
STALLED = Refusal(408, "The request stopped arriving; send it again.")
TOKEN_NEEDED = Refusal(
    401,
    "This page needs the token that the command printed: open the address with the token; if you just did, try again.",
)

log = logging.getLogger("tactogram_studio")


class RequestGuard:
    """ASGI application that guards another."""

    def __init__(self, app: ASGIApp, settings: GuardSettings) -> None:
        self.app, self.settings = app, settings

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a connection through, or refuse it; what a client says of a proxy's address or path is dropped."""
        if scope["type"] != "lifespan":
            headers = [entry for entry in scope["headers"] if b"forwarded" not in entry[0].lower()]
            scope = {**scope, "headers": headers}
        if scope["type"] == "http":
            await self._http(scope, receive, send)
        elif scope["type"] == "websocket":
            await self._websocket(scope, receive, send)
        else:
            await self.app(scope, receive, send)

    async def _http(self, scope: Scope, receive: Receive, send: Send) -> None:
        send = _with_default_headers(scope, send)
        refused = refusal(scope, self.settings)
        if refused is None and needs_token(scope, self.settings):
            if (redirect := self._token_to_cookie(scope)) is not None:
                await redirect(scope, receive, send)
                return
            refused = TOKEN_NEEDED
        if refused is not None:
            await _refusal_response(refused, scope)(scope, receive, send)
            return
        body = _RequestBody(scope, receive, self.settings)
        response = _GuardedResponse(send, body)
        try:
            await self.app(scope, body.receive, response.send)
        except Exception:
            if body.refused is None:
                log.exception("%s %s failed", scope["method"], _logged_path(scope))
        if not response.started:
            await _refusal_response(body.refused or FAILED, scope)(scope, receive, send)

    async def _websocket(self, scope: Scope, receive: Receive, send: Send) -> None:
        if refusal(scope, self.settings) or needs_token(scope, self.settings):
            await receive()
            await send({"type": "websocket.close", "code": 1008})
            return
        try:
            await self.app(scope, receive, send)
        except Exception:
            log.exception("websocket %s failed", _logged_path(scope))

    def _token_to_cookie(self, scope: Scope) -> Response | None:
        """Return a redirect that moves the address's token into a cookie; None without a valid token."""
        entry = token_in_query(scope)
        if entry is None or scope["method"] != "GET" or not is_token(entry[0], self.settings):
            return None
        token, address = entry
        response = RedirectResponse(address, 303)
        response.set_cookie(
            cookie_name(scope), token, secure=is_secure(scope), httponly=True, samesite="strict"
        )
        return response


class _RequestBody:
    """Request body with limits on size and time; after a refusal the application sees a disconnect.

    Without an announced body only the server can be slow, and a disconnect would cut a file that is being sent.
    """

    def __init__(self, scope: Scope, receive: Receive, settings: GuardSettings) -> None:
        self._scope, self._receive, self._settings = scope, receive, settings
        self._bytes, self._complete = 0, False
        self._announced = announces_body(scope)
        self._waited = 0.0
        self.refused: Refusal | None = None

    async def receive(self) -> Message:
        if self._complete:
            return await self._receive()
        most, loop = self._settings.body_seconds, asyncio.get_running_loop()
        allowed = most + self._bytes / self._settings.body_rate
        begun = loop.time()
        limit = min(most, allowed - self._waited) if self._announced else None
        try:
            message = await asyncio.wait_for(self._receive(), limit)
        except TimeoutError:
            return self._refuse(STALLED)
        self._waited += loop.time() - begun
        if message["type"] == "http.request":
            self._bytes += len(message.get("body", b""))
            if self._bytes > self._settings.most_bytes(self._scope["path"]):
                return self._refuse(body_refusal(self._scope, self._settings))
        self._complete = not message.get("more_body", False)
        return message

    def _refuse(self, refused: Refusal) -> Message:
        self.refused, self._complete = refused, True
        return {"type": "http.disconnect"}


class _GuardedResponse:
    """Response that the application cannot start once its request body was refused."""

    def __init__(self, send: Send, body: _RequestBody) -> None:
        self._send, self._body = send, body
        self.started = False

    async def send(self, message: Message) -> None:
        if self.started or self._body.refused is None:
            self.started = True
            await self._send(message)


def _with_default_headers(scope: Scope, send: Send) -> Send:
    """Return ``send`` with security headers, except where a response sets its own.

    The nonce for inline scripts is in the request's state, where the page's template finds it.
    """
    participants = str(scope["path"]).startswith(PARTICIPANTS)
    nonce = scope.setdefault("state", {})["nonce"] = secrets.token_urlsafe(16)
    policy = PARTICIPANT_POLICY if participants else STUDIO_POLICY.format(nonce=nonce)

    async def send_with_headers(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(
                raw=[(name.lower(), value) for name, value in message.get("headers", [])]
            )
            for name, value in (*DEFAULT_HEADERS, ("content-security-policy", policy)):
                headers.setdefault(name, value)
            message = {**message, "headers": headers.raw}
        await send(message)

    return send_with_headers


def _refusal_response(refused: Refusal, scope: Scope) -> Response:
    """Return a page for a browser, JSON for everything else; then the connection closes."""
    headers = {"connection": "close"}
    if not accepts_html(scope):
        return JSONResponse({"error": refused.sentence}, refused.status, headers)
    # After a link on another site, a browser sends the cookie only with requests from this page.
    again = quote("/" + str(scope["path"]).lstrip("/"))
    remedy = paragraphs("no_ticket") if str(scope["path"]).startswith(PARTICIPANTS) else ""
    return HTMLResponse(
        "<!doctype html><html lang='en'><meta charset='utf-8'><title>tactogram</title>"
        f"{remedy}<p>{html.escape(refused.sentence)}</p><p><a href='{again}'>Open this page again</a></p></html>",
        refused.status,
        headers,
    )


def _logged_path(scope: Scope) -> str:
    """Return a path for the log, without the secrets in participants' addresses."""
    parts = str(scope["path"]).split("/")
    if len(parts) > 2 and parts[1] in ("join", "take", "feel"):
        parts[2] = "…"
    return repr("/".join(parts)[:200])

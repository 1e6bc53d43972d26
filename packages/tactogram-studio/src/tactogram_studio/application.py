"""Web server of studio and studies, on loopback by default."""

from __future__ import annotations

import ctypes
import gc
import importlib
import secrets
import threading
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tactogram.extras import imported
from tactogram_studio.context import Studio
from tactogram_studio.server.listening import ListeningPort
from tactogram_study.participants.tickets import write_secret

if TYPE_CHECKING:
    from tactogram_studio.server.guard import RequestGuard

M_ARENA_MAX = -8
"""Of glibc's malloc.h."""
STATIC = Path(__file__).parent / "static"
PAGES = (
    "home",
    "make.page",
    "touch",
    "edit.page",
    "materials.page",
    "train.page",
    "send.page",
    "live.page",
    "studies.experimenter",
    "studies.page",
    "reports",
)
"""Modules of ``pages`` that add a page."""


@dataclass(frozen=True)
class ServerAnnouncement:
    """Addresses of a running server.

    Parameters
    ----------
    address : str
        Address of the start page, including the token.
    roots : tuple of str
        Beginnings of the addresses for other machines, best first.
    certificate_sha256 : str, optional
        Fingerprint of a self-signed certificate, to compare with the one that the browser shows.
    """

    address: str
    roots: tuple[str, ...]
    certificate_sha256: str | None = None


def make_app(
    studio: Studio, *, token: str | None = None, names: tuple[str, ...] = (), https: bool = False
) -> RequestGuard:
    """Return the guarded ASGI application of a studio.

    NiceGUI allows one application per process, so call this once per process.

    ``token``: access token that browsers on other machines must present; None serves loopback only. ``names``: host
    names and addresses under which other machines reach it. ``https``: whether to restrict cookies to encrypted
    connections.
    """
    state = _state_folder(studio)
    imported("nicegui", extra="studio", what="the studio")
    from fastapi import FastAPI
    from fastapi.middleware.gzip import GZipMiddleware
    from fastapi.staticfiles import StaticFiles
    from nicegui import app as pages_app, ui
    from nicegui.storage import Storage

    from tactogram_studio.layout import add_not_found, show_errors
    from tactogram_studio.server.guard import RequestGuard
    from tactogram_studio.server.guard_rules import GuardSettings
    from tactogram_study.participants.routes import participant_router

    Storage.path = state  # NiceGUI reads its environment variable on import: possibly too early
    app = FastAPI(title="tactogram", docs_url=None, redoc_url=None, openapi_url=None)
    app.mount("/static", GZipMiddleware(StaticFiles(directory=STATIC)), name="static")
    app.include_router(participant_router(studio.sessions))
    if not studio.study_only:
        studio.sessions.reopen(studio.workspace.sessions())
    for name in ("studies.experimenter",) if studio.study_only else PAGES:
        importlib.import_module(f"tactogram_studio.pages.{name}").add(studio)
    add_not_found(navigation=not studio.study_only)
    show_errors(pages_app, studio.workspace.folder)
    _name_nonces()
    ui.run_with(
        app,
        title="tactogram",
        language="en-US",  # screen readers choose a voice by this
        favicon=STATIC / "icon.svg",
        storage_secret=_cookie_secret(state / "secret"),
        session_middleware_kwargs=_session_cookie(https),
        dark=None,  # as the system, unless this browser chose otherwise
        show_welcome_message=False,
        reconnect_timeout=10.0,
    )
    return RequestGuard(app, GuardSettings(loopback=token is None, token=token, hosts=names))


def serve(
    studio: Studio,
    listening: ListeningPort,
    *,
    open_browser: bool = True,
    path: str = "/",
    ready: Callable[[ServerAnnouncement], None] = lambda announcement: None,
) -> None:
    """Serve a studio until interrupted.

    ``listening``: beyond loopback, everything but the participants' pages requires a random token. ``path``: path of
    the page to open. ``ready``: called once the server accepts connections.

    Raises `DataError` if there is no certificate and none can be created.
    """
    imported("uvicorn", extra="studio", what="the studio")
    from tactogram_studio.server.listening import StudioServer

    listening = listening.with_certificate(_state_folder(studio))
    certificate = listening.certificate
    context = None if certificate is None else certificate.context()
    studio = replace(studio, roots=() if listening.loopback else listening.roots)
    token = None if listening.loopback else secrets.token_urlsafe(24)
    query = f"?token={token}" if token else ""
    announcement = ServerAnnouncement(
        f"{listening.roots[0]}{path}{query}",
        listening.roots,
        certificate.sha256 if certificate is not None and certificate.self_signed else None,
    )

    def on_ready() -> None:
        ready(announcement)
        if open_browser:
            here = f"{listening.here}{path}{query}"
            threading.Thread(target=webbrowser.open, args=(here,), daemon=True).start()

    _share_memory_between_threads()
    app = make_app(studio, token=token, names=listening.names, https=listening.https)
    # Modules loaded by now are never freed: scanning them in each garbage collection would block responses for 0.1 s.
    gc.collect()
    gc.freeze()
    try:
        on_ready()  # the socket listens already
        with suppress(KeyboardInterrupt):  # the usual way to stop it
            StudioServer(app, context=context, proxies=listening.proxies).run(sockets=[listening.socket])
    finally:
        studio.sessions.close()


def _name_nonces() -> None:
    """Give NiceGUI's inline scripts the nonce of `RequestGuard`; those in a page's content get none."""
    from jinja2 import DictLoader
    from nicegui import client

    source = (Path(client.__file__).parent / "templates" / "index.html").read_text(encoding="utf-8")
    named = source.replace("<script", '<script nonce="{{ request.state.nonce }}"')
    client.templates.env.loader = DictLoader({"index.html": named})


def _share_memory_between_threads() -> None:
    """Let glibc allocate from one arena: with one for each thread, what some have freed is of no use to others."""
    with suppress(OSError, AttributeError, TypeError):  # another C library
        ctypes.CDLL(None).mallopt(M_ARENA_MAX, 1)


def _state_folder(studio: Studio) -> Path:
    state = studio.workspace.studio_folder / "state"
    state.mkdir(parents=True, exist_ok=True)
    return state


def _session_cookie(https: bool) -> dict[str, object]:
    """Return the settings of Starlette's session middleware; browsers send a ``__Host-`` cookie over https only."""
    secure = {"session_cookie": "__Host-tactogram_session", "https_only": True} if https else {}
    return {"same_site": "strict", **secure}


def _cookie_secret(path: Path) -> str:
    """Return the key that signs cookies; it survives restarts."""
    if not path.is_file():
        write_secret(path, secrets.token_urlsafe(32).encode())
    return path.read_text(encoding="utf-8")

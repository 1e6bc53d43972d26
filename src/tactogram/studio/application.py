"""The server: one application for studio and studies, on this machine unless asked otherwise."""

from __future__ import annotations

import gc
import importlib
import secrets
import threading
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tactogram.extras import imported
from tactogram.studio.context import Studio
from tactogram.studio.server.listening import ListeningPort
from tactogram.studio.server.secret_files import write_secret

if TYPE_CHECKING:
    from tactogram.studio.server.guard import RequestGuard

STATIC = Path(__file__).parent / "static"
PAGES = ("home", "make", "touch", "materials", "train", "send", "live", "studies", "reports")
"""Folders that have a ``page``, in the order of the navigation."""


@dataclass(frozen=True)
class ServerAnnouncement:
    """Announcement of a server that answers.

    Parameters
    ----------
    address : str
        Of the page that is opened, token included.
    roots : tuple of str
        How the addresses that others are given begin; the best first.
    certificate_sha256 : str, optional
        The fingerprint of a certificate that was made here, to be compared with what the browser shows.
    """

    address: str
    roots: tuple[str, ...]
    certificate_sha256: str | None = None


def make_app(
    studio: Studio, *, token: str | None = None, names: tuple[str, ...] = (), https: bool = False
) -> RequestGuard:
    """Return the ASGI application of a studio, guarded.

    NiceGUI has one application for a process, so that this is called once in a process.

    Parameters
    ----------
    studio : Studio
    token : str, optional
        What a browser has to know; needed where it is reached from beyond this machine. None is loopback.
    names : tuple of str
        By which it is reached from there.
    https : bool
        Whether cookies are for encrypted connections only.
    """
    state = _state(studio)
    imported("nicegui", extra="studio", what="the studio")
    from fastapi import FastAPI
    from fastapi.staticfiles import StaticFiles
    from nicegui import app as pages_app
    from nicegui import ui
    from nicegui.storage import Storage

    from tactogram.studio.layout import show_error
    from tactogram.studio.participants.routes import participant_router
    from tactogram.studio.server.guard import RequestGuard
    from tactogram.studio.server.guard_rules import GuardSettings

    Storage.path = state  # NiceGUI's own variable is read at its import: by then it may be too late
    app = FastAPI(title="tactogram", docs_url=None, redoc_url=None, openapi_url=None)
    app.mount("/static", StaticFiles(directory=STATIC), name="static")
    app.include_router(participant_router(studio.sessions))
    if not studio.alone:
        studio.sessions.reopen(studio.workspace.sessions())
    importlib.import_module("tactogram.studio.pages.studies.experimenter").add(studio)
    for name in () if studio.alone else PAGES:
        importlib.import_module(f"tactogram.studio.pages.{name}.page").add(studio)
    pages_app.on_exception(show_error)
    ui.run_with(
        app,
        title="tactogram",
        language="en-US",  # screen readers choose a voice by it
        favicon=STATIC / "icon.svg",
        storage_secret=_secret(state / "secret"),
        session_middleware_kwargs=_session_cookie(https),
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
    ready: Callable[[ServerAnnouncement], None] = lambda answering: None,
) -> None:
    """Serve a studio until it is interrupted.

    Parameters
    ----------
    studio : Studio
    listening : Listening
        Beyond loopback a token is drawn, without which nothing is answered but participants' own pages.
    open_browser : bool
    path : str
        That the browser opens.
    ready : callable
        Called when it answers.

    Raises
    ------
    DataError
        If there is no certificate, and none can be made.
    """
    imported("uvicorn", extra="studio", what="the studio")
    from tactogram.studio.server.connections import LimitedServer, limits_here

    listening = listening.with_certificate(_state(studio))
    certificate = listening.certificate
    context = None if certificate is None else certificate.context()  # of the file as it is now
    studio = replace(studio, roots=() if listening.loopback else listening.roots)
    token = None if listening.loopback else secrets.token_urlsafe(24)
    query = f"?token={token}" if token else ""
    answering = ServerAnnouncement(
        f"{listening.roots[0]}{path}{query}",
        listening.roots,
        certificate.sha256 if certificate is not None and certificate.own else None,
    )

    def answers() -> None:
        ready(answering)
        if open_browser:
            here = f"{listening.here}{path}{query}"
            threading.Thread(target=webbrowser.open, args=(here,), daemon=True).start()

    app = make_app(studio, token=token, names=listening.names, https=listening.https)
    # What is loaded by now stays. Looked through for garbage again and again, it would stop all answers for 0.1 s.
    gc.collect()
    gc.freeze()
    try:
        LimitedServer(
            app,
            listening.socket,
            context=context,
            limits=limits_here(),
            ready=answers,
        ).serve_until_ended()
    finally:
        studio.sessions.close()


def _state(studio: Studio) -> Path:
    state = studio.workspace.own / "state"
    state.mkdir(parents=True, exist_ok=True)
    return state


def _session_cookie(https: bool) -> dict[str, object]:
    """Return what Starlette's session middleware takes; of its own name where it is not to be sent unencrypted."""
    named = {"session_cookie": "__Host-tactogram_session", "https_only": True} if https else {}
    return {"same_site": "strict", **named}


def _secret(path: Path) -> str:
    """Return what cookies are signed with, the same after a restart."""
    if not path.is_file():
        write_secret(path, secrets.token_urlsafe(32).encode())
    return path.read_text(encoding="utf-8")

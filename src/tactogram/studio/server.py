"""The server: one application for studio and studies, on this machine unless asked otherwise."""

from __future__ import annotations

import importlib
import logging
import os
import secrets
import socket
import threading
import webbrowser
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from tactogram.errors import DeviceError
from tactogram.extras import imported
from tactogram.studio.guard import Guard
from tactogram.studio.guard_rules import Guarding
from tactogram.studio.studio import Studio

STATIC = Path(__file__).parent / "static"
PAGES = ("home", "make", "touch", "materials", "train", "send", "live", "studies", "reports")
"""Folders that have a ``page``, in the order of the navigation."""
LOOPBACK = ("127.0.0.1", "::1", "localhost")


def make_app(studio: Studio, *, host: str = "127.0.0.1", token: str | None = None) -> Guard:
    """Return the ASGI application of a studio, guarded.

    NiceGUI has one application for a process, so that this is called once in a process.

    Parameters
    ----------
    studio : Studio
    host : str
        That it listens on.
    token : str, optional
        What a browser has to know where ``host`` is not loopback.
    """
    state = studio.workspace.own / "state"
    state.mkdir(parents=True, exist_ok=True)
    os.environ["NICEGUI_STORAGE_PATH"] = str(state)  # read when nicegui is imported
    imported("nicegui", extra="studio", what="the studio")
    from fastapi import FastAPI
    from fastapi.staticfiles import StaticFiles
    from nicegui import app as pages_app
    from nicegui import ui

    from tactogram.studio.layout import told
    from tactogram.studio.participants.routes import participant_router

    app = FastAPI(title="tactogram", docs_url=None, redoc_url=None, openapi_url=None)
    app.mount("/static", StaticFiles(directory=STATIC), name="static")
    app.include_router(participant_router(studio.sessions))
    if not studio.alone:
        studio.sessions.reopen(studio.workspace.sessions())
    importlib.import_module("tactogram.studio.studies.experimenter").add(studio)
    for name in () if studio.alone else PAGES:
        importlib.import_module(f"tactogram.studio.{name}.page").add(studio)
    pages_app.on_exception(told)
    ui.run_with(
        app,
        title="tactogram",
        favicon=STATIC / "icon.svg",
        storage_secret=_secret(state / "secret"),
        session_middleware_kwargs={"same_site": "strict"},
        show_welcome_message=False,
        reconnect_timeout=10.0,
    )
    names = (socket.gethostname(), socket.getfqdn())
    return Guard(app, Guarding(loopback=host in LOOPBACK, token=token, hosts=names))


def serve(
    studio: Studio,
    *,
    port: int = 8123,
    host: str = "127.0.0.1",
    open_browser: bool = True,
    path: str = "/",
    ready: Callable[[str], None] = lambda address: None,
) -> None:
    """Serve a studio until it is interrupted.

    Parameters
    ----------
    studio : Studio
    port : int
        0 takes a free one.
    host : str
        Beyond loopback a token is drawn, without which nothing is answered but participants' own pages.
    open_browser : bool
    path : str
        That the browser opens.
    ready : callable
        Called with the address, token included, when it answers.

    Raises
    ------
    DeviceError
        If the port is taken.
    """
    uvicorn = imported("uvicorn", extra="studio", what="the studio")
    listener = _listener(host, port)
    number = listener.getsockname()[1]
    token = None if host in LOOPBACK else secrets.token_urlsafe(24)
    app = make_app(studio, host=host, token=token)
    address = f"http://{_named(host)}:{number}{path}" + (f"?token={token}" if token else "")

    class Server(uvicorn.Server):  # type: ignore[misc, name-defined]
        async def startup(self, sockets: Sequence[socket.socket] | None = None) -> None:
            await super().startup(sockets=sockets)
            ready(address)
            if open_browser:
                threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()

    logging.getLogger("uvicorn.error").setLevel(logging.WARNING)
    config = uvicorn.Config(
        app,
        log_level="warning",
        access_log=False,  # tickets and the token stand in addresses
        server_header=False,
        http="h11",  # httptools takes headers without end
        timeout_keep_alive=65,  # people think longer than 5 s
        timeout_graceful_shutdown=2,
    )
    try:
        with suppress(KeyboardInterrupt):  # the usual way to end it
            Server(config).run(sockets=[listener])
    finally:
        studio.sessions.close()


def _listener(host: str, port: int) -> socket.socket:
    try:
        return socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
    except OSError as error:
        why = os.strerror(error.errno) if error.errno else str(error)
        raise DeviceError(
            f"port {port} of {host} cannot be listened on ({why}): give another --port, or 0 for a free one"
        ) from None


def _named(host: str) -> str:
    if host in ("0.0.0.0", "::"):
        return socket.gethostname()
    return f"[{host}]" if ":" in host else host


def _secret(path: Path) -> str:
    """Return what cookies are signed with, the same after a restart."""
    if not path.is_file():
        part = path.with_name(path.name + ".part")
        part.touch(mode=0o600)
        part.write_text(secrets.token_urlsafe(32), encoding="utf-8")
        part.replace(path)
    return path.read_text(encoding="utf-8")

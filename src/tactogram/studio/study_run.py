"""One study served alone: participants' pages and the experimenter's, and nothing else of the studio."""

from __future__ import annotations

import socket
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from tactogram.errors import ParameterError
from tactogram.studio.experiment_view import address_of
from tactogram.studio.participants.playing import ServerDisplay
from tactogram.studio.participants.sessions import Sessions
from tactogram.studio.server import LOOPBACK, serve
from tactogram.studio.studio import Studio
from tactogram.study.session_store import checked_code


def run_study(
    study: Path | str,
    out: Path | str,
    *,
    changes: Mapping[str, Any] | None = None,
    codes: Sequence[str] = (),
    port: int = 8123,
    host: str = "127.0.0.1",
    open_browser: bool = True,
    device: str = "audio",
    full_scale: float | None = None,
    ready: Callable[[dict[str, Any]], None] = lambda facts: None,
) -> None:
    """Begin a study in a session folder, or go on with it, and serve it until it is interrupted.

    Parameters
    ----------
    study : Path or str
        A TOML file, or the name of a shipped one.
    out : Path
        The session's folder.
    changes : mapping, optional
        Values by dotted key.
    codes : sequence of str
        Participants to enrol; those that are there already are left as they are.
    port, host, open_browser
        See `tactogram.studio.server.serve`.
    device : str
        What a study with ``played_by = "server"`` plays on: ``audio``, ``audio:NAME``, or ``null``, which plays to
        nobody.
    full_scale : float, optional
        What 1.0 of the device stands for, in the unit of the display's drive.
    ready : callable
        Called when it answers with ``experimenter`` (the page's address, with the token where one is needed), ``join``,
        ``codes`` (the address of each), ``addresses`` (of this machine, beyond loopback), ``session``, ``study``.

    Raises
    ------
    TactogramError
        In one line: what is wrong with study, folder, codes or port.
    """
    folder = Path(out).resolve()
    if folder.parent == folder:
        raise ParameterError(f"{out}: is no folder for a session")
    for code in codes:
        checked_code(code)
    anywhere = Sessions()
    try:
        anywhere.begin(study, folder, changes=changes)
    finally:
        anywhere.close()
    studio = Studio.at(folder.parent, alone=True)
    opened = studio.sessions.open(folder)
    if opened.study.played_by == "server":
        studio.sessions.display = ServerDisplay(device, full_scale)
        for display in opened.stimuli.displays:
            studio.sessions.display.check(display)
    opened.stimuli.begin()  # made while the first people read what they agree to
    known = {participant.code.casefold() for participant in opened.store.participants()}
    for code in codes:
        if code.casefold() not in known:
            opened.store.enrol(code)

    def answers(address: str) -> None:
        parts = urlsplit(address)
        root = f"{parts.scheme}://{parts.netloc}"
        ready(
            {
                "experimenter": address,
                "join": f"{root}{opened.join_path}",
                "codes": {code: f"{root}{opened.take_path(code)}" for code in codes},
                "addresses": [] if host in LOOPBACK else addresses(),
                "session": str(folder),
                "study": opened.study.name,
            }
        )

    path = address_of(folder.name)
    serve(studio, port=port, host=host, open_browser=open_browser, path=path, ready=answers)


def addresses() -> list[str]:
    """Return the addresses of this machine that others may reach it by: IPv4, without loopback."""
    try:
        found = socket.getaddrinfo(socket.gethostname(), None, family=socket.AF_INET, type=socket.SOCK_STREAM)
    except OSError:
        return []
    return sorted({str(entry[4][0]) for entry in found if not str(entry[4][0]).startswith("127.")})

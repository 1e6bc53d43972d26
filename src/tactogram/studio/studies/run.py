"""One study served alone: participants' pages and the experimenter's, and nothing else of the studio."""

from __future__ import annotations

import socket
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from tactogram.errors import ParameterError
from tactogram.studio.participants.playing import ServerDisplay
from tactogram.studio.participants.sessions import Sessions
from tactogram.studio.server import serve
from tactogram.studio.studies.experiment_view import address_of
from tactogram.studio.studio import Studio
from tactogram.study.session_store import SessionStore, checked_code

EVERYWHERE = ("0.0.0.0", "::")


def run_study(
    study: Path | str,
    out: Path | str | None = None,
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
        A TOML file, or the name of a shipped one; or the folder of a session, which goes on as it was begun.
    out : Path, optional
        The session's folder, where ``study`` is none.
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
        ``codes`` (the address of each), ``addresses`` (``join`` by this machine's numbers), ``session``, ``study``.

    Raises
    ------
    TactogramError
        In one line: what is wrong with study, folder, codes or port.
    """
    for code in codes:
        checked_code(code)
    display = ServerDisplay(device, full_scale)
    folder = _begun(study, out, changes, display)
    studio = Studio.at(folder.parent, alone=True)
    opened = studio.sessions.open(folder)
    if opened.study.played_by == "server":
        studio.sessions.display = display
        for driven in opened.stimuli.displays:
            display.check(driven)
    opened.stimuli.begin()  # made while the first people read what they agree to
    known = {participant.code.casefold() for participant in opened.store.participants()}
    for code in codes:
        if code.casefold() not in known:
            opened.store.enrol(code)

    def answers(address: str) -> None:
        parts = urlsplit(address)
        root = f"{parts.scheme}://{parts.netloc}"
        reached = addresses() if host in EVERYWHERE else []
        ready(
            {
                "experimenter": address,
                "join": f"{root}{opened.join_path}",
                "codes": {code: f"{root}{opened.take_path(code)}" for code in codes},
                "addresses": [f"{parts.scheme}://{one}:{parts.port}{opened.join_path}" for one in reached],
                "session": str(folder),
                "study": opened.study.name,
            }
        )

    path = address_of(folder.name)
    serve(studio, port=port, host=host, open_browser=open_browser, path=path, ready=answers)


def _begun(
    study: Path | str, out: Path | str | None, changes: Mapping[str, Any] | None, display: ServerDisplay
) -> Path:
    """Return the folder of a session that is begun, or was."""
    if Path(study).is_dir():
        if out is not None or changes:
            raise ParameterError(
                f"{study}: is a session, which goes on as it was begun: leave out --out and --set"
            )
        with SessionStore(Path(study)):
            return Path(study).resolve()
    if out is None:
        raise ParameterError(
            "a study needs --out, the folder of its session; a session that was begun needs none"
        )
    folder = Path(out).resolve()
    if folder.parent == folder:
        raise ParameterError(f"{out}: is no folder for a session")
    anywhere = Sessions(device=display.device, full_scale=display.full_scale)
    try:
        anywhere.begin(study, folder, changes=changes)
    finally:
        anywhere.close()
    return folder


def addresses() -> list[str]:
    """Return the addresses of this machine that others may reach it by: IPv4, without loopback. Nothing is sent."""
    found = set()
    with suppress(OSError):
        known = socket.getaddrinfo(socket.gethostname(), None, family=socket.AF_INET, type=socket.SOCK_STREAM)
        found |= {str(entry[4][0]) for entry in known}
    # Connecting a datagram socket sends nothing; the system says from where it would (RFC 5737's documentation net).
    with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asked:
        asked.connect(("192.0.2.1", 9))
        found.add(str(asked.getsockname()[0]))
    return sorted(address for address in found if not address.startswith(("127.", "0.")))

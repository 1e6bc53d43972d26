"""One study served alone: participants' pages and the experimenter's, and nothing else of the studio."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.studio.application import ServerAnnouncement, serve
from tactogram.studio.context import Studio
from tactogram.studio.pages.studies.experiment_view import address_of
from tactogram.studio.participants.playing import ServerDisplay
from tactogram.studio.participants.sessions import SessionRegistry
from tactogram.studio.server.listening import ListeningPort
from tactogram.study.session.participants import checked_code
from tactogram.study.session.store import SessionStore


def run_study(
    study: Path | str,
    out: Path | str | None,
    listening: ListeningPort,
    *,
    changes: Mapping[str, Any] | None = None,
    codes: Sequence[str] = (),
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
    listening : Listening
        A port that was taken: where none can be had, no session is begun.
    changes : mapping, optional
        Values by dotted key.
    codes : sequence of str
        Participants to enrol; those that are there already are left as they are.
    open_browser : bool
    device : str
        What a study with ``played_by = "server"`` plays on: ``audio``, ``audio:NAME``, or ``null``, which plays to
        nobody.
    full_scale : float, optional
        What 1.0 of the device stands for, in the unit of the display's drive.
    ready : callable
        Called when it answers with ``experimenter`` (the page's address, with the token where one is needed), ``join``,
        ``codes`` (the address of each), ``addresses`` (others that are ``join``, too), ``certificate_sha256`` (of one
        that was made here), ``session``, ``study``.

    Raises
    ------
    TactogramError
        In one line: what is wrong with study, folder or codes.
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

    def answers(answering: ServerAnnouncement) -> None:
        best, *others = answering.roots
        ready(
            {
                "experimenter": answering.address,
                "join": f"{best}{opened.join_path}",
                "codes": {code: f"{best}{opened.take_path(code)}" for code in codes},
                "addresses": [f"{root}{opened.join_path}" for root in others],
                "certificate_sha256": answering.certificate_sha256,
                "session": str(folder),
                "study": opened.study.name,
            }
        )

    path = address_of(folder.name)
    serve(studio, listening, open_browser=open_browser, path=path, ready=answers)


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
    with closing(SessionRegistry(device=display.device, full_scale=display.full_scale)) as anywhere:
        anywhere.begin(study, folder, changes=changes)
    return folder

"""Server for a single study: the pages of participants and experimenter, without the rest of the studio."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram_studio.application import ServerAnnouncement, serve
from tactogram_studio.context import Studio
from tactogram_studio.pages.studies.experiment_view import address_of
from tactogram_studio.server.listening import ListeningPort
from tactogram_study.participants.server_display import ServerDisplay
from tactogram_study.participants.sessions import SessionRegistry
from tactogram_study.session.participants import checked_code
from tactogram_study.session.store import SessionStore


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
    track: Mapping[str, Any] | None = None,
    ready: Callable[[dict[str, Any]], None] = lambda facts: None,
) -> None:
    """Begin or continue a study session, and serve it until interrupted; parameters as the options of `study run`.

    ``study`` may be the folder of a session to continue. ``listening`` is bound beforehand: without a port, no session
    begins. Of ``codes``, existing participants are left unchanged.

    ``ready`` is called once the server accepts connections, with ``experimenter`` (address of that page, with the token
    if one is required), ``join``, ``codes`` (address per code), ``addresses`` (alternatives to ``join``),
    ``certificate_sha256`` (of a self-signed certificate), ``session``, ``study``, and ``limited`` (sentences by
    stimulus). Raises `TactogramError` if the study, folder or codes are invalid.
    """
    for code in codes:
        checked_code(code)
    display = ServerDisplay(device, full_scale, track)
    folder = _session_folder(study, out, changes, display)
    studio = Studio.at(folder.parent, study_only=True)
    opened = studio.sessions.open(folder)
    played_by = opened.study.played_by
    if played_by != "browser":
        studio.sessions.display = display
        for driven in opened.stimuli.displays:
            display.check(driven, streams=played_by == "stream")
            if played_by == "stream":
                display.lock(driven)
    limited = opened.stimuli.limited()
    opened.stimuli.start()  # prepared while the first participants read the consent page
    enrolled = {participant.code.casefold() for participant in opened.store.participants()}
    for code in codes:
        if code.casefold() not in enrolled:
            opened.store.enrol(code)

    def on_ready(announcement: ServerAnnouncement) -> None:
        best, *others = announcement.roots
        ready(
            {
                "experimenter": announcement.address,
                "join": f"{best}{opened.join_path}",
                "codes": {code: f"{best}{opened.take_path(code)}" for code in codes},
                "addresses": [f"{root}{opened.join_path}" for root in others],
                "certificate_sha256": announcement.certificate_sha256,
                "session": str(folder),
                "study": opened.study.name,
                "limited": limited,
            }
        )

    path = address_of(folder.name)
    serve(studio, listening, open_browser=open_browser, path=path, ready=on_ready)


def _session_folder(
    study: Path | str, out: Path | str | None, changes: Mapping[str, Any] | None, display: ServerDisplay
) -> Path:
    """Return the folder of an existing session, or of one begun here."""
    if Path(study).is_dir():
        if out is not None or changes:
            raise ParameterError(
                f"{study}: is an existing session, which continues unchanged: omit out and changes"
            )
        with SessionStore(Path(study)):
            return Path(study).resolve()
    if out is None:
        raise ParameterError("a new session of a study needs out, the folder to create")
    folder = Path(out).resolve()
    if folder.parent == folder:
        raise ParameterError(f"{out}: cannot be the folder of a session")
    with closing(SessionRegistry(device=display.device, full_scale=display.full_scale)) as registry:
        registry.begin(study, folder, changes=changes)
    return folder

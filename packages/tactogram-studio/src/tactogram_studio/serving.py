"""The servers that the command line starts: the studio, and a single study."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Mapping
from contextlib import AbstractContextManager, closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.cli.printing import Printer, lines_of
from tactogram.errors import ParameterError
from tactogram.parameters import Settings, checked, shares_out

if TYPE_CHECKING:
    from tactogram_studio.application import ServerAnnouncement
    from tactogram_studio.server.listening import ListeningPort
    from tactogram_study.participants.server_display import ServerDisplay


@checked
def studio(
    *,
    folder: str = ".",
    port: int = 8123,
    host: str = "127.0.0.1",
    https: bool = False,
    certificate: str | None = None,
    key: str | None = None,
    proxies: tuple[str, ...] | None = None,
    no_open: bool = False,
    show: Printer,
) -> None:
    """Open the studio in the browser: generate, touch, train, send, and run studies.

    Parameters
    ----------
    folder : str
        The workspace: folder of runs, data and studies; default the current one.
    port : int
        Port; 0 takes a free one.
    host : str
        Address to listen on, 0.0.0.0 for all; beyond this machine a token is drawn and printed.
    https : bool
        Encrypt with a certificate that is created and kept in the workspace; tablets need it for audio, camera and
        clipboard.
    certificate : str, optional
        Encrypt with a certificate of your own (a PEM file).
    key : str, optional
        The certificate's key (a PEM file); default in the same file.
    proxies : tuple of str, optional
        Addresses or networks of proxies, whose X-Forwarded-For and X-Forwarded-Proto are believed; a token is drawn.
    no_open : bool
        Do not open a browser.

    Raises
    ------
    DeviceError
        If the port is taken, or the host is not an address of this machine.
    DataError
        If a certificate cannot be used or created.
    """
    with _bound_port(host, port, https=https, certificate=certificate, key=key, proxies=proxies) as listening:
        from tactogram_studio.application import serve
        from tactogram_studio.context import Studio

        def ready(server: ServerAnnouncement) -> None:
            facts = {"studio": server.address, "certificate, SHA-256": server.certificate_sha256}
            code = "" if listening.loopback else shown_qr_code(server.address)
            show(facts, lines_of(facts) + code)
            sys.stdout.flush()
            sys.stderr.write("Ctrl-C ends it\n")

        serve(Studio.at(folder), listening, open_browser=not no_open, ready=ready)


@checked
@shares_out
def run_study(
    study: str,
    *,
    out: str | None = None,
    device: str = "audio",
    full_scale: float | None = None,
    track: Settings | None = None,
    participants: tuple[str, ...] | None = None,
    changes: Settings | None = None,
    port: int = 8123,
    host: str = "127.0.0.1",
    https: bool = False,
    certificate: str | None = None,
    key: str | None = None,
    proxies: tuple[str, ...] | None = None,
    no_open: bool = False,
    show: Printer,
) -> None:
    """Serve a study to participants and its progress to the experimenter; run again to continue.

    Parameters
    ----------
    study : str
        A study: a TOML file, or one of `study list`; or the folder of a session to continue.
    out : str, optional
        Folder of the session; created, or continued.
    device : str
        Device for played_by = 'server' or 'stream': audio, audio:NAME or null; for 'stream' also digilent or
        osc:HOST:PORT.
    full_scale : float, optional
        The device's full scale, in the unit of the display's drive.
    track : dict, optional
        Keep a Digilent's carrier at the transducer's resonance, as of `stream`.
    participants : tuple of str, optional
        Codes to enrol beforehand; otherwise people get one as they join.
    changes : dict, optional
        Change a value of the study.
    port, host, https, certificate, key, proxies, no_open
        As of `studio`.

    Raises
    ------
    TactogramError
        If the study, its folder, a code, the port or the certificate cannot be used.
    """
    from tactogram_study.study_file import Study

    if not Path(study).is_dir():
        Study.load(study, changes=changes)  # a wrong name is reported before a port in use
    with _bound_port(host, port, https=https, certificate=certificate, key=key, proxies=proxies) as listening:
        from tactogram_studio import application
        from tactogram_studio.context import Studio
        from tactogram_studio.workspace.session_view import address_of
        from tactogram_study.participants.server_display import ServerDisplay
        from tactogram_study.session.participants import checked_code
        from tactogram_study.workflows.stimuli import limited_lines

        codes = [checked_code(code) for code in participants or ()]
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
        enrolled = {participant.code.casefold() for participant in opened.store.participants()}
        for code in codes:
            if code.casefold() not in enrolled:
                opened.store.enrol(code)

        def ready(server: ServerAnnouncement) -> None:
            opened.stimuli.start()  # not before: it would slow down the restart that participants wait for
            best, *others = server.roots
            facts: dict[str, Any] = {
                "experimenter": server.address,
                "join": f"{best}{opened.join_path}",
                "codes": {code: f"{best}{opened.take_path(code)}" for code in codes},
                "addresses": [f"{root}{opened.join_path}" for root in others],
                "certificate_sha256": server.certificate_sha256,
                "session": str(folder),
                "study": opened.study.name,
                "limited": limited,
            }
            addresses = {
                "experimenter": facts["experimenter"],
                "participants": facts["join"],
                **{f"participant {code}": address for code, address in facts["codes"].items()},
                "participants, by another": facts["addresses"],
                "certificate, SHA-256": facts["certificate_sha256"],
            }
            show(facts, lines_of(addresses) + ("" if listening.loopback else shown_qr_code(facts["join"])))
            show.notes(limited_lines(limited))
            sys.stdout.flush()
            sys.stderr.write("Ctrl-C ends it; run again to continue\n")

        path = address_of(folder.name)
        application.serve(studio, listening, open_browser=not no_open, path=path, ready=ready)
    sys.stderr.write("tactogram: the study's server ended; all answers are stored\n")


def _session_folder(
    study: str, out: str | None, changes: Mapping[str, Any] | None, display: ServerDisplay
) -> Path:
    """Return the folder of an existing session, or of one begun here."""
    from tactogram_study.participants.sessions import SessionRegistry
    from tactogram_study.session.store import SessionStore

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


def _bound_port(host: str, port: int, **options: Any) -> AbstractContextManager[ListeningPort]:
    """Return the requested port, bound until the end of the ``with``; arguments are those of `open_port`."""
    from tactogram.extras import imported

    imported("nicegui", extra="studio", what="the studio")
    from tactogram_studio.server.listening import open_port

    return open_port(host, port, **options)


def shown_qr_code(address: str) -> str:
    """Return a QR code to append to the printed text; empty off a terminal, or if it does not fit."""
    from tactogram_studio.server.listening import terminal_qr_code

    if not sys.stdout.isatty():
        return ""
    code = terminal_qr_code(address, shutil.get_terminal_size().columns)
    try:
        code.encode(sys.stdout.encoding)
    except UnicodeEncodeError:
        return ""
    return f"\n{code}" if code else ""

"""The verb that opens the studio in the browser."""

import shutil
import sys
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from tactogram.cli.printing import Printer, lines_of
from tactogram.cli.verbs import Verb
from tactogram.workflows import Option, Request

if TYPE_CHECKING:
    from tactogram_studio.server.listening import ListeningPort


@dataclass(frozen=True, kw_only=True)
class ServerOptions(Request):
    """Address of a server, its encryption, and whether a browser opens."""

    port: Annotated[int, Option("port; 0 takes a free one")] = 8123
    host: Annotated[
        str,
        Option("address to listen on, 0.0.0.0 for all; beyond this machine a token is drawn and printed"),
    ] = "127.0.0.1"
    https: Annotated[
        bool,
        Option(
            "encrypt with a certificate that is created and kept in the workspace; tablets need it for audio, camera "
            "and clipboard"
        ),
    ] = False
    certificate: Annotated[str | None, Option("encrypt with a certificate of your own (PEM)", "FILE")] = None
    key: Annotated[str | None, Option("the certificate's key (PEM; default: in the same file)", "FILE")] = (
        None
    )
    open_browser: Annotated[bool, Option("do not open a browser", flag="--no-open")] = True


@dataclass(frozen=True)
class _StudioRequest(ServerOptions):
    folder: Annotated[
        str,
        Option("the workspace: folder of runs, data and studies (default: the current one)", "DIR"),
    ] = "."


def bound_port(request: ServerOptions) -> "AbstractContextManager[ListeningPort]":
    """Return the requested port, bound until the end of the ``with``."""
    from tactogram.extras import imported

    imported("nicegui", extra="studio", what="the studio")
    from tactogram_studio.server.listening import open_port

    return open_port(
        request.host, request.port, https=request.https, certificate=request.certificate, key=request.key
    )


def shown_qr_code(address: str) -> str:
    """Return a QR code to append to the printed text; empty off a terminal, or if it does not fit."""
    from tactogram_studio.server.qr_code import terminal_qr_code

    if not sys.stdout.isatty():
        return ""
    code = terminal_qr_code(address, shutil.get_terminal_size().columns)
    try:
        code.encode(sys.stdout.encoding)
    except UnicodeEncodeError:
        return ""
    return f"\n{code}" if code else ""


def _studio(request: _StudioRequest, show: Printer) -> None:
    with bound_port(request) as port:
        from tactogram_studio.application import ServerAnnouncement, serve
        from tactogram_studio.context import Studio

        def ready(server: ServerAnnouncement) -> None:
            facts = {"studio": server.address, "certificate, SHA-256": server.certificate_sha256}
            code = "" if port.loopback else shown_qr_code(server.address)
            sys.stdout.write(f"{lines_of(facts)}{code}\n")
            sys.stdout.flush()
            sys.stderr.write("Ctrl-C ends it\n")

        serve(Studio.at(request.folder), port, open_browser=request.open_browser, ready=ready)


VERBS = {"studio": Verb(_StudioRequest, _studio, folders=("models", "designs", "languages"))}

"""The verb that opens the studio in the browser."""

from __future__ import annotations

import shutil
import sys
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING

from tactogram.cli.options import Add, Verbs, designs_option, models_option
from tactogram.cli.printing import Arguments, lines_of

if TYPE_CHECKING:
    from tactogram.studio.server.listening import ListeningPort


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("studio", studio)
    server_options(add)
    add(
        "--folder",
        default=".",
        metavar="DIR",
        help="the workspace: folder of runs, data and studies (default: the current one)",
    )
    models_option(add)
    designs_option(add)


def server_options(add: Add) -> None:
    """Add where a server listens, how it is encrypted, and whether a browser opens."""
    add("--port", type=int, default=8123, help="port; 0 takes a free one (default %(default)s)")
    add(
        "--host",
        default="127.0.0.1",
        help="address to listen on, 0.0.0.0 for all; beyond this machine a token is drawn and printed "
        "(default %(default)s)",
    )
    add(
        "--https",
        action="store_true",
        help="encrypt with a certificate that is created and kept in the workspace; tablets need it for audio, "
        "camera and clipboard",
    )
    add("--certificate", metavar="FILE", help="encrypt with a certificate of your own (PEM)")
    add("--key", metavar="FILE", help="the certificate's key (PEM; default: in the same file)")
    add("--no-open", action="store_true", help="do not open a browser")


def bound_port(a: Arguments) -> AbstractContextManager[ListeningPort]:
    """Return the port that `server_options` ask for, taken until the end of the ``with``."""
    from tactogram.extras import imported

    imported("nicegui", extra="studio", what="the studio")
    from tactogram.studio.server.listening import open_port

    return open_port(a.host, a.port, https=a.https, certificate=a.certificate, key=a.key)


def shown_qr_code(address: str) -> str:
    """Return a QR code to be added to what is printed; none where that goes elsewhere, or has no room or letters."""
    from tactogram.studio.server.qr_code import terminal_qr_code

    if not sys.stdout.isatty():
        return ""
    code = terminal_qr_code(address, shutil.get_terminal_size().columns)
    try:
        code.encode(sys.stdout.encoding)
    except UnicodeEncodeError:
        return ""
    return f"\n{code}" if code else ""


def studio(a: Arguments) -> int:
    """Open the studio in the browser: generate, touch, train, send, and run studies."""
    with bound_port(a) as port:
        from tactogram.studio.application import ServerAnnouncement, serve
        from tactogram.studio.context import Studio

        def ready(answering: ServerAnnouncement) -> None:
            told = {
                "studio": answering.address,
                "certificate, SHA-256": answering.certificate_sha256,
            }
            code = "" if port.loopback else shown_qr_code(answering.address)
            sys.stdout.write(f"{lines_of(told)}{code}\n")
            sys.stdout.flush()
            sys.stderr.write("Ctrl-C ends it\n")

        serve(Studio.at(a.folder), port, open_browser=not a.no_open, ready=ready)
    return 0

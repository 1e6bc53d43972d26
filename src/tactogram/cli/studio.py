"""The verb that opens the studio in the browser."""

from __future__ import annotations

import sys

from tactogram.cli.options import Add, Verbs, models_option
from tactogram.cli.printing import Arguments


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("studio", studio)
    server_options(add)
    add(
        "--folder",
        default=".",
        metavar="DIR",
        help="the workspace: where runs, data and studies lie (default: here)",
    )
    models_option(add)


def server_options(add: Add) -> None:
    """Add where a server listens, and whether a browser opens."""
    add("--port", type=int, default=8123, help="0 takes a free one (default %(default)s)")
    add(
        "--host",
        default="127.0.0.1",
        help="what to listen on; beyond this machine a token is drawn and printed (default %(default)s)",
    )
    add("--no-open", action="store_true", help="do not open a browser")


def studio(a: Arguments) -> int:
    """Open the studio in the browser: make, touch, train, send, and studies with people."""
    from tactogram.extras import imported

    imported("nicegui", extra="studio", what="the studio")
    from tactogram.studio.server import serve
    from tactogram.studio.studio import Studio

    def ready(address: str) -> None:
        sys.stdout.write(f"studio: {address}\n")
        sys.stdout.flush()
        sys.stderr.write("Ctrl-C ends it\n")

    serve(Studio.at(a.folder), port=a.port, host=a.host, open_browser=not a.no_open, ready=ready)
    return 0

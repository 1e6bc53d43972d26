"""Serves a session's pages for participants on a free port of this machine, and says where, until it is ended."""

import contextlib
import socket
import sys
from pathlib import Path

from tactogram_studio.server.guard import RequestGuard
from tactogram_studio.server.guard_rules import GuardSettings
from tactogram_studio.server.listening import StudioServer
from tactogram_study.participants.routes import make_participant_app
from tactogram_study.participants.sessions import SessionRegistry

workspace, study, folder, changes = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]), sys.argv[4:]
sessions = SessionRegistry(workspace, device="null")
session = sessions.begin(study, folder, changes=dict(change.split("=", 1) for change in changes))


def ready():
    sys.stdout.write(f"http://127.0.0.1:{listener.getsockname()[1]}{session.join_path}\n")
    sys.stdout.flush()


app = RequestGuard(make_participant_app(sessions), GuardSettings(body_seconds=2.0))
with socket.create_server(("127.0.0.1", 0)) as listener:
    ready()
    with contextlib.suppress(KeyboardInterrupt):
        StudioServer(app).run(sockets=[listener])

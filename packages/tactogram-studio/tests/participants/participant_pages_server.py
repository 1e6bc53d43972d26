"""Serves every study (`*.toml`) of a folder to participants, each with a session beside it, and says where."""

import contextlib
import json
import socket
import sys
from pathlib import Path

from tactogram_studio.server.guard import RequestGuard
from tactogram_studio.server.guard_rules import GuardSettings
from tactogram_studio.server.listening import StudioServer
from tactogram_study.participants.routes import make_participant_app
from tactogram_study.participants.sessions import SessionRegistry

folder, port = Path(sys.argv[1]), int(sys.argv[2])
sessions = SessionRegistry(folder, device="null")
opened = {path.stem: sessions.begin(path, folder / path.stem) for path in sorted(folder.glob("*.toml"))}


def ready():
    joins = {name: session.join_path for name, session in opened.items()}
    sys.stdout.write(json.dumps([listener.getsockname()[1], joins]) + "\n")
    sys.stdout.flush()


app = RequestGuard(make_participant_app(sessions), GuardSettings(body_seconds=2.0))
with socket.create_server(("127.0.0.1", port)) as listener:
    ready()
    with contextlib.suppress(KeyboardInterrupt):
        StudioServer(app).run(sockets=[listener])

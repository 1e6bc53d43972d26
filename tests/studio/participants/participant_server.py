"""Serves a session's pages for participants on a free port of this machine, and says where, until it is ended."""

import sys
from pathlib import Path

import uvicorn

from tactogram.studio.guard import Guard
from tactogram.studio.guard_rules import Guarding
from tactogram.studio.participants.routes import make_participant_app
from tactogram.studio.participants.sessions import Sessions

workspace, study, folder, changes = Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]), sys.argv[4:]
sessions = Sessions(workspace, device="null")
session = sessions.begin(study, folder, changes=dict(change.split("=", 1) for change in changes))


class Server(uvicorn.Server):
    async def startup(self, sockets=None):
        await super().startup(sockets=sockets)
        port = self.servers[0].sockets[0].getsockname()[1]
        sys.stdout.write(f"http://127.0.0.1:{port}{session.join_path}\n")
        sys.stdout.flush()


app = Guard(make_participant_app(sessions), Guarding(body_seconds=2.0))
Server(
    uvicorn.Config(app, port=0, log_level="error", access_log=False, server_header=False, http="h11")
).run()

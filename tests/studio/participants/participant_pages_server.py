"""Serves every study (`*.toml`) of a folder to participants, each with a session beside it, and says where."""

import json
import sys
from pathlib import Path

import uvicorn

from tactogram.studio.guard import Guard
from tactogram.studio.guard_rules import Guarding
from tactogram.studio.participants.routes import make_participant_app
from tactogram.studio.participants.sessions import Sessions

folder, port = Path(sys.argv[1]), int(sys.argv[2])
sessions = Sessions(folder, device="null")
opened = {path.stem: sessions.begin(path, folder / path.stem) for path in sorted(folder.glob("*.toml"))}


class Server(uvicorn.Server):
    async def startup(self, sockets=None):
        await super().startup(sockets=sockets)
        port = self.servers[0].sockets[0].getsockname()[1]
        joins = {name: session.join_path for name, session in opened.items()}
        sys.stdout.write(json.dumps([port, joins]) + "\n")
        sys.stdout.flush()


app = Guard(make_participant_app(sessions), Guarding(body_seconds=2.0))
Server(uvicorn.Config(app, port=port, log_level="error", access_log=False, server_header=False)).run()

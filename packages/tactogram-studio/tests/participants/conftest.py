"""Small studies with files of their own, and the pages for participants over them, behind the guard."""

import asyncio
import contextlib
import socket
import subprocess
import sys
import threading
from pathlib import Path

import httpx
import numpy as np
import pytest
import tomli_w

from tactogram.signal import Image, Signal
from tactogram.signal.io import write_image, write_signal
from tactogram_studio.server.guard import RequestGuard
from tactogram_studio.server.guard_rules import GuardSettings
from tactogram_studio.server.listening import StudioServer
from tactogram_study.participants.routes import make_participant_app
from tactogram_study.participants.sessions import SessionRegistry

LOCAL = "http://127.0.0.1"
SETTINGS = GuardSettings(body_seconds=1.0)
DESIGNS = {
    "abx": {"kind": "abx", "repeats": 4},
    "rating": {"kind": "rating", "words": ["rough", "dry"]},
    "staircase": {"kind": "staircase", "most_trials": 12, "reversals": 4, "steps_db": [4.0]},
}
ITEMS, VERSIONS = ("cork", "tile"), ("recorded", "generated")


def write_study(folder, design="abx", **changes):
    """Write a study with four stimuli of 0.1 s, each with a picture, and return its file."""
    rng = np.random.default_rng(0)
    stimuli = []
    for item in ITEMS:
        for version in VERSIONS:
            name = f"{item}-{version}"
            signal = Signal(rng.standard_normal(800), 8000.0, "1")
            write_signal(folder / "files" / f"{name}.wav", signal)
            write_image(folder / "files" / f"{name}.png", Image(rng.integers(0, 255, (5, 7, 3), np.uint8)))
            files = {"file": f"files/{name}.wav", "image": f"files/{name}.png"}
            stimuli.append({"name": name, "item": item, "condition": version, **files})
    values = {
        "name": "small",
        "title": {"ja": "小さな研究", "en": "Small"},
        "consent": "Do you agree?",
        "seed": 3,
        "level": "gain=0.05",
        "design": DESIGNS[design] if isinstance(design, str) else design,
        "stimuli": stimuli,
        "before": [
            {"id": "hand", "text": "Hand?", "kind": "choice", "options": [{"value": "r"}, {"value": "l"}]}
        ],
        "after": [{"id": "comment", "text": "Else?", "kind": "text", "required": False}],
    }
    path = folder / "small.toml"
    path.write_text(tomli_w.dumps(values | changes), encoding="utf-8")
    return path


@contextlib.contextmanager
def served_here(app, context=None, **options):
    """Serve an application in a thread, over TLS with a context, and give its address."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        server = StudioServer(app, context=context, **options)
        thread = threading.Thread(target=server.run, args=([listener],), daemon=True)
        thread.start()
        yield f"{'http' if context is None else 'https'}://127.0.0.1:{listener.getsockname()[1]}"
        server.should_exit = True
        thread.join(5)
        assert not thread.is_alive()


@contextlib.contextmanager
def serving(sessions, settings=SETTINGS):
    """Give a browser's client to sessions that are served behind the guard."""
    with (
        served_here(RequestGuard(make_participant_app(sessions), settings)) as address,
        httpx.Client(base_url=address, timeout=60) as client,
    ):
        yield client


class InProcess:
    """A browser's client to an application in this process, without a socket; any thread may ask."""

    def __init__(self, app, loop):
        self._loop = loop
        self._client = httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url=LOCAL)

    def request(self, method, path, **options):
        asked = self._client.request(method, path, **options)
        return asyncio.run_coroutine_threadsafe(asked, self._loop).result(60)

    def get(self, path, **options):
        return self.request("GET", path, **options)

    def post(self, path, **options):
        return self.request("POST", path, **options)


class Person:
    """Somebody with a browser who takes a study, one page after the other."""

    def __init__(self, client, join_path, **body):
        self.client = client
        answered = client.post(join_path, json={"language": "en", **body})
        assert answered.status_code == 200, answered.text
        self.code, self.ticket = answered.json()["code"], answered.json()["ticket"]

    def get(self, what, **query):
        return self.client.get(f"/take/{self.ticket}/{what}", params=query)

    def post(self, what, **body):
        return self.client.post(f"/take/{self.ticket}/{what}", json=body)

    def page(self):
        return self.get("page").json()["page"]

    def answer(self, page=None, **more):
        """Answer a page, by default the present one, and return what came back."""
        page = page or self.page()
        given = {question["key"]: some_answer(question) for question in page["questions"]}
        return self.post("answers", token=page["token"], answers=given, rt_ms={"": 700.0}, **more)

    def go_to(self, kind):
        """Answer pages until one of a kind is there, and return it."""
        page = self.page()
        while page["kind"] != kind:
            page = self.answer(page).json()["page"]
        return page


def some_answer(question):
    if question["options"]:
        return question["options"][0]["value"]
    return "fine" if question["kind"] == "text" else str(question["low"] or 1)


@contextlib.contextmanager
def process_over(workspace, study, folder, *changes):
    """Run a real server over a session, and give its process and the address at which people join."""
    script = Path(__file__).parent / "participant_server.py"
    with subprocess.Popen(
        [sys.executable, str(script), str(workspace), str(study), str(folder), *changes],
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            address = process.stdout.readline().strip()
            assert address.startswith(LOCAL), "the server did not start"
            yield process, address
        finally:
            process.kill()


@pytest.fixture(name="write_study")
def write_study_fixture():
    return write_study


@pytest.fixture(name="write_study_once", scope="session")
def write_study_once_fixture():
    return write_study


@pytest.fixture(name="serving", scope="session")
def serving_fixture():
    return serving


@pytest.fixture(name="served_here", scope="session")
def served_here_fixture():
    return served_here


@pytest.fixture(name="process_over", scope="session")
def process_over_fixture():
    return process_over


@pytest.fixture(name="person", scope="session")
def person_fixture():
    return Person


@pytest.fixture(scope="session")
def loop():
    """Give an event loop that runs in a thread."""
    running = asyncio.new_event_loop()
    thread = threading.Thread(target=running.run_forever, daemon=True)
    thread.start()
    yield running
    running.call_soon_threadsafe(running.stop)
    thread.join()
    running.close()


@pytest.fixture
def opened(loop):
    """Give a function that opens a study in a folder: sessions, session, and a browser's client."""
    with contextlib.ExitStack() as stack:

        def open_study(workspace, design="abx", **changes):
            study = write_study(workspace, design, **changes)
            sessions = SessionRegistry(workspace, device="null")
            stack.callback(sessions.close)
            session = sessions.begin(study, workspace / "session")
            return sessions, session, client_of(sessions)

        def client_of(sessions):
            return InProcess(RequestGuard(make_participant_app(sessions), SETTINGS), loop)

        open_study.client_of = client_of
        yield open_study

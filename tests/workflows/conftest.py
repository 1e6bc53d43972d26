"""A stand-in for the Hugging Face Hub, and runs trained on simulated ratings."""

import base64
import hashlib
import json
import pickle
import re
import sys
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from tactogram.datasets import create_store
from tactogram.datasets.ratings.ratings import EVOKED, Ratings
from tactogram.signal import Image
from tactogram.workflows.workers.one_task import attempted

sys.path.append(str(Path(__file__).parent))  # made_up_*

# -- a stand-in for the Hugging Face Hub ---------------------------------------------------------------------

COMMIT = "c" * 40


class Hub(ThreadingHTTPServer):
    """Repositories: files by path by name, models as ``OWNER/NAME``, data sets as ``datasets/OWNER/NAME``."""

    daemon_threads = True

    def __init__(self):
        super().__init__(("127.0.0.1", 0), Handler)
        self.repositories, self.asked = {}, []

    @property
    def url(self):
        return f"http://127.0.0.1:{self.server_port}"


class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def log_message(self, *args):
        pass

    def answer(self, values, status=200, headers=()):
        body = values if isinstance(values, bytes) else json.dumps(values).encode()
        self.send_response(status)
        for name, value in (("Content-Length", str(len(body))), *headers):
            self.send_header(name, value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def do_POST(self):
        self.server.asked.append(f"POST {self.path}")
        length = int(self.headers.get("Content-Length") or 0)
        if self.headers.get("Transfer-Encoding") == "chunked":
            body = b""
            while size := int(self.rfile.readline(), 16):
                body += self.rfile.read(size)
                self.rfile.readline()
            self.rfile.readline()
        else:
            body = self.rfile.read(length)
        if self.headers.get("Authorization") != "Bearer hf_test":
            return self.answer({"error": "no token"}, 401)
        if self.path == "/api/repos/create":
            wanted = json.loads(body)
            prefix = "datasets/" if wanted.get("type") == "dataset" else ""
            name = f"{prefix}{wanted.get('organization', 'lab')}/{wanted['name']}"
            self.server.repositories.setdefault(name, {})
            return self.answer({"url": f"{self.server.url}/{name}", "name": name.removeprefix(prefix)})
        if self.path.startswith("/api/validate-yaml"):
            return self.answer({"errors": [], "warnings": []})
        kind, name, action = re.fullmatch(
            r"/api/(models|datasets)/(\w+/\w+)/(\w+)/main.*", self.path
        ).groups()
        files = self.server.repositories[name if kind == "models" else f"datasets/{name}"]
        if action == "preupload":
            entries = json.loads(body)["files"]
            found = [{"path": e["path"], "uploadMode": "regular", "shouldIgnore": False} for e in entries]
            return self.answer({"files": found})
        for line in body.splitlines():
            entry = json.loads(line)
            if entry["key"] == "file":
                files[entry["value"]["path"]] = base64.b64decode(entry["value"]["content"])
        url = f"{self.server.url}/{name}/commit/{COMMIT}"
        return self.answer({"commitUrl": url, "commitOid": COMMIT, "success": True})

    def do_GET(self):
        self.server.asked.append(f"{self.command} {self.path}")
        info = re.fullmatch(r"/api/(models|datasets)/(\w+/\w+)(/revision/\w+)?(\?.*)?", self.path)
        if info:
            name = info[2] if info[1] == "models" else f"datasets/{info[2]}"
            if name not in self.server.repositories:
                headers = [("X-Error-Code", "RepoNotFound"), ("X-Error-Message", "Repository not found")]
                return self.answer({"error": "Repository not found"}, 404, headers)
            siblings = [{"rfilename": path} for path in self.server.repositories[name]]
            return self.answer({"id": info[2], "sha": COMMIT, "siblings": siblings, "private": False})
        listed = re.fullmatch(r"/api/(models|datasets)/(\w+/\w+)/tree/\w+(\?.*)?", self.path)
        if listed:
            files = self.server.repositories[listed[2] if listed[1] == "models" else f"datasets/{listed[2]}"]
            return self.answer(
                [
                    {
                        "type": "file",
                        "path": path,
                        "size": len(content),
                        "oid": hashlib.sha1(content).hexdigest(),
                    }
                    for path, content in files.items()
                ]
            )
        found = re.fullmatch(r"/((?:datasets/)?\w+/\w+)/resolve/\w+/(.+)", self.path)
        if found and found[2] in self.server.repositories.get(found[1], {}):
            content = self.server.repositories[found[1]][found[2]]
            etag = f'"{hashlib.sha256(content).hexdigest()}"'
            return self.answer(content, headers=[("ETag", etag), ("X-Repo-Commit", COMMIT)])
        return self.answer({"error": "not found"}, 404, [("X-Error-Code", "EntryNotFound")])

    do_HEAD = do_GET  # noqa: N815


@pytest.fixture
def hub(monkeypatch):
    """An empty hub on the loopback interface, to which `huggingface_hub` is pointed."""
    server = Hub()
    thread = Thread(target=server.serve_forever, daemon=True)
    thread.start()
    monkeypatch.setenv("HF_ENDPOINT", server.url)
    monkeypatch.setenv("HF_TOKEN", "hf_test")
    yield server
    server.shutdown()
    server.server_close()
    thread.join()


# -- runs trained on simulated ratings -----------------------------------------------------------------------


@pytest.fixture(scope="session")
def image_run(tmp_path_factory):
    """A trained, tiny generator of images; simulated."""
    from made_up_runs import WORDS

    from tactogram.workflows.training.train import train  # loads torch

    folder = tmp_path_factory.mktemp("images")
    rng = np.random.default_rng(0)
    items = [f"image{n}" for n in range(8)]
    rows = [
        (rater, item, word, float(rng.integers(0, 2))) for rater in "ab" for item in items for word in WORDS
    ]
    columns = [list(column) for column in zip(*rows, strict=True)]
    shown = [(item, Image(rng.integers(0, 256, (20, 20, 3), np.uint8))) for item in items]
    create_store(
        folder / "store",
        [],
        name="images",
        licence="-",
        simulated=True,
        ratings=Ratings(*columns[:3], np.array(columns[3]), EVOKED),
        photographs=shown,
    )
    done = train("tactile_image_cgan", folder / "store", recipe="tiny", out=folder / "run", accelerator="cpu")
    return done.folder


@pytest.fixture(scope="session")
def image_rater(image_run):
    """A rater model of such images."""
    from tactogram.workflows.training.loaded_run import load_run
    from tactogram.workflows.training.train import train

    store = load_run(image_run).run.data["path"]
    return train(
        "rater", store, recipe="tiny", out=image_run.parent / "rater", accelerator="cpu"
    ).folder  # fmt: skip


@pytest.fixture(scope="session")
def rated(tmp_path_factory):
    """A store of rated vibrations; simulated."""
    from made_up_ratings import rated_store

    return rated_store(tmp_path_factory.mktemp("rated") / "s")


@pytest.fixture(scope="session")
def rater_run(rated, tmp_path_factory):
    """A rater model of these."""
    from tactogram.workflows.training.train import train  # loads torch

    out = tmp_path_factory.mktemp("runs") / "rater"
    return train("rater", rated, recipe="tiny", out=out, accelerator="cpu").folder


@pytest.fixture
def pickled_tasks(monkeypatch):
    """Run the tasks of several processes here, one by one, as pickles; give the list of those that ran."""
    ran = []

    def sent(function, tasks, processes):
        for task in tasks:
            ran.append(task)
            there, given = pickle.loads(pickle.dumps((function, task)))  # noqa: S301
            yield task, pickle.loads(pickle.dumps(attempted(there, given)))  # noqa: S301

    monkeypatch.setattr("tactogram.workflows.workers.tasks._in_processes", sent)
    return ran

"""The fuzzer of routes finds planted faults; a minute of it finds none in the servers."""

import asyncio
import json
import logging
import os
import subprocess
import sys
from pathlib import Path

import pytest
from fastapi import FastAPI, Response, WebSocket
from tests.fuzz.routes import Fuzzer, Made, routes_of

ROOT = Path(__file__).parents[2]


@pytest.fixture
def faulty():
    """Give an application with a fault on each route."""
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)

    @app.get("/raises/{name}")
    def raises(name: str):
        return int(name)

    @app.get("/refuses")
    def refuses():
        return Response("two\nlines", 400)

    @app.get("/tells")
    def tells():
        return Response("no such file: /secret/place/x", 404)

    @app.get("/logs")
    def logs():
        logging.getLogger("tests").error("a %s", "fault")

    @app.websocket("/socket")
    async def socket(connection: WebSocket):
        await connection.accept()
        int(await connection.receive_text())

    return app


@pytest.mark.parametrize(
    ("made", "wrong"),
    [
        (Made("/raises/7"), None),
        (Made("/raises/x"), "raised ValueError"),
        (Made("/refuses"), "status 400 without one line: 'two\\nlines'"),
        (Made("/tells"), "told /secret/place"),
        (Made("/logs"), "logged a fault"),
        (Made("/socket", messages=("nan",)), "raised ValueError"),
        (Made("/socket", messages=("7",)), None),
    ],
)
def test_a_planted_fault_is_found(faulty, made, wrong):
    fuzzer = Fuzzer(faulty, routes_of(faulty), {}, seed=0, hidden=("/secret/place",))
    asyncio.run(fuzzer.judged(made))
    found = [line for finding in fuzzer.findings for line in finding["wrong"]]
    assert [line.startswith(wrong or "") for line in found] == ([True] if wrong else [])


def test_every_route_is_known(faulty):
    assert [path for path, *_ in routes_of(faulty)] == [
        "/raises/{name}",
        "/refuses",
        "/tells",
        "/logs",
        "/socket",
    ]


def test_requests_follow_from_the_seed(faulty):
    known = {"names": ["of"], "messages": ["40"]}
    made = [
        [Fuzzer(faulty, routes_of(faulty), known, seed=seed).made() for seed in range(50)] for _ in range(2)
    ]
    assert made[0] == made[1]
    assert len(set(made[0])) > 40


@pytest.mark.slow
def test_a_minute_of_requests_finds_nothing(tmp_path):
    command = [
        sys.executable,
        "-m",
        "tests.fuzz.routes",
        "--minutes",
        "1",
        "--out",
        str(tmp_path / "found.json"),
    ]
    run = subprocess.run(command, cwd=ROOT, env=os.environ, check=False, capture_output=True, text=True)
    found = json.loads((tmp_path / "found.json").read_text())
    assert [server["findings"] for server in found.values()] == [[], []], run.stderr[-2000:]
    assert min(server["requests"] for server in found.values()) > 100

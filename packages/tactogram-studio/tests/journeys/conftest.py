"""Journeys: what five kinds of newcomers do first, as they would, with the time that each step took.

`pytest packages/tactogram-studio/tests/journeys -s` prints the times; nothing depends on them.
"""

import os
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest


def pytest_collection_modifyitems(items):
    """Mark all journeys as slow."""
    for item in items:
        if "journeys" in item.path.parts:
            item.add_marker("slow")


@pytest.fixture
def step(request, capsys):
    """Give a context that measures a step; all are printed at the end."""
    steps = []

    @contextmanager
    def measured(name):
        began = time.perf_counter()
        yield
        steps.append((name, time.perf_counter() - began))

    yield measured
    lines = [f"{seconds:8.1f} s  {name}" for name, seconds in (*steps, ("in all", sum(s for _, s in steps)))]
    with capsys.disabled():
        print(f"\n{request.node.name}", *lines, sep="\n")  # noqa: T201


@pytest.fixture
def tactogram(tmp_path):
    """Give a function that runs a command line in an empty folder, checks its status and returns what it printed."""

    def run(line, *, status=0):
        done = subprocess.run(
            [sys.executable, "-m", "tactogram", *line.split()],
            cwd=tmp_path,
            env={"OMP_NUM_THREADS": "1", **os.environ, "PYTHONWARNINGS": "default"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == status, done.stdout + done.stderr
        return done.stdout + done.stderr

    return run

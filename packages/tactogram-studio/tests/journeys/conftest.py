"""Journeys: what newcomers do first, at the command line or in the studio, with the time that each step took.

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


@pytest.fixture
def page(browser, served, watched, tmp_path):
    """Give a page of a studio that was started in the empty folder ``studio``."""
    folder = tmp_path / "studio"
    folder.mkdir()
    arguments = ("studio", "--port", "0", "--no-open", "--folder", ".")
    with served(*arguments, folder=folder, prefix="studio: ") as (_, address):
        context = browser.new_context(base_url=address, viewport={"width": 1440, "height": 900})
        with watched(context, address) as opened:
            yield opened
        context.close()


@pytest.fixture
def saved(page, tmp_path):
    """Give a function that presses what downloads a file, and returns the file."""

    def save(press):
        with page.expect_download() as download:
            press.click()
        file = tmp_path / download.value.suggested_filename
        download.value.save_as(file)
        return file

    return save

import json
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram_study.session.progress import next_page
from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.simulated_participants import SimulatedParticipant, simulate
from tactogram_study.study_file import Study
from tactogram_study.trials import PageAnswers, Participant

sys.path.append(str(Path(__file__).parent))  # simulated_answers

STUDY_FILE = """
title = "Small"
consent = "Do you agree?"
level = "gain=0.1"
[design]
kind = "staircase"
most_trials = 4
[[stimuli]]
name = "buzz"
file = "buzz.wav"
"""
ANYBODY = Participant("P1", 1)

DESIGNS = {
    "two_area": {"kind": "two_area", "repeats": 2},
    "rating": {"kind": "rating", "words": ["rough", "dry"]},
    "evoked": {"kind": "evoked", "set_size": 3, "words": ["rough", "dry"]},
    "abx": {"kind": "abx", "repeats": 4},
    "staircase": {"kind": "staircase", "most_trials": 12, "reversals": 4, "steps_db": [4.0]},
    "magnitude": {"kind": "magnitude", "repeats": 2},
    "pairwise": {"kind": "pairwise", "comparisons": 6},
}


def make_study(design="abx", **changes):
    stimuli = [
        {"name": f"{item}-{version}", "item": item, "condition": version, "file": "a.wav", "image": "a.png"}
        for item in ("cork", "tile")
        for version in ("recorded", "generated")
    ]
    values = {
        "name": "small",
        "title": "Small",
        "consent": "Do you agree?",
        "seed": 3,
        "design": DESIGNS[design] if isinstance(design, str) else design,
        "stimuli": stimuli,
        "before": [
            {"id": "hand", "text": "Hand?", "kind": "choice", "options": [{"value": "r"}, {"value": "l"}]}
        ],
        "after": [{"id": "comment", "text": "Else?", "kind": "text", "required": False}],
    }
    return Study.of(values | changes)


@pytest.fixture(name="make_study")
def make_study_fixture():
    return make_study


@pytest.fixture
def store(tmp_path):
    with SessionStore(tmp_path / "session", make_study()) as opened:
        yield opened


@pytest.fixture(name="make_study_once", scope="session")
def make_study_once_fixture():
    return make_study


@pytest.fixture(scope="session")
def bids_issues():
    """Return what the official validator finds: errors, and columns that no sidecar describes."""
    validator = Path(sys.executable).with_name("bids-validator-deno")

    def issues(folder):
        done = subprocess.run(
            [validator, folder, "--format", "json"], check=False, capture_output=True, text=True
        )
        return sorted(
            f"{issue['code']} {issue.get('subCode', '')}".strip()
            for issue in json.loads(done.stdout)["issues"]["issues"]
            if issue["severity"] == "error" or issue["code"] == "TSV_ADDITIONAL_COLUMNS_UNDEFINED"
        )

    return issues


@pytest.fixture
def taken():
    """Return all pages of a simulated participant, and what came back from each."""

    def take(study, participant=ANYBODY, effect=None, seed=0):
        simulated = SimulatedParticipant(effect or SimulatedEffect(), (seed, participant.number))
        pages, given = [], []
        while (page := next_page(study, participant, given)) is not None:
            pages.append(page)
            given.append(PageAnswers(page.token, page.accepted(simulated.answer(page)), page.more))
        return pages, given

    return take


@pytest.fixture
def trials():
    """Return the pages of trials among all."""
    return lambda pages: [page for page in pages if page.kind not in ("consent", "questions")]


@pytest.fixture
def study_file(tmp_path):
    t = np.arange(500) / 1000
    write_signal(tmp_path / "buzz.wav", Signal(np.sin(2 * np.pi * 80 * t), 1000, "m/s^2"))
    path = tmp_path / "small.toml"
    path.write_text(STUDY_FILE)
    return path


@pytest.fixture
def printed(capsys):
    """Return the JSON that a command prints."""

    def run(*arguments):
        assert main([*map(str, arguments), "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    return run


@pytest.fixture(scope="session")
def whole(tmp_path_factory, make_study_once):
    """Return a session of eight simulated participants, and its answers."""
    folder = tmp_path_factory.mktemp("salvage") / "whole"
    with SessionStore(folder, make_study_once({"kind": "abx", "repeats": 8})) as store:
        simulate(store, 8)
        store.compact()
        return folder, store.answers()


@pytest.fixture
def damaged(whole, tmp_path):
    """Return a function that copies the session, and changes the bytes of its file or its tables."""

    def make(change=None, *, statements=()):
        folder = tmp_path / "pilot"
        shutil.copytree(whole[0], folder, dirs_exist_ok=True)
        path = folder / "answers.sqlite"
        if change is not None:
            path.write_bytes(change(path.read_bytes()))
        with closing(sqlite3.connect(path)) as rows:
            for statement in statements:
                rows.execute(statement)
            rows.commit()
        return folder

    return make

"""The whole chain, on simulated devices: plan, device, store, raw log, live recognition, command line."""

import io
import os
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram.datasets.store.store import problems
from tactogram.workflows.training.loaded_run import load_run
from tactogram_capture import read_log
from tactogram_capture.session.take import restored
from tactogram_capture.workflows.session import capture, with_log

PLAN = """
materials = ["cork", "tile"]
speeds_mm_s = [100]
seconds = 0.4
countdown_s = 0
metronome = false
rate = 330
limits.most_lost = 0.5
"""


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(PLAN)
    return path


def as_parsed_offline(result):
    """Tell whether every take is what the raw log of its run holds, read by the parser alone."""
    store = open_store(result["store"])
    logs = {path.name: read_log(path)[0] for path in Path(result["folder"]).glob("raw-*.log")}
    same = []
    for info in store.index:
        take = restored(store.read(info.id))
        first = int(info.labels["first_index"])
        offline = logs[info.labels["log"]].samples[:, first : first + take.shape[1]]
        same.append(np.array_equal(take, offline, equal_nan=True))
    return same


def test_a_session_over_a_lossy_radio_is_what_its_log_says_and_sounds_as_it_should(
    tmp_path, plan, store, run
):
    address = f"played:{store}?loss=0.05&jitter_s=0.002&seed=3"
    result = capture(plan, source=address, data=tmp_path / "mine", yes=True, recognise=run.folder)
    assert (result["accepted"], result["left"], result["simulated"]) == (2, 0, True)
    assert as_parsed_offline(result) == [True, True]
    recorded = open_store(tmp_path / "mine")
    assert recorded.simulated
    assert {info.material for info in recorded.index} == {"cork", "tile"}
    assert result["session"] == "plan"
    signals = [recorded.signal(info.id, "acceleration") for info in recorded.index]
    assert [(s.rate, len(s)) for s in signals] == [(330.0, 132)] * 2
    # Each was stroked as the plan asked, so the classifier names it.
    loaded = load_run(run.folder)
    named = [
        loaded.kind.materials[int(np.argmax(loaded.model.probabilities(loaded.prepare(s))))] for s in signals
    ]
    assert named == [info.material for info in recorded.index]


def test_a_raw_log_is_kept_where_there_are_bytes_to_keep(tmp_path):
    log = tmp_path / "a b&c.log"
    assert with_log("twelite:/dev/ttyUSB0", log).startswith("twelite:/dev/ttyUSB0?log=")
    assert "&log=" in with_log("simulated:twelite?loss=0.02", log)
    assert with_log("twelite:/x?log=mine.log", log) == "twelite:/x?log=mine.log"
    assert with_log("lsl:NAME", log) == "lsl:NAME"


def test_answers_from_a_script_drive_a_session(tmp_path, plan, store):
    answers = io.StringIO("b\nr\na\nb\ns\n")
    result = capture(
        plan, source=f"played:{store}?seed=5", data=tmp_path / "mine", session="first", answers=answers
    )
    assert (result["accepted"], result["redone"], result["skipped"], result["left"]) == (1, 1, 1, 0)
    assert Path(result["folder"]) == tmp_path / "mine.sessions" / "first"


def test_a_session_that_is_killed_goes_on(tmp_path, plan, store):
    """The process itself, with its device, its log and its diary, and SIGKILL in the middle of a take."""
    plan.write_text(PLAN.replace('"cork", "tile"', '"cork", "foam", "tile"'))
    address = f"played:{store}?loss=0.05&seed=8"
    told, tells = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(told)
            sys.stderr = os.fdopen(tells, "w")
            main(["capture", str(plan), "--source", address, "--data", str(tmp_path / "mine"), "--yes"])
        finally:
            os._exit(1)
    os.close(tells)
    with os.fdopen(told) as lines:
        for line in lines:
            if line.startswith("take 2 of 3") and line.rstrip().endswith("recording"):
                os.kill(child, signal.SIGKILL)
                break
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
    assert len(open_store(tmp_path / "mine")) == 1
    result = capture(plan, source=f"played:{store}?loss=0.05&seed=9", data=tmp_path / "mine", yes=True)
    assert (result["accepted"], result["left"]) == (2, 0)
    assert problems(open_store(tmp_path / "mine")) == []
    assert [path.name for path in sorted(Path(result["folder"]).iterdir())] == [
        "raw-001.log", "raw-002.log", "session.jsonl",
    ]  # fmt: skip
    assert as_parsed_offline(result) == [True] * 3

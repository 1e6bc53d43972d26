"""The whole chain, on simulated devices: plan, device, store, raw log, live recognition, command line."""

import io
import json
import os
import re
import signal
import sys
from pathlib import Path

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import open_store
from tactogram.datasets.store.store import problems
from tactogram.errors import ParameterError
from tactogram.workflows.training.loaded_run import load_run
from tactogram_capture import read_log
from tactogram_capture.live.classifier import LiveClassifier
from tactogram_capture.session.take import restored
from tactogram_capture.workflows.live import live
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


def test_the_device_is_recognised_live(store, run):
    guesses = []
    result = live(
        run.folder,
        source=f"played:{store}?materials=cork&loss=0.02&seed=3",
        hop=0.1,
        seconds=1.5,
        on_window=guesses.append,
    )
    assert result["judged"] == len(guesses) >= 5
    assert result["materials"]["cork"] > 0.6 * result["judged"]
    assert result["latency"]["windows"] == result["windows"]
    assert 0 < result["latency"]["p50_ms"] <= result["latency"]["p99_ms"] <= result["latency"]["max_ms"]
    assert result["simulated"]
    assert result["window_s"] == pytest.approx(34 / 330)
    assert result["threshold"] > 0
    assert all(sum(g.classification.probabilities.values()) == pytest.approx(1) for g in guesses)


def test_a_window_is_prepared_as_the_run_was_trained_and_other_rates_are_resampled(run, texture):
    loaded = load_run(run.folder)
    listener = LiveClassifier(loaded)
    signal = texture("tile", 5, seconds=listener.window_s)
    expected = loaded.model.probabilities(loaded.prepare(signal))
    assert list(listener(signal).probabilities.values()) == pytest.approx(expected.tolist())
    other = listener(texture("cork", 6, seconds=0.2, rate=500.0))
    assert sum(other.probabilities.values()) == pytest.approx(1)


def test_none_of_these_is_set_on_windows_as_long_as_those_that_are_heard(run, texture):
    listener = LiveClassifier(load_run(run.folder), window_s=0.5)
    assert listener.calibrated_on > 5
    loud = texture("tile", 7, seconds=0.5)
    odd = loud.with_samples(40 * (loud.samples - loud.samples.mean(axis=1, keepdims=True)))
    assert listener(odd).none_of_these
    assert sum(bool(listener(texture("tile", s, seconds=0.5)).none_of_these) for s in range(100, 120)) <= 6


def test_what_cannot_listen_is_refused(run):
    loaded = load_run(run.folder)
    with pytest.raises(ParameterError, match="window must be at least 0.103 s"):
        LiveClassifier(loaded, window_s=0.05)
    with pytest.raises(ParameterError, match="a source must be one of"):
        live(loaded, source="nothing:here")
    with pytest.raises(ParameterError, match="hop"):
        live(loaded, source="simulated:twelite", hop=0.0)


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


@pytest.mark.parametrize("arguments", [["--list"], ["--list", "--json"]])
def test_capture_lists_its_plans(arguments, capsys):
    assert main(["capture", *arguments]) == 0
    assert "saga-classification" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (
            ["capture", "first-try", "--source", "twelite:/dev/no-such-port", "--data", "D", "--yes"],
            "no-such-port",
        ),
        (["capture", "nothing", "--source", "simulated:twelite", "--data", "D"], "no such session plan"),
        (["capture", "first-try", "--source", "x", "--data", "D", "--yes"], "a source must be one of"),
        (["live", "no-run", "--source", "simulated:twelite"], "no-run"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(arguments, match, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 1
    said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("tactogram: ")]
    assert len(said) == 1
    assert re.search(match, said[0])
    assert list(tmp_path.iterdir()) == []


def test_live_prints_a_line_of_json_per_window_and_a_summary(store, run, capsys):
    address = f"played:{store}?materials=tile&seconds=0.8"
    assert main(["live", str(run.folder), "--source", address, "--hop", "0.2", "--json"]) == 0
    *windows, last = map(json.loads, capsys.readouterr().out.splitlines())
    assert len(windows) == last["summary"]["windows"] >= 2
    assert set(windows[0]) == {
        "material", "probabilities", "none_of_these", "end_index", "time_s", "lost", "level", "latency_s", "skipped",
    }  # fmt: skip
    assert set(windows[0]["probabilities"]) == {"cork", "foam", "tile"}


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


def test_live_says_what_the_columns_of_a_board_are_before_it_refuses_their_unit(tmp_path, run, capsys):
    counts = np.random.default_rng(5).normal(0, 3000, (660, 3)).astype(int)
    rows = "".join(f"{3000 * n},{x},{y},{16384 + z}\n" for n, (x, y, z) in enumerate(counts))
    path = tmp_path / "board.txt"
    path.write_text(f"t_us,ax,ay,az\n{rows}")

    assert main(["live", str(run.folder), "--source", f"log:{path}"]) == 1
    *notes, error = capsys.readouterr().err.splitlines()
    remedy = re.search(r"read as counts;.*`'(.*)'`", "\n".join(notes))[1]
    assert "signal must be 330 Hz, m/s^2, axes x,y,z; got 330 Hz, 1, axes x,y,z" in error
    assert main(["live", str(run.folder), "--source", remedy]) == 0

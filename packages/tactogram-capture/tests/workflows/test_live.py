"""Live recognition of simulated devices, from Python and from the command line."""

import json
import re

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.errors import ParameterError
from tactogram.workflows.training.loaded_run import load_run
from tactogram_capture.live.classifier import LiveClassifier
from tactogram_capture.workflows.live import live


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


def test_what_cannot_listen_is_refused(run):
    loaded = load_run(run.folder)
    with pytest.raises(ParameterError, match="window must be at least 0.103 s"):
        LiveClassifier(loaded, window_s=0.05)
    with pytest.raises(ParameterError, match="a source must be one of"):
        live(loaded, source="nothing:here")
    with pytest.raises(ParameterError, match="hop"):
        live(loaded, source="simulated:twelite", hop=0.0)


def test_live_prints_a_line_of_json_per_window_and_a_summary(store, run, capsys):
    address = f"played:{store}?materials=tile&seconds=0.8"
    assert main(["live", str(run.folder), "--source", address, "--hop", "0.2", "--json"]) == 0
    *windows, last = map(json.loads, capsys.readouterr().out.splitlines())
    assert len(windows) == last["summary"]["windows"] >= 2
    assert set(windows[0]) == {
        "material", "probabilities", "none_of_these", "end_index", "time_s", "lost", "level", "latency_s", "skipped",
    }  # fmt: skip
    assert set(windows[0]["probabilities"]) == {"cork", "foam", "tile"}


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

"""The model of one's own in docs/runs.md: its files and commands, as they stand there."""

import re
import shlex
import sys
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from tactogram.cli import main
from tactogram.datasets import Recording, create_store
from tactogram.signal import Signal
from tactogram.signal.io import read_metadata, read_signal

DOCUMENT = Path(__file__).parents[1] / "docs/runs.md"


def strokes(seconds=1.0, rate=1000.0):
    for number in range(10):
        for level, name in ((1, "carpet"), (4, "tile")):
            noise = np.random.default_rng(100 * level + number).standard_normal((3, int(seconds * rate)))
            signal = Signal(lfilter([level], [1, -0.5], noise), rate, "m/s^2")
            yield Recording(streams={"acceleration": signal}, material=name, simulated=True)


def test_a_model_of_ones_own_is_trained_and_used_as_written(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TACTOGRAM_MODELS", "")  # each main() adds to it; undone at the end
    text = re.search(r"<!-- own model -->\n(.*?)<!-- /own model -->", DOCUMENT.read_text("utf-8"), re.DOTALL)[
        1
    ]
    *files, (_, commands) = re.findall(r"```(\w+)\n(.*?)```", text, re.DOTALL)
    for _, content in files:
        path = tmp_path / re.match(r"# (mine/\S+)\n", content)[1]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    create_store(tmp_path / "surfaces", strokes(), name="s", licence="made in a test", simulated=True)
    lines = [shlex.split(line, comments=True) for line in commands.splitlines()]
    assert [line[1] for line in lines] == ["models", "train", "generate", "evaluate"]
    try:
        for line in lines[:-1]:  # judging a generator trains its judges: minutes
            assert main(line[1:]) == 0, line
        assert "coloured_noise  " in capsys.readouterr().out
        (tmp_path / "mine/coloured_noise/results.toml").write_text(
            '[[result]]\nwhat = "mine, dB"\nours = 3.0\n'
        )
        assert main(["table", "--models", "mine"]) == 0
    finally:
        sys.modules.pop("coloured_noise", None)
    assert "mine, dB" in capsys.readouterr().out
    made = read_signal(tmp_path / "noise.wav")
    assert (made.rate, made.unit, made.seconds) == (1000.0, "m/s^2", 3.0)
    assert read_metadata(tmp_path / "noise.wav")["simulated"] is True
    # 20 to 400 Hz of both, by power: the filter's gain over the band, and (1 + 16) / 2 of the levels.
    f = np.arange(20, 400) / 1000
    share = np.mean(np.abs(1 / (1 - 0.5 * np.exp(-2j * np.pi * f))) ** 2) * 2 * 0.38
    assert np.allclose(made.samples.std(1), np.sqrt(8.5 * share), rtol=0.1)

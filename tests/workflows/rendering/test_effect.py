"""Ready effects as files, by the verb and in Python."""

import json

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.errors import ParameterError
from tactogram.rendering import carrier, effect, effects, read_haptic
from tactogram.signal.io import read_metadata, read_signal
from tactogram.workflows.rendering.effect import write_effect


def test_without_a_name_all_are_listed(capsys):
    assert main(["effect"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 1 + len(effects())
    assert "heartbeat     2.84  two soft beats, four times, 72 per minute" in lines
    assert main(["effect", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["click"]["also"][:2] == ["button", "button press"]


def test_a_haptic_file_says_what_it_loses(tmp_path, capsys):
    assert main(["effect", "heartbeat", "--seconds", "5", "--out", str(tmp_path / "h.ahap")]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[:2] == ["heartbeat: two soft beats, four times, 72 per minute", f"{tmp_path / 'h.ahap'}: 5 s"]
    assert said[-1] == "Verdict: the events themselves."
    file = read_haptic(tmp_path / "h.ahap")
    assert file.metadata == {"effect": "heartbeat", "strength": 1.0, "seed": 0}
    assert len(file.events.parts[0].runs) == 12 or len(file.events.parts) == 12  # two for each of six beats
    assert main(["effect", "rain", "--out", str(tmp_path / "r.json"), "--format", "gamepad"]) == 0
    assert "transients missing" in capsys.readouterr().out


def test_a_signal_is_the_effect_as_it_plays(tmp_path):
    facts = write_effect("button press", out=tmp_path / "c.wav", strength=0.5)
    assert (facts["effect"], "written" in facts) == ("click", False)
    np.testing.assert_allclose(
        read_signal(tmp_path / "c.wav").samples, carrier(effect("click", strength=0.5)).samples, atol=1e-4
    )
    assert read_metadata(tmp_path / "c.wav")["effect"] == "click"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("heartbeet --out x.ahap", "got 'heartbeet'; did you mean 'heartbeat'?"),
        ("heartbeat", "--out must be given; name a haptic file or a signal, e.g. heartbeat.ahap"),
        (
            "rain --out x.json",
            "format must be one of android, android_basic, android_envelope, gamepad, vibration",
        ),
        ("rain --out x.txt", "suffix must be one of .wav"),
        ("rain --out x.ahap --format haptic", "format haptic is written as .haptic, got x.ahap"),
        ("click --seconds 2 --out x.ahap", "--seconds cannot change the length of click; omit it"),
    ],
)
def test_one_line_says_what_is_wrong(words, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["effect", *words.split()]) == 1
    [line] = capsys.readouterr().err.splitlines()
    assert message in line
    assert not list(tmp_path.iterdir())


def test_python_raises():
    with pytest.raises(ParameterError, match="out must be given"):
        write_effect("rain")

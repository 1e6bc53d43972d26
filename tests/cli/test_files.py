"""What the verbs on files print."""

import json

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.rendering.files import haptic_formats
from tactogram.signal import Signal
from tactogram.signal.io import WRITABLE, read_signal, write_signal
from tactogram.workflows.data.convert import convert


def test_a_table_is_converted_by_its_columns(tmp_path, capsys):
    rows = "\n".join(f"{k / 100},{k % 7},{k % 5}" for k in range(200))
    (tmp_path / "t.csv").write_text(f"clock,ax,ay\n{rows}\n")
    options = [
        "--time",
        "clock",
        "--axes",
        "ay",
        "--unit",
        "m/s^2",
        "--resample",
        "50",
        "--subtype",
        "PCM_16",
    ]
    assert main(["convert", str(tmp_path / "t.csv"), str(tmp_path / "t.wav"), *options, "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["rate_hz"], facts["unit"], facts["axes"], facts["samples"]) == (50.0, "m/s^2", ["y"], 100)


def test_a_signal_over_displacement_is_played_at_a_speed(tmp_path, capsys):
    ridges = Signal(
        np.sin(2 * np.pi * 2 * np.arange(400) / 10)[None], 10.0, "1", ("friction",), "displacement"
    )
    write_signal(tmp_path / "x.npz", ridges)
    for speed in (25.0, 50.0, 100.0):
        argv = [
            "convert",
            str(tmp_path / "x.npz"),
            str(tmp_path / "y.npz"),
            "--play-at",
            f"{speed:g}",
            "--resample",
        ]
        assert main([*argv, "2000", "--json"]) == 0
        facts = json.loads(capsys.readouterr().out)
        assert (facts["rate_hz"], facts["samples"]) == (2000.0, round(40 / speed * 2000))
        x = read_signal(tmp_path / "y.npz").samples[0]
        peak = np.argmax(np.abs(np.fft.rfft(x * np.hanning(len(x))))) * 2000 / len(x)
        assert peak == pytest.approx(2 * speed, abs=speed / 40)


def test_a_check_says_what_to_type(tmp_path, capsys):
    rows = "".join(f"{t},{t % 3}\n" for t in [*range(50), *range(300, 350)])
    (tmp_path / "t.csv").write_text(f"t [ms],x [g]\n{rows}")
    assert main(["convert", "--check", str(tmp_path / "t.csv")]) == 1
    assert "choose one of the 2 parts between, e.g. the longest, `--part 1`" in capsys.readouterr().out


RATE = 2000


FORMATS = haptic_formats()


def effect(axes=1, unit="1", seconds=1.0):
    t = np.arange(round(seconds * RATE)) / RATE
    x = 0.9 * (0.5 - 0.5 * np.cos(2 * np.pi * 2 * t / seconds)) * np.sin(2 * np.pi * 150 * t)
    return Signal(np.stack([x / (k + 1) for k in range(axes)]), RATE, unit, tuple("abc"[:axes]))


def test_a_wrong_file_is_listed_line_by_line(tmp_path, capsys):
    (tmp_path / "x.haptic").write_text('{"version": {"major": 2, "minor": 0, "patch": 0}, "signals": {}}')
    assert main(["convert", "--check", str(tmp_path / "x.haptic")]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith("not valid (haptic), 2 problems")
    assert lines[1].startswith("version.major")
    assert convert(tmp_path / "x.haptic", check=True)["problems"] == lines[1:]


def test_the_command_says_what_is_lost(tmp_path, capsys):
    write_signal(tmp_path / "in" / "a.wav", effect())
    assert main(["convert", str(tmp_path / "in" / "a.wav"), str(tmp_path / "a.ahap")]) == 0
    said = capsys.readouterr().out
    assert "The file keeps the strength over time, the level and the frequency; loses the waveform.\n" in said
    assert "Verdict: one tone of the signal's strength and frequency: enough for an effect; " in said
    assert "full_scale: 1" in said
    assert main(["convert", str(tmp_path / "in"), str(tmp_path / "out"), "--to", "haptic"]) == 0
    assert "1 written, 0 failed" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["a.wav"], 1, "target must be given; a source alone takes only --check"),
        ([], 2, "SOURCE requires an argument"),
        (["a.wav", "b.ahap", "--check"], 1, "omit target"),
        ([".", "out"], 1, "a folder needs a format; give --format"),
    ],
)
def test_the_command_refuses_incomplete_arguments(tmp_path, monkeypatch, capsys, arguments, status, message):
    monkeypatch.chdir(tmp_path)
    assert main(["convert", *arguments]) == status
    assert message in capsys.readouterr().err


def test_every_format_is_listed(capsys):
    assert main(["convert", "--list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert set(listed) == {*FORMATS, *(suffix.removeprefix(".") for suffix in WRITABLE)}
    assert listed["ahap"] == {"title": "AHAP (Apple)", "suffix": ".ahap", "holds": "envelope"}
    assert main(["convert", "--list"]) == 0
    assert "on and off" in capsys.readouterr().out

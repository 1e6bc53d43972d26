"""From a file to a drive with its report, and from a sweep to a response, as the command line does it."""

import json

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.signal import Signal
from tactogram.signal.io import read_metadata, read_signal, write_signal


@pytest.fixture(name="recording")
def recording_fixture(tmp_path):
    path = tmp_path / "touch.wav"
    samples = np.random.default_rng(0).normal(size=(3, 1000))
    write_signal(path, Signal(samples, 1000, "m/s^2"), metadata={"simulated": True})
    return path


def said(capsys, *arguments):
    """Run a verb with ``--json`` and return what it says."""
    assert main([*map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_a_drive_is_written_with_its_report(capsys, tmp_path, recording):
    out = tmp_path / "drive.wav"
    result = said(
        capsys,
        "render",
        recording,
        "--display",
        "voice-coil",
        "--level",
        "sensation=15",
        "--out",
        out,
        "--figure",
    )
    drive = read_signal(out)
    assert (drive.rate, drive.unit, drive.axes) == (8000, "V", ("coil",))
    assert read_metadata(out) == {"display": "voice-coil", "level": "sensation=15", "simulated": True}
    report = json.loads((tmp_path / "drive.report.json").read_text())
    assert report == result["report"]
    assert report["simulated"] is True
    assert report["facts"]["sensation_level_db"]["rendered"] == pytest.approx(15, abs=0.05)
    assert (tmp_path / "drive.report.png").read_bytes()[:4] == b"\x89PNG"
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "drive.report.json",
        "drive.report.png",
        "drive.wav",
        "touch.wav",
    ]


def test_how_axes_become_one_can_be_chosen(capsys, tmp_path, recording):
    out = tmp_path / "drive.csv"
    result = said(
        capsys,
        "render",
        recording,
        "--display",
        "voice-coil",
        "--level",
        "physical",
        "--as",
        "y",
        "--out",
        out,
    )
    assert result["report"]["scaled"][0] == "axis y alone, x, z left out"
    assert read_signal(out).unit == "V"


def test_a_drive_never_replaces_its_signal(capsys, recording):
    before = recording.read_bytes()
    arguments = ["--display", "voice-coil", "--level", "physical", "--out", str(recording)]
    assert main(["render", str(recording), *arguments]) == 1
    assert "is the signal itself" in capsys.readouterr().err
    assert recording.read_bytes() == before


@pytest.mark.parametrize(
    ("speed", "message"),
    [
        ("0", "a speed must be > 0 mm/s"),
        ("nan", "--speed must be a finite number, got nan"),
        ("1e-9", "a speed must be 1e-07 to 1e+08 mm/s for this signal"),
    ],
)
def test_a_speed_that_no_finger_has_is_one_line(capsys, tmp_path, speed, message):
    mu = Signal(np.linspace(0.3, 0.4, 100).astype(np.float32), 10, "1", domain="displacement")
    write_signal(tmp_path / "mu.npz", mu)
    arguments = ["--display", "electrovibration", "--level", "peak=1", "--speed", speed]
    assert main(["render", str(tmp_path / "mu.npz"), *arguments, "--out", str(tmp_path / "d.npz")]) == 1
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--display", "audio", "--level", "physical"], "use gain=FACTOR or peak=SHARE"),
        (["--display", "nothing", "--level", "physical"], "display must be one of"),
        (["--display", "voice-coil", "--level", "loud"], "level must be one of"),
        (
            ["--display", "voice-coil", "--level", "physical", "--set", "linear.colour=1"],
            "unknown key 'colour'",
        ),
        (["--display", "voice-coil", "--level", "gain=100", "--set", "linear.over=refuse"], "over the limit"),
        (["--display", "voice-coil", "--level", "sensation=1e9"], "level sensation takes -200 to 200 dB"),
        (["--display", "voice-coil", "--level", "gain=1e300"], "level gain needs a factor of 1e-12 to 1e+12"),
        (["--display", "voice-coil", "--level", "physical", "--set", "rate=1e12"], "cut the signal"),
    ],
)
def test_what_cannot_be_rendered_is_one_line_and_no_file(capsys, tmp_path, recording, arguments, message):
    assert main(["render", str(recording), *arguments, "--out", str(tmp_path / "drive.wav")]) == 1
    caught = capsys.readouterr().err
    assert message in caught
    assert caught.count("\n") == 1
    assert [p.name for p in tmp_path.iterdir()] == ["touch.wav"]


def test_an_unknown_suffix_is_refused_before_anything_is_done(capsys, tmp_path, recording):
    out = tmp_path / "drive.mp3"
    assert main(["render", str(recording), "--display", "audio", "--level", "peak=1", "--out", str(out)]) == 1
    assert "suffix must be one of" in capsys.readouterr().err


def test_too_little_memory_is_one_line(capsys, monkeypatch):
    def shown(*_, **__):
        raise MemoryError("Unable to allocate 58.2 TiB")

    monkeypatch.setattr("tactogram.workflows.rendering.render.levels_of", shown)
    assert main(["displays", "audio"]) == 1
    assert capsys.readouterr().err == "tactogram: not enough memory: Unable to allocate 58.2 TiB\n"

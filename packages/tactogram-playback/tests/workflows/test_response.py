"""A response measured by a sweep, and drives that it equalises."""

import json

import numpy as np
import pytest
from scipy import fft

from tactogram.cli import main
from tactogram.rendering.displays.catalogue import open_display
from tactogram.signal import Signal
from tactogram.signal.io import read_signal, write_signal


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


def test_a_measured_response_is_what_the_next_drive_is_equalised_by(capsys, tmp_path):
    """Sweep a display, record it (here: its own formula), identify it, render with what was found."""
    sweep_file, response_file = tmp_path / "sweep.wav", tmp_path / "mine.csv"
    facts = said(capsys, "sweep", "voice-coil", "--out", sweep_file, "--seconds", 3)
    assert facts["band"] == [20, 1000]
    sweep = read_signal(sweep_file)
    f = fft.rfftfreq(2 * len(sweep), 1 / sweep.rate)
    h = np.concatenate([[0], open_display("voice-coil").response.at(f[1:])])
    came = fft.irfft(fft.rfft(sweep.samples[0].astype(np.float64), 2 * len(sweep)) * h)
    write_signal(tmp_path / "take.wav", Signal(came, sweep.rate, "m/s^2"))
    found = said(capsys, "response", sweep_file, tmp_path / "take.wav", "--out", response_file)
    assert found["unit"] == "m/s^2/V"
    assert found["trusted_hz"] == pytest.approx([20, 1000])
    assert found["at_hz"] == pytest.approx(70, abs=8)
    text = (
        'name = "mine"\ntitle = "mine"\nfamily = "linear"\nrate = 8000\nchannels = ["coil"]\nunit = "V"\nlimit = 5\n'
        'band = [20, 1000]\n[response]\nkind = "table"\nunit = "m/s^2"\nfile = "mine.csv"\n'
    )
    (tmp_path / "mine.toml").write_text(text)
    t = np.arange(2000) / 1000
    tone = Signal(np.hanning(2000) * np.sin(2 * np.pi * 90 * t), 1000, "m/s^2")
    write_signal(tmp_path / "tone.wav", tone)
    drives = []
    for display in (tmp_path / "mine.toml", "voice-coil"):
        out = tmp_path / "drive.npz"
        said(
            capsys, "render", tmp_path / "tone.wav", "--display", display, "--level", "physical", "--out", out
        )
        drives.append(read_signal(out).samples[0])
    size = np.abs(np.fft.rfft(drives, axis=1))
    assert size[0].max() == pytest.approx(size[1].max(), rel=0.005)


def test_a_response_needs_to_know_the_axis_and_the_band(capsys, tmp_path, recording):
    assert main(["response", str(recording), str(recording), "--out", str(tmp_path / "r.csv")]) == 1
    assert "give --band" in capsys.readouterr().err
    band = ["--band", "20", "400"]
    assert main(["response", str(recording), str(recording), "--out", str(tmp_path / "r.csv"), *band]) == 1
    assert "choose one with --axis" in capsys.readouterr().err

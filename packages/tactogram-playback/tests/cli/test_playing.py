"""What the verbs that play print: streams, calibrations, resonances and tracks."""

import json
import os
import signal

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import create_store
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.workflows.training.train import train
from tactogram_playback.transducer.circuit import PRESETS
from tactogram_playback.transducer.simulation import SimulatedBench
from tactogram_playback.workflows.actuators import track, transducer


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (
            "stream FILE --track a=1",
            "--backend must be digilent to track its carrier, got 'null'; omit --track",
        ),
        (
            "stream FILE --backend audio",
            "--display must be given, with its level: the audio backend moves an act",
        ),
        ("stream FILE --display audio", "--level must be given with a display; or omit --display"),
        ("stream FILE --level peak=1", "--display must be given with a level; or omit --level"),
        ("stream FILE --mix y=1 --speed 50", "--mix must be one of touch, got 'y'"),
        ("stream FILE --out s.mp3", "--out must end in one of .wav, "),
        ("stream FILE --figure s.pdf", "--figure must end in .png, got s.pdf"),
        (
            "stream FILE",
            "touch is over time; state the speed at which it was recorded or generated with --speed",
        ),
        (
            "stream FILE --backend digilent --display ultrasonic-envelope --level peak=1 --track skew_s=0",
            "--track amps_per_volt must be known: 1 over the resistance of the shunt, in ohm",
        ),
        (
            "play FILE --display audio",
            "output = 'envelope'; for a sound card give `tactogram play FILE --display",
        ),
        ("play FILE --display audio --device tape", "--device must be null, audio, audio:NAME, digilent or "),
        (
            "sweep audio --out s.wav --seconds 0.01",
            "--seconds must last 4 periods of 10 Hz or more, got 0.01",
        ),
        ("sweep audio --out s.wav --band 5 2", "--band must be 0 < low < high < 24000 Hz, got (5.0, 2.0)"),
        ("response FILE FILE --out r.txt", "--out must end in .csv, got r.txt"),
        ("response FILE FILE --out r.csv", "does not state the band it sweeps; give --band"),
        ("calibrate FILE --out c.json", "--out must end in .toml, got 'c.json'"),
        (
            "calibrate PAIRS --out c.toml",
            "has no column normal_force_n; add it, or give the force as --force",
        ),
        ("track --display audio", "--display must have a carrier at its resonance, got 'audio'"),
    ],
)
def test_a_refusal_names_the_option(tmp_path, capsys, words, line):
    file, pairs = tmp_path / "touch.npz", tmp_path / "pairs.csv"
    write_signal(file, Signal(np.sin(np.arange(4000) / 3), 8000, "1"))
    pairs.write_text("voltage_v_rms,friction\n0,0.3\n")
    places = {"FILE": str(file), "PAIRS": str(pairs)}
    assert main([places.get(word, word) for word in words.split()]) == 1
    said = capsys.readouterr().err
    assert line in said.replace(str(file), "FILE")
    assert said.count("\n") == 1


def test_a_drifting_resonance_is_followed_and_logged(tmp_path, capsys):
    log = tmp_path / "track.csv"
    arguments = ["track", "--display", "ultrasonic-envelope", "--steps", "30", "--out", str(log), "--json"]
    assert main([*arguments, "--set", "bench.drift_hz_per_s=3", "--set", "bench.skew_s=4e-6"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["simulated"], found["locks"], found["steps"]) == (True, 1, 30)
    # 112 measurements of 71 ms, one of them after the last move, at 3 Hz per s.
    assert found["carrier_hz"] == pytest.approx(28_200 + 3 * 112 * 0.071, abs=1.0)
    assert found["settings"]["q"] == pytest.approx(300, rel=0.03)
    assert log.read_text().count("\n") == 1 + found["measured"]
    # Of the log, its sweep alone: what followed was measured of a resonance that went on.
    read = transducer(log)
    assert (read["points"], read["q"]) == (81, pytest.approx(found["q"], rel=1e-3))
    assert read["residual"] < 0.02


def test_a_sweep_with_a_lost_point_locks_and_its_log_gives_the_same_circuit(tmp_path, capsys, monkeypatch):
    taken, take, log = [], SimulatedBench.take, tmp_path / "track.csv"

    def lossy(bench, seconds, *, after_s):
        voltage, current = take(bench, seconds, after_s=after_s)
        taken.append(seconds)
        if 40 <= len(taken) < 43:  # one point, three times: as often as it is tried
            voltage[5] = np.nan
        return voltage, current

    monkeypatch.setattr(SimulatedBench, "take", lossy)
    found = track(display="ultrasonic-envelope", steps=1, out=log)
    assert (found["lost"], found["repeated"], found["locks"]) == (1, 3, 1)
    assert main(["transducer", str(log), "--json"]) == 0
    read = json.loads(capsys.readouterr().out)
    assert (read["points"], read["lost"]) == (80, 1)
    assert read["resonance_hz"] == pytest.approx(found["resonance_hz"], abs=1e-6)
    assert read["residual"] < 0.05


def test_the_command_line_says_whether_the_square_law_holds(tmp_path, command, write_pairs):
    done = command("calibrate", write_pairs(tmp_path / "pairs.csv"), "--out", tmp_path / "c.toml")
    assert done.returncode == 0, done.stderr
    assert "not contradicted" in done.stdout


def test_a_sweep_in_khz_is_refused_and_one_in_hz_printed_to_be_copied(tmp_path, command):
    f = np.linspace(27_400, 29_000, 81)
    y = PRESETS["finger"].admittance(f)
    for name, unit in (("hz", 1), ("khz", 1000)):
        lines = [f"{a / unit},{b.real},{b.imag}" for a, b in zip(f, y, strict=True)]
        text = "frequency_hz,conductance_s,susceptance_s\n" + "\n".join(lines)
        (tmp_path / f"{name}.csv").write_text(text)
    assert "resonance_hz: 28200\n" in command("transducer", tmp_path / "hz.csv").stdout
    assert "are they in kHz?" in command("transducer", tmp_path / "khz.csv").stderr


def test_sigterm_ends_it_in_order_as_ctrl_c_does(tmp_path, capsys, monkeypatch):
    take, log = SimulatedBench.take, tmp_path / "track.csv"
    before = signal.getsignal(signal.SIGTERM)

    def killed(bench, seconds, *, after_s):
        if bench.clock_s > 6:
            os.kill(os.getpid(), signal.SIGTERM)
        return take(bench, seconds, after_s=after_s)

    monkeypatch.setattr(SimulatedBench, "take", killed)
    assert main(["track", "--display", "ultrasonic-envelope", "--out", str(log), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["interrupted"]
    assert 0 < found["steps"] < 100
    assert log.read_text().count("\n") == 1 + found["measured"]
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.fixture(scope="module")
def textures(recordings, tmp_path_factory):
    """An `ar_texture` of four made-up materials at two speeds, three axes."""
    folder = tmp_path_factory.mktemp("stream")
    create_store(folder / "store", recordings(count=2), name="t", licence="made in a test", simulated=True)
    return train("ar_texture", folder / "store", recipe="tiny", split="all", out=folder / "run").folder


def test_the_verb_prints_a_table_and_json(textures, capsys, tmp_path):
    arguments = ["stream", str(textures), "--mix", "cork=1", "--backend", "file", "--seconds", "0.5"]
    assert main(arguments) == 0
    assert "underruns: 0" in capsys.readouterr().out
    displayed = ["--display", "voice-coil", "--level", "gain=0.5", "--set", "limit=2"]
    displayed += ["--set", "linear.equalise=none"]
    assert main([*arguments, *displayed, "--json"]) == 0
    told = capsys.readouterr()
    assert "equaliser: none, the response of voice-coil is not equalised" in told.err
    result = json.loads(told.out)
    assert result["latency"]["block_ms"] == 5.0
    assert (result["display"]["limit"], result["display"]["equaliser"]["on"]) == (2.0, False)
    assert main([*arguments, "--motion", str(tmp_path / "none.csv")]) == 1
    assert "none.csv" in capsys.readouterr().err

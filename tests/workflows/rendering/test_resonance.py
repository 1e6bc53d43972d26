"""The verb `track`: generator, converter and tracker together, on a simulated bench and on a stand-in for a device."""

import json
import os
import signal

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.errors import ParameterError
from tactogram.rendering.transducer.circuit import Transducer
from tactogram.rendering.transducer.resonance_tracking import TrackingError
from tactogram.rendering.transducer.simulation import BenchSettings, SimulatedBench
from tactogram.workflows.rendering import carrier_tracking
from tactogram.workflows.rendering.actuators import track, transducer


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


class Device(SimulatedBench):
    """A generator whose inputs see a simulated transducer, opened and closed as a real one is."""

    opened_device = ("device", "module")

    def __init__(self, transducer):
        super().__init__(BenchSettings(), transducer=transducer, rng=np.random.default_rng(0))
        self.held, self.closed = [], False

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.closed = True

    def hold(self, amplitude_v, *, longest_s):
        self.held.append((amplitude_v, longest_s))


@pytest.mark.parametrize("resonance_hz", [28_200.0, 45_000.0])
def test_a_device_is_held_at_a_share_and_left_silent_whatever_happens(resonance_hz, tmp_path, monkeypatch):
    device, wanted = Device(Transducer(resonance_hz=resonance_hz, q=100, r1_ohm=300.0)), []
    monkeypatch.setattr(carrier_tracking, "DigilentRecorder", lambda *opened, name: device)

    def follow():
        return track(
            display="ultrasonic-envelope",
            generator="digilent:7",
            steps=5,
            share=0.5,
            amps_per_volt=0.1,
            out=tmp_path / "log.csv",
            opened=lambda one: wanted.append(one) or device,
        )

    if resonance_hz < 30_000:
        found = follow()
        assert (found["simulated"], found["steps"]) == (False, 5)
        assert found["carrier_hz"] == pytest.approx(28_200, abs=5)
    else:
        with pytest.raises(TrackingError, match="no lock"):
            follow()
    assert (wanted[0].serial, wanted[0].peak_v) == ("7", pytest.approx(1.1))
    [(volts, longest_s)] = device.held
    assert volts == pytest.approx(0.55)
    assert 10 < longest_s < 120
    assert device.closed
    assert (tmp_path / "log.csv").exists()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"generator": "voice"}, "generator must be digilent"),
        ({"share": 1.5}, "share must be"),
        ({"steps": 0}, "steps must be"),
        ({"seed": -1}, "seed must be"),
        ({"out": "track.wav"}, "suffix must be .csv"),
        ({"out": "/dev/null/track.csv"}, "cannot be written"),
        ({"generator": "digilent"}, "amps_per_volt must be known"),
        ({"display": "ultrasonic"}, "makes the carrier"),
        ({"changes": {"velocity.x": 1}}, "must be a key of tracking"),
        ({"changes": {"bench.rate": 20_000}}, "20000 samples/s are too few"),
    ],
)
def test_what_does_not_fit_is_refused_in_one_line(options, says):
    with pytest.raises(ParameterError, match=says):
        track(**({"display": "ultrasonic-envelope"} | options))

import json

import numpy as np
import pytest

from tactogram.errors import DeviceError, ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import write_signal
from tactogram.workflows.rendering.render import render
from tactogram_playback.transducer.circuit import PRESETS, Transducer
from tactogram_playback.transducer.resonance_tracking import TrackingError
from tactogram_playback.transducer.simulation import BenchSettings, SimulatedBench
from tactogram_playback.workflows import carrier_tracking
from tactogram_playback.workflows.actuators import calibrate, play, track, transducer


def test_a_table_becomes_a_calibration_per_person(tmp_path, write_pairs):
    result = calibrate(write_pairs(tmp_path / "pairs.csv"), tmp_path / "c.toml")
    assert result["spread"] == pytest.approx(2, rel=0.1)
    assert result["people"]["anna"]["settings"]["newton_per_v2"] == pytest.approx(2e-5, rel=0.05)
    assert (tmp_path / "c.toml").read_text().count("[[calibration]]") == 2


@pytest.fixture(name="friction")
def friction_fixture(tmp_path, write_pairs):
    calibrate(write_pairs(tmp_path / "pairs.csv"), tmp_path / "c.toml")
    mu = 0.34 + 0.04 * np.sin(2 * np.pi * np.arange(4000) / 4000)
    write_signal(tmp_path / "mu.npz", Signal(mu.astype(np.float32), 4000, "1"))
    return tmp_path


def test_a_calibration_gives_a_persons_voltage(friction):
    drives = {}
    for person in ("anna", "ben"):
        result = render(
            friction / "mu.npz",
            friction / f"{person}.npz",
            display="electrovibration",
            level="physical",
            calibration=friction / "c.toml",
            person=person,
        )
        drives[person] = result["report"]["drive"]["peak"]
        assert f"24 pairs of {person} up to 100 V rms" in result["report"]["scaled"][-1]
        assert result["report"]["facts"]["v_max"] == 141
    # mu = mu_0 (1 + k V^2 / F): twice the k_e needs 1 / sqrt 2 of the voltage.
    assert drives["anna"] / drives["ben"] == pytest.approx(np.sqrt(2), rel=0.1)


def test_beyond_the_calibrated_voltage_the_report_says_that_it_is_a_guess(friction):
    result = render(
        friction / "mu.npz",
        friction / "d.npz",
        display="electrovibration",
        level="peak=1",
        calibration=friction / "c.toml",
        person="ben",
        changes={"limit": 200, "electrovibration.v_max": 200},
    )
    assert any("calibrated to 100 V rms only" in words for words in result["report"]["scaled"])


@pytest.mark.parametrize(
    ("display", "person", "changes", "message"),
    [
        ("voice-coil", "anna", {}, "for an electrostatic display, this one is linear"),
        ("electrovibration", None, {}, "holds anna, ben: name the person"),
        ("electrovibration", "carl", {}, "person must be one of anna, ben"),
        ("electrovibration", "ben", {"electrovibration.mu_0": 0.2}, "omit `changes`, or `calibration`"),
    ],
)
def test_a_calibration_that_does_not_fit_is_refused(friction, display, person, changes, message):
    with pytest.raises(ParameterError, match=message):
        render(
            friction / "mu.npz",
            friction / "d.npz",
            display=display,
            level="physical",
            calibration=friction / "c.toml",
            person=person,
            changes=changes,
        )
    assert not (friction / "d.npz").exists()


def test_nothing_is_written_where_nothing_can_be_said(tmp_path):
    (tmp_path / "pairs.csv").write_text("voltage_v_rms,friction,normal_force_n\n0,0.3,1\n")
    with pytest.raises(ParameterError, match="needs 6 pairs"):
        calibrate(tmp_path / "pairs.csv", tmp_path / "c.toml")
    assert not (tmp_path / "c.toml").exists()


def test_a_measured_sweep_gives_carrier_and_q(tmp_path, command):
    f = np.linspace(27_400, 29_000, 81)
    y = PRESETS["finger"].admittance(f)
    lines = [f"{a},{b.real},{b.imag}" for a, b in zip(f, y, strict=True)]
    (tmp_path / "sweep.csv").write_text("frequency_hz,conductance_s,susceptance_s\n" + "\n".join(lines))
    found = transducer(tmp_path / "sweep.csv")
    assert found["settings"] == {
        "carrier_hz": pytest.approx(28_200, abs=0.1),
        "q": pytest.approx(100, rel=1e-3),
    }
    assert json.loads(command("transducer", tmp_path / "sweep.csv", "--json").stdout)["q"] == pytest.approx(
        found["q"]
    )


class SimulatedDevice:
    """Stands in for an Analog Discovery."""

    def __init__(self, wanted):
        self.wanted, self.played, self.looped = wanted, None, None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def play(self, drive):
        self.played = drive

    def loop(self, drive, seconds):
        self.played, self.looped = drive, seconds

    def facts(self):
        return {"simulated": True}


@pytest.fixture
def drive(tmp_path):
    x = Signal(np.random.default_rng(0).standard_normal(800), 2000, "m/s^2")
    write_signal(tmp_path / "x.csv", x)
    return render(tmp_path / "x.csv", tmp_path / "drive.npz", display="ultrasonic-envelope", level="peak=1")[
        "file"
    ]


def test_a_rendered_envelope_reaches_the_device(drive):
    devices = []

    def opened(wanted):
        devices.append(SimulatedDevice(wanted))
        return devices[-1]

    assert play(drive, display="ultrasonic-envelope", device="digilent:1234", opened=opened) == {
        "simulated": True
    }
    assert (devices[0].wanted.carrier_hz, devices[0].wanted.serial) == (28_200, "1234")
    assert devices[0].wanted.peak_v == pytest.approx(1.1)
    assert 0.9 < devices[0].played.samples.max() <= 1.1
    play(drive, display="ultrasonic-envelope", loop_s=2.0, opened=opened)
    assert devices[1].looped == 2.0


def test_a_drive_that_does_not_begin_at_rest_is_faded(tmp_path):
    devices = []

    def opened(wanted):
        devices.append(SimulatedDevice(wanted))
        return devices[-1]

    write_signal(tmp_path / "step.npz", Signal(np.full(1600, 1.0), 8000, "V"))
    play(tmp_path / "step.npz", display="ultrasonic-envelope", opened=opened)
    sent = devices[0].played.samples[0]
    assert sent[[0, -1]] == pytest.approx([0, 0])
    assert np.abs(np.diff(sent)).max() < 0.05
    assert sent[800] == pytest.approx(1)


def test_what_is_no_drive_of_the_display_never_reaches_the_device(drive, tmp_path):
    with pytest.raises(ParameterError, match="no carrier that a device could make"):
        play(drive, display="voice-coil")
    with pytest.raises(ParameterError, match="no carrier that a device could make"):
        play(drive, display="ultrasonic")
    with pytest.raises(ParameterError, match="must be null, audio, audio:NAME, digilent"):
        play(drive, display="ultrasonic-envelope", device="rigol")
    write_signal(tmp_path / "loud.npz", Signal(np.full(100, 2.0), 16_000, "V"))
    with pytest.raises(ParameterError, match=r"outside of 0 to 1\.1 V"):
        play(tmp_path / "loud.npz", display="ultrasonic-envelope")
    with pytest.raises(ParameterError, match="channel: must be less than or equal to 2, got 7"):
        play(drive, display="ultrasonic-envelope", channel=7)
    for seconds in (0, -1, float("nan")):
        with pytest.raises(ParameterError, match="loop_s must be"):
            play(drive, display="ultrasonic-envelope", loop_s=seconds)
    with pytest.raises(ParameterError, match="is not a drive"):
        play(tmp_path / "x.csv", display="ultrasonic-envelope")


def test_without_a_device_it_is_one_line(drive, command):
    pytest.importorskip("dwfpy")
    with pytest.raises(DeviceError, match="WaveForms"):
        play(drive, display="ultrasonic-envelope")
    done = command("play", drive, "--display", "ultrasonic-envelope")
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1


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
        ({"out": "track.wav"}, "out must end in .csv"),
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


def test_a_person_needs_a_calibration(friction, command):
    done = command("render", friction / "mu.npz", "--display", "electrovibration", "--level", "physical",
               "--person", "anna", "--out", friction / "d.npz")  # fmt: skip
    assert done.returncode == 1
    assert "--person chooses among the people of a calibration; give it with --calibration" in done.stderr

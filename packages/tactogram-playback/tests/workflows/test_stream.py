"""The verb `stream`: runs and files, mixed, on every backend that needs no hardware."""

import json
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from tactogram.datasets import Recording, create_store
from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import read_metadata, read_signal, write_signal
from tactogram.workflows.training.train import train
from tactogram_playback.workflows.stream import latency_lines, stream, underrun_line


@pytest.fixture(scope="module")
def textures(recordings, tmp_path_factory):
    """An `ar_texture` of four made-up materials at two speeds, three axes."""
    folder = tmp_path_factory.mktemp("stream")
    create_store(folder / "store", recordings(count=2), name="t", licence="made in a test", simulated=True)
    return train("ar_texture", folder / "store", recipe="tiny", split="all", out=folder / "run").folder


@pytest.fixture(name="grating")
def grating_fixture(tmp_path):
    def make(name, hz):
        t = np.arange(4000) / 2000
        signal = Signal(np.sin(2 * np.pi * hz * t).astype(np.float32), 2000, "m/s^2")
        write_signal(tmp_path / name, signal, metadata={"speed_mm_s": 100.0})
        return tmp_path / name

    return make


def to_file(sources, **options):
    return stream(sources, **({"backend": "file", "seconds": 2.0} | options))


def test_a_run_is_streamed_to_a_display_and_to_files(textures, tmp_path):
    out, figure = tmp_path / "sent.wav", tmp_path / "sent.png"
    told = []
    result = to_file(
        [textures],
        mix={"cork": 0.5, "tile": 0.5},
        display="voice-coil",
        level="gain=0.5",
        out=out,
        figure=figure,
        status=lambda line, now: told.append(line),
        tell=told.append,
    )
    assert told[0].startswith("equaliser: within 0.1")  # before anything plays
    assert result["display"]["equaliser"]["on"]
    sent = read_signal(out)
    assert (sent.rate, sent.unit, sent.axes, len(sent)) == (8000, "V", ("coil",), 16_000)
    assert 0 < np.abs(sent.samples).max() <= 5.0
    assert read_metadata(out)["simulated"] is True
    assert figure.stat().st_size > 20_000
    assert result["simulated"]
    assert result["weights"] == {"cork": 0.5, "tile": 0.5}
    json.dumps(result, allow_nan=False)
    text = "\n".join(latency_lines(result))
    assert "time to compute a block" in text
    assert "simulated motion:" in text


def test_a_mix_that_changes_while_it_plays(grating, tmp_path):
    motion = tmp_path / "motion.csv"
    motion.write_text("time_s,x_mm,force_n\n" + "".join(f"{i / 200},{i / 2},0.5\n" for i in range(500)))
    out = tmp_path / "sent.npz"
    to_file(
        [grating("low.wav", 100), grating("high.wav", 400)],
        motion=str(motion),
        mix={"low": 1.0, "high": 0.0},
        mix_to={"low": 0.0, "high": 1.0},
        out=out,
    )
    sent = read_signal(out).samples[0]
    begin, end = (np.abs(np.fft.rfft(x)) for x in (sent[800:4000], sent[-3200:]))
    assert np.argmax(begin) * 2.5 == pytest.approx(100, abs=4)
    assert np.argmax(end) * 2.5 == pytest.approx(400, abs=4)


@pytest.mark.parametrize("backend", ["null", "clock", "osc"])
def test_backends_without_hardware(textures, backend):
    lines = []
    result = stream(
        [textures],
        backend=backend,
        seconds=0.2,
        to="127.0.0.1:9" if backend == "osc" else "",
        mix={"cork": 1.0},
        status=lambda line, now: lines.append(line),
    )
    assert result["latency"]["compute"]["count"] > 0
    assert result["backend"] == backend
    assert any("compute p50" in line for line in lines)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"mix": {"velvet": 1.0}}, "mix must be one of cork"),
        ({"display": "voice-coil"}, "level must be given with a display; or omit `display`"),
        ({"display": "phone", "level": "peak=1"}, "render a file"),
        ({"block_ms": 6.0}, "block_ms must be less than or equal to 5"),
        ({"seconds": 0.0}, "seconds must be greater than 0"),
        ({"seed": -1}, "seed must be greater than or equal to 0"),
        ({"backend": "audio"}, "display must be given, with its level"),
        ({"backend": "tape"}, "backend must be 'null', 'file'"),
        ({"motion": "osc"}, "backend must be in real time for motion from osc"),
        ({"out": Path("sent.xyz")}, "out must end in one of .wav"),
        ({"figure": Path("sent.pdf")}, "figure must end in .png"),
        ({"out": Path(__file__) / "sent.wav"}, "cannot be written"),
    ],
)
def test_what_cannot_be_streamed_is_refused(textures, options, says):
    with pytest.raises(ParameterError, match=says):
        to_file([textures], **options)


def test_underruns_say_whose_they_are_and_what_helps():
    def line(worked_ms, *, asked=False, granted=False, underruns=7):
        return underrun_line(
            {
                "latency": {
                    "underruns": underruns,
                    "block_ms": 5.0,
                    "compute": {"count": 1000},
                    "processor": {"p99_ms": worked_ms},
                },
                "device": {"realtime_priority": granted},
                "realtime_asked": asked,
            }
        )

    assert line(1.0, underruns=0) == "underruns: 0"
    assert line(1.0).startswith("underruns: 7 of 1000 blocks")
    assert "other programs" in line(1.0)
    assert "try real-time priority" in line(1.0)
    assert "not granted" in line(1.0, asked=True)
    assert "try" not in line(1.0, asked=True, granted=True)
    assert "fewer textures" in line(9.0)


def test_friction_is_streamed_to_an_electrovibration_display(textures, tmp_path):
    x = np.arange(2000) / 40
    mu = Signal((0.35 + 0.03 * np.sin(np.pi * x)).astype(np.float32), 40, "1", ("mu",), domain="displacement")
    write_signal(tmp_path / "mu.npz", mu)
    out = tmp_path / "sent.npz"
    result = stream(
        tmp_path / "mu.npz",
        backend="file",
        seconds=1.0,
        display="electrovibration",
        level="physical",
        out=out,
    )
    sent = read_signal(out)
    assert (sent.rate, sent.unit) == (48_000, "V")
    assert 30 < np.abs(sent.samples).max() <= 141
    assert result["display"]["rehearsal"] is None
    assert result["display"]["fitted"]["mu_wanted"]
    json.dumps(result, allow_nan=False)
    with pytest.raises(ParameterError, match="one surface at a time"):
        to_file([textures], mix={"cork": 1.0}, display="electrovibration", level="physical")


class SimulatedGenerator:
    """A Digilent that keeps what it is sent."""

    def __init__(self, wanted):
        self.wanted, self.sent = wanted, []
        self.devices.append(self)

    devices: ClassVar[list] = []

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass

    def play(self, envelope, *, rate, longest_s):
        self.sent = np.concatenate(list(envelope))
        self.rate = rate

    def facts(self):
        return {"carrier_hz": self.wanted.carrier_hz}


def test_a_digilent_makes_the_carrier_of_a_stream(grating):
    result = stream(
        grating("a.wav", 150),
        backend="digilent",
        display="ultrasonic-envelope",
        level="peak=0.5",
        seconds=0.3,
        opened=SimulatedGenerator,
    )
    [device] = SimulatedGenerator.devices
    assert result["device"] == {"carrier_hz": 28_200.0}
    assert result["latency"]["queued_ms"] == 50.0
    assert device.rate == 16_000
    assert device.sent.min() >= 0
    assert 0 < device.sent.max() <= device.wanted.peak_v * (1 + 1e-6)
    assert device.sent[-1] == 0  # faded out


def test_a_tablet_of_strings_follows_the_position_of_the_finger(grating, tmp_path):
    """A finger at the left is pulled along the stroke mostly by the strings at its right."""
    motion = tmp_path / "motion.csv"
    motion.write_text(
        "time_s,x_mm,y_mm,force_n\n"
        + "".join(f"{i / 200},{-60 + 10 * np.sin(i / 3)},0,0.5\n" for i in range(500))
    )
    out = tmp_path / "sent.npz"
    facts = to_file(
        [grating("a.wav", 100)], display="string-tablet", level="gain=0.2", motion=str(motion), out=out
    )
    sent = read_signal(out)
    assert (sent.rate, sent.unit, len(sent.axes)) == (1000.0, "N", 4)
    swing = {name: sent.axis(name)[500:-200].std() for name in sent.axes}
    assert swing["upper-left"] > swing["upper-right"] > 0  # steeper strings must pull more
    assert swing["upper-left"] == pytest.approx(swing["lower-left"], rel=1e-4)
    assert facts["display"]["newton_per_unit"] == pytest.approx(0.2)


def test_a_display_in_volts_needs_the_full_scale_of_the_amplifier(grating):
    with pytest.raises(ParameterError, match="give it as `full_scale`"):
        stream(grating("a.wav", 150), backend="audio", display="voice-coil", level="gain=1")


def test_the_carrier_of_a_stream_is_tracked(grating, tmp_path):
    log = tmp_path / "track.csv"
    result = stream(
        grating("a.wav", 150),
        backend="digilent",
        device="simulated",
        track={"every_s": 0.05, "timing.settle_s": 0.01, "bench.drift_hz_per_s": 5, "log": str(log)},
        display="ultrasonic-envelope",
        level="peak=0.5",
        seconds=0.8,
    )
    tracking = result["device"]["tracking"]
    assert tracking["error"] is None
    assert tracking["steps"] >= 1
    assert result["device"]["simulated"]
    assert abs(tracking["carrier_hz"] - result["device"]["resonance_hz"]) < 47  # half the width at Q 300
    assert "track," in log.read_text()
    with pytest.raises(ParameterError, match="backend must be digilent to track its carrier, got 'file'"):
        to_file(grating("a.wav", 150), track={})


@pytest.fixture(scope="module")
def strokes(tmp_path_factory):
    """Simulated: noise of two levels, recorded at 100 and 200 mm/s."""
    rng = np.random.default_rng(0)
    recordings = [
        Recording(
            streams={"acceleration": Signal(level * speed * rng.standard_normal((1, 2000)), 1000.0, "m/s^2")},
            material=name,
            speed_mm_s=speed,
            simulated=True,
        )
        for name, level in (("cork", 0.1), ("tile", 0.01))
        for speed in (100.0, 200.0)
        for _ in range(3)
    ]
    path = tmp_path_factory.mktemp("strokes") / "store"
    return create_store(path, recordings, name="strokes", licence="-", simulated=True).path


def test_a_stream_says_for_how_long_the_finger_was_outside(strokes, tmp_path):
    run = train("texture_var", strokes, out=tmp_path / "run", accelerator="cpu").folder
    motion = tmp_path / "hand.csv"
    rows = [f"{t:.3f},{100 * t if t < 1 else 100 + 400 * (t - 1)}" for t in np.arange(0, 2, 0.005)]
    motion.write_text("\n".join(["time_s,x_mm", *rows]) + "\n")
    out = tmp_path / "felt.wav"
    told = {"mix": {"cork": 1}, "motion": str(motion), "seconds": 1.9, "backend": "file", "out": out}
    [sentence] = stream([run], **told)["limited"]
    assert sentence.endswith("is outside of what was recorded of cork: it counts as 200 mm/s")
    assert sentence.startswith("a speed of up to 4")
    share = float(sentence.split("for ")[1].split(" %")[0])
    assert share == pytest.approx(47, abs=6)
    assert read_metadata(out)["limited"] == [sentence]

"""The verb `stream`: runs and files, mixed, on every backend that needs no hardware."""

import json
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

import tactogram
from tactogram.cli import main
from tactogram.datasets import create_store
from tactogram.errors import ParameterError
from tactogram.rendering.streaming.noise_texture import ModulatedNoiseTexture
from tactogram.rendering.streaming.textures import AutoregressiveTexture
from tactogram.signal import Signal
from tactogram.signal.io import read_metadata, read_signal, write_signal
from tactogram.workflows.streaming.stream import latency_lines, stream, underrun_line
from tactogram.workflows.streaming.textures import TextureSettings, textures_of
from tactogram.workflows.training.train import train
from tactogram_study.study_file import Study
from tactogram_study.trials import PresentedStimulus
from tactogram_study.workflows.stimuli import StudyStimuli


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


def test_files_are_laid_out_by_the_speed_that_they_say(grating, tmp_path):
    """A stroke at a constant speed of 200 mm/s over what gave 150 Hz at 100 mm/s: 300 Hz."""
    motion = tmp_path / "motion.csv"
    motion.write_text("time_s,x_mm,force_n\n" + "".join(f"{i / 200},{i},0.5\n" for i in range(500)))
    out = tmp_path / "sent.npz"
    to_file([grating("a.wav", 150)], motion=str(motion), out=out)
    power = np.abs(np.fft.rfft(read_signal(out).samples[0][4000:]))
    assert np.argmax(power) * 8000 / 12_000 == pytest.approx(300, abs=2)


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


def test_a_generator_that_is_not_autoregressive_is_laid_out_too(recordings, tmp_path):
    create_store(tmp_path / "store", recordings(count=2), name="t", licence="made in a test", simulated=True)
    run = train("replay", tmp_path / "store", recipe="tiny", split="all", out=tmp_path / "run").folder
    result = to_file([run], mix={"cork": 1.0}, speed_mm_s=100.0)
    assert result["textures"] == ["cork"]
    with pytest.raises(ParameterError, match="give `speed_mm_s`"):
        to_file([run], mix={"cork": 1.0})


def test_a_run_of_texture_var_follows_speed_and_force(recordings, tmp_path):
    """At the level of its models, not of a signal that is laid out, which would need a speed."""
    motion = tmp_path / "motion.csv"
    motion.write_text("time_s,x_mm,force_n\n" + "".join(f"{i / 200},{i / 2},0.5\n" for i in range(500)))
    create_store(tmp_path / "store", recordings(count=2), name="t", licence="made in a test", simulated=True)
    run = train(
        "texture_var",
        tmp_path / "store",
        recipe="tiny",
        changes={"prepare.rate": 1000},
        split="all",
        out=tmp_path / "run",
    ).folder
    out = tmp_path / "sent.npz"
    result = to_file([run], mix={"cork": 1.0}, motion=str(motion), out=out, tap_gain=0.0)
    assert (result["textures"], result["simulated"]) == (["cork"], True)
    [texture], _ = textures_of([run], ["cork"], TextureSettings(8000.0, 40))
    assert isinstance(texture, ModulatedNoiseTexture)
    assert texture.table.axes == ("dft321",)
    assert texture.table.surface.conditions[:, 0].tolist() == [100.0, 200.0]
    # Recordings differ in level, and so do draws: over eight seeds by a factor of 0.53 to 0.90.
    assert read_signal(out).samples[0, 800:].std() == pytest.approx(texture.level, rel=0.5)


def test_the_trained_model_streams_its_materials_at_any_speed_and_force():
    made, _ = textures_of(["texture_flow"], ["brick", "silk"], TextureSettings(8000.0, 40))
    brick, silk = sorted(made, key=lambda texture: texture.name)
    assert [brick.name, silk.name] == ["brick", "silk"]
    assert isinstance(brick, ModulatedNoiseTexture)
    levels = [np.exp(brick.table.at(speed, 1.0).deviation[0]) for speed in (40.0, 120.0, 360.0)]
    assert levels[0] < levels[1] < levels[2]
    assert brick.level > 3 * silk.level
    with pytest.raises(
        ParameterError, match="texture_flow has 84 materials; choose with `mix`: one of 84, e.g"
    ):
        textures_of(["texture_flow"], [], TextureSettings(8000.0, 40))


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
        ({"mix": {"velvet": 1.0}}, "`mix` must be one of cork"),
        ({"display": "voice-coil"}, "give `display` and `level`, or neither"),
        ({"display": "phone", "level": "peak=1"}, "render a file"),
        ({"block_ms": 6.0}, "block_ms must be less than or equal to 5"),
        ({"seconds": 0.0}, "seconds must be greater than 0"),
        ({"seed": -1}, "seed must be greater than or equal to 0"),
        ({"backend": "audio"}, "give its `display`"),
        ({"backend": "tape"}, "backend must be 'null', 'file'"),
        ({"motion": "osc"}, "is not in real time"),
        ({"out": Path("sent.xyz")}, "suffix must be one of .wav"),
        ({"figure": Path("sent.pdf")}, "must be .png"),
        ({"out": Path(__file__) / "sent.wav"}, "cannot be written"),
    ],
)
def test_what_cannot_be_streamed_is_refused(textures, options, says):
    with pytest.raises(ParameterError, match=says):
        to_file([textures], **options)


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
    result = tactogram.stream(
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
    with pytest.raises(ParameterError, match="give `full_scale`"):
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
    with pytest.raises(ParameterError, match="got the backend file"):
        to_file(grating("a.wav", 150), track={})


def streamed(stimulus):
    """Return a study of one stimulus that follows the finger."""
    return Study.of(
        {
            "name": "streamed",
            "title": "Streamed",
            "languages": ["en"],
            "consent": "Do you agree?",
            "display": "voice-coil",
            "played_by": "stream",
            "level": "gain=0.5",
            "design": {"kind": "staircase"},
            "stimuli": [stimulus],
        }
    )


def test_a_material_of_a_run_is_streamed_in_a_study_over_speed_and_force(textures, tmp_path):
    study = streamed({"name": "cork", "run": str(textures), "material": "cork"})
    stimuli = StudyStimuli(study, tmp_path)
    [cork] = study.all_stimuli
    plain = stimuli.played(PresentedStimulus("A", cork))
    weaker = stimuli.played(PresentedStimulus("B", cork, gain_db=-20))
    assert isinstance(plain.stream.texture, AutoregressiveTexture)
    assert plain.drive is None
    assert weaker.stream.output is plain.stream.output  # one rehearsal for all gains
    assert weaker.stream.weight == pytest.approx(0.01)  # of the power
    assert (plain.sha256, plain.level, plain.display) == (weaker.sha256, "gain=0.5", "voice-coil")
    with pytest.raises(ParameterError, match="stimulus cork: phone: .* cannot be streamed to"):
        StudyStimuli(study.model_copy(update={"display": "phone"}), tmp_path).check()


def test_words_of_a_streamed_study_follow_speed_and_force(tmp_path):
    study = streamed({"name": "rough", "run": "texture_flow", "words": {"rough": 6.0}})
    played = StudyStimuli(study, tmp_path).played(PresentedStimulus("A", study.all_stimuli[0]))
    assert isinstance(played.stream.texture, ModulatedNoiseTexture)
    slow, fast = (played.stream.texture.table.at(speed, 0.5).deviation[0] for speed in (60.0, 240.0))
    assert fast > slow + np.log(1.2)

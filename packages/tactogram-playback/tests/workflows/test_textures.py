"""Textures of runs and files for a stream."""

import numpy as np
import pytest

from tactogram.datasets import create_store
from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import read_signal, write_signal
from tactogram.workflows.generation import cloned_strokes
from tactogram.workflows.training.train import train
from tactogram_playback.streaming.noise_texture import ModulatedNoiseTexture
from tactogram_playback.workflows.stream import stream
from tactogram_playback.workflows.textures import TextureSettings, textures_of


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


def test_files_are_laid_out_by_the_speed_that_they_say(grating, tmp_path):
    """A stroke at a constant speed of 200 mm/s over what gave 150 Hz at 100 mm/s: 300 Hz."""
    motion = tmp_path / "motion.csv"
    motion.write_text("time_s,x_mm,force_n\n" + "".join(f"{i / 200},{i},0.5\n" for i in range(500)))
    out = tmp_path / "sent.npz"
    to_file([grating("a.wav", 150)], motion=str(motion), out=out)
    power = np.abs(np.fft.rfft(read_signal(out).samples[0][4000:]))
    assert np.argmax(power) * 8000 / 12_000 == pytest.approx(300, abs=2)


def test_a_generator_that_is_not_autoregressive_is_laid_out_too(recordings, tmp_path):
    create_store(tmp_path / "store", recordings(count=2), name="t", licence="made in a test", simulated=True)
    run = train("replay", tmp_path / "store", recipe="tiny", split="all", out=tmp_path / "run").folder
    result = to_file([run], mix={"cork": 1.0}, speed_mm_s=100.0)
    assert result["textures"] == ["cork"]
    with pytest.raises(ParameterError, match="over time; state the speed .* with `speed_mm_s`"):
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


def test_the_trained_model_streams_its_materials_at_any_speed_and_force(monkeypatch):
    monkeypatch.setattr(cloned_strokes, "SPEEDS_MM_S", (40.0, 120.0, 360.0))
    monkeypatch.setattr(cloned_strokes, "FORCES_N", (1.0,))
    made, _ = textures_of(["texture_flow"], ["brick", "silk"], TextureSettings(8000.0, 40))
    brick, silk = sorted(made, key=lambda texture: texture.name)
    assert [brick.name, silk.name] == ["brick", "silk"]
    assert isinstance(brick, ModulatedNoiseTexture)
    levels = [np.exp(brick.table.at(speed, 1.0).deviation[0]) for speed in (40.0, 120.0, 360.0)]
    assert levels[0] < levels[1] < levels[2]
    assert brick.level > 3 * silk.level
    with pytest.raises(
        ParameterError, match="texture_flow: has 84 materials; choose one of 84, e.g.*, with `mix`"
    ):
        textures_of(["texture_flow"], [], TextureSettings(8000.0, 40))

import io

import numpy as np
import pytest
import soundfile

from tactogram.errors import DataError
from tactogram.rendering.files import haptic_formats, read_haptic
from tactogram.signal import Signal
from tactogram.signal.io import read_signal
from tactogram_studio.generation.files import downloads, encoded, store_motion
from tactogram_studio.generation.runs import (
    GeneratingRuns,
)
from tactogram_studio.generation.state import MakePageState
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.shelf import ResultArchive


@pytest.fixture
def state(workspace):
    """Give the state of a new page."""
    return state_of(workspace)


def state_of(folder):
    place = Workspace.at(folder)
    return MakePageState(place, ResultArchive(place.studio_folder / "kept"), GeneratingRuns(place), {})


def test_a_motion_is_followed(state):
    name = store_motion(
        state.motions, "hand.csv", b"time_s,speed_mm_s,force_n\n0,200,1\n1,200,1\n1.1,200,0\n2,0,0\n"
    )
    state.choose("texture_flow")
    state.set(material={"corduroy": 1.0}, motion=state.workspace.name_of(state.motions / name))

    ((_, made),) = state.runs.generate(state.request)

    assert made.seconds == 2
    assert made.samples[0, :2000].std() > 1
    assert np.ptp(made.samples[0, 3000:]) == 0
    assert f"--motion studio/motions/{name}" in state.command()
    state.set(motion="simulated", seconds=0.5)
    ((_, other),) = state.runs.generate(state.request)
    assert other.seconds == 0.5


def test_what_is_no_motion_is_not_stored(state):
    with pytest.raises(DataError, match=r"^bad.csv: line 1: expected columns of time_s"):
        store_motion(state.motions, "bad.csv", b"a,b\n1,2\n")
    assert not any(file.name.startswith(("bad", ".bad")) for file in state.motions.glob("*"))


def stored(folder, **changes):
    values = {"rate": 1000.0, "unit": "m/s^2", "axes": ("x", "y", "z")} | changes
    noise = np.random.default_rng(0).normal(size=(len(values["axes"]), 1000)).astype(np.float32)
    return ResultArchive(folder).keep(Signal(noise, **values), title="tile: 50 %, seed 0", facts={})


def test_files_are_offered_by_what_they_are_for(tmp_path):
    listening, actuator, engine = downloads(stored(tmp_path / "made")).items()
    assert listening == (
        "For listening: 48 kHz, 16 bit, normalised to a peak of 0.5 of full scale",
        {"listening": "WAV"},
    )
    assert actuator[0].endswith("as it is: m/s², 1,000 Hz, axes x, y, z")
    assert {"wav", "csv", "npz"} <= set(actuator[1])
    assert engine[0] == "For an engine"
    assert set(engine[1]) == set(haptic_formats())
    assert engine[1]["ahap"] == "iOS: AHAP (Apple) (.ahap)"


def test_a_file_for_listening_can_be_played_anywhere(tmp_path):
    name, data, loss = encoded(stored(tmp_path / "made"), "listening")
    sound = soundfile.info(io.BytesIO(data))
    assert (name, sound.samplerate, sound.subtype, sound.channels) == (
        "tile-50-seed-0-listening.wav",
        48_000,
        "PCM_16",
        1,
    )
    assert loss == "is for listening alone: it loses its strength and its axes, combined into one channel"


def test_a_wav_has_the_samples_and_their_unit(tmp_path):
    result = stored(tmp_path / "made")
    name, data, loss = encoded(result, "wav")
    (tmp_path / name).write_bytes(data)
    assert (name, loss) == ("tile-50-seed-0.wav", "")
    read = read_signal(tmp_path / name)
    assert (read.unit, read.rate) == ("m/s^2", 1000.0)
    np.testing.assert_allclose(read.samples, result.signal().samples, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("format", sorted(haptic_formats()))
@pytest.mark.parametrize("domain", ["time", "displacement"])
def test_a_haptic_file_can_be_read_back_and_its_loss_is_said(format, domain, tmp_path):
    over = {"rate": 10.0, "unit": "1", "axes": ("along",), "domain": "displacement"}
    result = stored(tmp_path / "made", **({} if domain == "time" else over))
    name, data, loss = encoded(result, format)
    (tmp_path / name).write_bytes(data)
    assert read_haptic(tmp_path / name).signal.seconds == pytest.approx(1.0, abs=0.2)
    assert "keeps" in loss
    assert ". Verdict: " in loss
    assert ("mm/s" in loss) is (domain != "time")

"""Stimuli that follow the finger."""

import numpy as np
import pytest

from tactogram.datasets import create_store
from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.workflows.generation import cloned_strokes
from tactogram.workflows.training.train import train
from tactogram_playback.streaming.noise_texture import ModulatedNoiseTexture
from tactogram_playback.streaming.textures import AutoregressiveTexture
from tactogram_playback.transducer.circuit import PRESETS
from tactogram_study.participants.server_display import ServerDisplay
from tactogram_study.study_file import Study
from tactogram_study.trials import PresentedStimulus
from tactogram_study.workflows.stimuli import StudyStimuli


@pytest.fixture(scope="module")
def textures(recordings, tmp_path_factory):
    """An `ar_texture` of four made-up materials at two speeds, three axes."""
    folder = tmp_path_factory.mktemp("stream")
    create_store(folder / "store", recordings(count=2), name="t", licence="made in a test", simulated=True)
    return train("ar_texture", folder / "store", recipe="tiny", split="all", out=folder / "run").folder


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


def test_words_of_a_streamed_study_follow_speed_and_force(tmp_path, monkeypatch):
    monkeypatch.setattr(cloned_strokes, "SPEEDS_MM_S", (60.0, 240.0))
    monkeypatch.setattr(cloned_strokes, "FORCES_N", (0.5, 1.0))
    study = streamed({"name": "rough", "run": "texture_flow", "words": {"rough": 6.0}})
    played = StudyStimuli(study, tmp_path).played(PresentedStimulus("A", study.all_stimuli[0]))
    assert isinstance(played.stream.texture, ModulatedNoiseTexture)
    slow, fast = (played.stream.texture.table.at(speed, 0.5).deviation[0] for speed in (60.0, 240.0))
    assert fast > slow + np.log(1.2)


def test_a_tracked_carrier_is_locked_before_anybody_touches_the_display():
    ultrasonic = open_display("ultrasonic-envelope")
    display = ServerDisplay("digilent:simulated", track={"timing.settle_s": 0.01})
    display.check(ultrasonic, streams=True)
    display.lock(ultrasonic)
    facts = display._trackings["ultrasonic-envelope"].facts()
    assert facts["locked_hz"] == pytest.approx(PRESETS["plate"].resonance_hz, abs=1)
    with pytest.raises(ParameterError, match="a Digilent is tracked, got the device null"):
        ServerDisplay("null", track={}).check(ultrasonic, streams=True)

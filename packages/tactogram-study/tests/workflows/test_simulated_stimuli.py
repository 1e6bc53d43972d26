"""Stimuli that are simulated or reconstructed."""

import numpy as np
import pytest

from tactogram_study.study_file import Study
from tactogram_study.trials import PresentedStimulus
from tactogram_study.workflows.stimuli import StudyStimuli


def test_signal_and_picture_of_a_shipped_study_are_made(tmp_path):
    study = Study.load("image-words")
    stimuli = StudyStimuli(study, tmp_path)
    first = study.all_stimuli[0]
    played = stimuli.played(PresentedStimulus("", first))
    assert played.drive.signal.seconds == pytest.approx(1.0, abs=0.01)
    # peak=0.5 of full scale
    assert np.abs(played.drive.signal.samples).max() == pytest.approx(0.5, rel=0.01)
    assert stimuli.image(first).size == (128, 128)


def test_a_reconstructed_stimulus_is_its_recording_with_another_phase(study_file, tmp_path):
    study = Study.load(
        "reconstruction",
        changes={"grid.items": ["cloth"], "grid.source.simulated": "", "grid.source.file": "buzz.wav"},
    )
    stimuli = StudyStimuli(study, tmp_path)
    recorded, griffin_lim = (stimuli.signal(one) for one in study.all_stimuli)
    other = study.all_stimuli[1].model_copy(update={"name": "other", "reconstructed": "phase_gradient"})
    assert griffin_lim.samples.shape == stimuli.signal(other).samples.shape == recorded.samples.shape
    levels = [np.sqrt((one.samples**2).mean()) for one in (griffin_lim, recorded)]
    assert levels[0] == pytest.approx(levels[1], rel=0.3)
    assert not np.allclose(griffin_lim.samples, stimuli.signal(other).samples, atol=1e-3)

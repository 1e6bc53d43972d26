"""Stimuli of a study file."""

import pytest

from tactogram_study.stimuli import StimulusSource


@pytest.mark.parametrize(
    "given",
    [
        {"run": "r", "reconstructed": "griffin_lim"},
        {"file": "f", "photograph": "p"},
        {"file": "f", "vibration": "v"},
        {"file": "f", "given": {"speed_mm_s": 100.0}},
    ],
)
def test_a_condition_without_its_source_is_refused(given):
    with pytest.raises(ValueError, match="needs a recording|condition of a run"):
        StimulusSource(**given)

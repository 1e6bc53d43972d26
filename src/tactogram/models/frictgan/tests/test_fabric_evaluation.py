from dataclasses import replace

import pytest

from tactogram.errors import ParameterError
from tactogram.models.frictgan.fabric_evaluation import evaluate_fabrics, summary
from tactogram.models.frictgan.tests.test_learner import EXAMPLES, learner

FABRICS = (0.006, 0.005, 0.014, 0.005, 0.005)
"""Sec. 4: mean squared error of five fabrics, "averagely 0.035"."""


class Perfect:
    """Stands for a network that gives the recorded magnitudes."""

    def __init__(self, made):
        self.made = made
        self.spectrogram = made.spectrogram

    def pairs(self, examples, part):
        return self.made.pairs(examples, part)

    def spectra(self, batch, *, seed=0):
        real = self.spectrogram.encode(batch.friction)
        return real, real


def test_the_right_spectrum_is_as_far_as_phase_recovery_leaves_it():
    for figures in evaluate_fabrics(Perfect(learner()), EXAMPLES, part=None).values():
        assert figures.mse == 0
        assert figures.distance_db == figures.inversion_db
        assert figures.mse_recording < 3 * figures.mse_flat  # twice it where phases are independent
        assert figures.floor_db < figures.ceiling_db
        assert figures.level_error < 0.01
        assert figures.ripple_ratio == pytest.approx(1, abs=0.15)


def test_a_flat_line_has_the_ripples_variance():
    """Ribs of 0.2 of the level: 0.02 of its square, at levels of 0.6 and 0.3."""
    figures = evaluate_fabrics(Perfect(learner()), EXAMPLES, part=None)
    assert figures["coarse"].mse_flat == pytest.approx(0.02 * 0.6**2, rel=0.05)
    assert figures["fine"].mse_flat == pytest.approx(0.02 * 0.3**2, rel=0.05)


def test_what_the_paper_calls_the_average_is_the_sum_over_fabrics():
    """Cai et al. 2020, Sec. 4: five errors, "averagely 0.035"."""
    figures = evaluate_fabrics(Perfect(learner()), EXAMPLES, part=None)["coarse"]
    whole = summary({str(number): replace(figures, mse=mse) for number, mse in enumerate(FABRICS)})
    assert whole["mse_sum"] == pytest.approx(0.035)
    assert whole["mse"] == pytest.approx(0.007)
    assert whole["mse_flat"] == pytest.approx(figures.mse_flat)


def test_one_fabric_has_nothing_to_stand_beside():
    with pytest.raises(ParameterError, match="at least two fabrics"):
        evaluate_fabrics(Perfect(learner()), EXAMPLES[:2], part=None)

"""Figures of copies and of a collapse; distances and clamped shares by hand."""

import numpy as np
import pytest

from tactogram.models.ultrasonic_cgan.cluster_evaluation import clamped, distance


def test_a_copy_of_a_display_signal_and_a_collapse_show_in_the_figures(data, trained):
    """Hatori & Takemura 2023, Sec. VI: for group A "similar signals were output for all 12 types of samples"."""
    learner = trained()
    figures = learner.validate(data((7,)))
    assert figures["failed_clusters"] == 0
    assert {"told_apart_unseen", "between_surfaces", "to_nearest_display", "clamped_bins"} <= set(figures)
    generator = learner.trained[0].generator
    for layer in generator.layers:
        if hasattr(layer, "weight"):
            layer.weight.data.zero_()
    generator.layers[-2].bias.data.zero_()
    generator.layers[-2].bias.data[4] = 0.5 / learner.surfaces.display_scale  # the display's 5 Hz, as it is
    learner.trained[1] = learner.trained[0]
    figures = learner.validate(data((7,)))
    assert figures["between_surfaces"] == pytest.approx(0, abs=1e-6)
    assert figures["to_nearest_display"] == pytest.approx(0, abs=1e-3)


def test_a_distance_is_in_mean_norms():
    spectrum = np.array([3.0, 4.0])
    assert distance(spectrum, spectrum) == 0
    assert distance(spectrum, -spectrum) == 2
    assert distance(spectrum, 3 * spectrum) == 1  # 10 apart; norms of 5 and 15
    assert distance(np.zeros(2), np.zeros(2)) == 0


def test_what_is_clamped_is_a_share_of_bins_and_of_magnitudes():
    assert clamped(np.array([[1.0, -1.0], [2.0, 4.0]])) == (0.25, 0.125)
    assert clamped(np.zeros((1, 4))) == (0.0, 0.0)

"""Numbers of the paper, and what follows from them."""

import pytest

from tactogram.models.stroke_cnn.config import Config

PAPER = {
    "window": 200, "filters": (64, 64, 128, 128, 256, 256), "kernel": 5, "pool": 2
}  # fmt: skip
"""Saga et al. 2020, Sec. II-B."""


def test_the_recipe_paper_has_the_papers_numbers(paper_values):
    assert paper_values("stroke_cnn", PAPER) == PAPER


def test_pooling_leaves_an_eighth_of_a_window():
    assert Config().points() == 25
    with pytest.raises(ValueError, match="window 8 is too short for these filters, kernel and pool"):
        Config(window=8, pool=3)


def test_windows_of_a_recording_are_a_share_of_one_apart_and_never_none():
    assert Config().hop_samples == 100
    assert Config(window=8, hop=0.01).hop_samples == 1


def test_passes_are_the_samples_of_all_updates_over_those_of_the_recordings():
    assert Config(steps=50, batch_size=4, window=200).passes(8000) == 5

"""Distances of generated items to their targets, and their map."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_benchmark.experiments.word_map import distances_to_targets, word_map_figure


def test_distance_is_to_the_target_in_the_name():
    targets = {"p1": np.array([1.0, 1.0]), "p2": np.array([7.0, 7.0])}
    found = distances_to_targets({"A/p1": np.array([4.0, 5.0]), "B/p2": np.array([7.0, 7.0])}, targets)
    assert found["A/p1"] == ("p1", pytest.approx(np.sqrt(12.5)))
    assert found["B/p2"] == ("p2", 0.0)
    with pytest.raises(ParameterError, match="A/p9: target must be one of p1, p2"):
        distances_to_targets({"A/p9": np.zeros(2)}, targets)


def test_word_map_keeps_distances_where_two_words_are_all_there_is():
    kinds = {
        "plates": {"p1": np.array([1.0, 2.0]), "p2": np.array([6.0, 3.0])},
        "signals": {"s1": np.array([2.0, 7.0])},
        "made": {"p1": np.array([4.0, 6.0])},
    }
    axes = word_map_figure(kinds, ("rough", "sticky"), targets={"made:p1": "plates:p1"}).axes[0]
    [line] = [one for one in axes.lines if one.get_marker() == "None"]
    assert np.hypot(*np.diff(line.get_xydata(), axis=0)[0]) == pytest.approx(5.0)
    assert f"{np.sqrt(25 / 2):.1f}" in [text.get_text() for text in axes.texts]

"""Recognition by hand: shares that a classifier names right, of a set and trained on a set, and of copies."""

import numpy as np
import pytest

from tactogram.evaluation.generation.comparison import PieceSet
from tactogram.evaluation.generation.recognition import (
    measure_classification,
    measure_memorisation,
    measure_transfer,
)
from tactogram.signal import Signal


def constant(value):
    return Signal(np.full(100, value), 100, "N")


def pieces(**values):
    return {
        name: PieceSet([constant(x) for x in levels], [0] * len(levels)) for name, levels in values.items()
    }


CUT = {
    "test": pieces(cork=[1, 1, 1, 2], tile=[2, 2, 2, 2]),
    "floor": pieces(cork=[1, 1], tile=[2, 2]),
    "others": pieces(cork=[1], tile=[2], wool=[3]),
    "model": pieces(cork=[1, 2], tile=[2, 1]),
}
"""Simulated: of cork is what is nearer to 1, of tile what is nearer to 2; one test piece of cork is not."""


class Classifier:
    materials = ("cork", "oak")

    def probabilities(self, signal):
        return np.array([signal.samples[0, 0] == 1, signal.samples[0, 0] != 1], float)


def test_a_classifier_names_a_share_right_and_nothing_of_what_it_does_not_know():
    table = measure_classification(Classifier(), CUT)
    assert table["cork"] == {"floor": 0.75, "model": 0.5, "ceiling": 0.5, "nearest_other": None}
    assert set(table["tile"].values()) == {None}


def test_a_set_is_tested_on_and_trained_on():
    def fit(signals, labels):
        means = {name: np.mean([s.samples.mean() for s, y in zip(signals, labels, strict=True) if y == name])
                 for name in dict.fromkeys(labels)}  # fmt: skip
        return lambda tested: [
            min(means, key=lambda name: abs(means[name] - s.samples.mean())) for s in tested
        ]

    tables = measure_transfer(fit, CUT)
    assert tables["tested_on_generated_accuracy"]["cork"] == {
        "floor": 0.75, "model": 0.5, "ceiling": 0.5, "nearest_other": None,
    }  # fmt: skip
    assert tables["tested_on_generated_accuracy"]["tile"]["model"] == 0.5
    # Both means of the generated set are 1.5, and the first material takes all.
    assert tables["trained_on_generated_accuracy"]["cork"]["model"] == 1
    assert tables["trained_on_generated_accuracy"]["tile"]["model"] == 0


def test_a_copy_is_nearer_to_the_training_data_than_all_that_is_unseen():
    rng = np.random.default_rng(0)

    def noise(count):
        return [Signal(x, 1000, "N") for x in rng.standard_normal((count, 1000))]

    train = {"cork": noise(4)}
    copies = [one.cut(0, 500) for one in train["cork"]]
    cut = {
        "test": {"cork": PieceSet([one.cut(0, 500) for one in noise(3)], [0, 1, 2])},
        "model": {"cork": PieceSet(copies, [0, 1, 2, 3])},
    }
    tables = measure_memorisation(cut, train, 1, lambda done, of: None)
    share, nearness = tables["memorised_share"]["cork"], tables["training_correlation"]["cork"]
    assert (share["model"], share["floor"], share["ceiling"]) == (1, 0.25, 1)
    assert nearness["model"] == pytest.approx(1, abs=1e-3)
    assert nearness["floor"] < 0.5
    assert set(
        measure_memorisation(cut, {}, 1, lambda done, of: None)["memorised_share"]["cork"].values()
    ) == {None}

from dataclasses import replace

import numpy as np
import pytest

from tactogram.evaluation.mixing.ladder import MixSeries
from tactogram.evaluation.mixing.placement import positions
from tactogram.signal import Signal


def noise(level_db, seed):
    samples = np.random.default_rng(seed).standard_normal((1, 1000))
    return Signal(10 ** (level_db / 20) * samples, 1000, "N")


def mixes(levels_db, **changes):
    steps = [[noise(level, 10 * k + i) for i in range(4)] for k, level in enumerate(levels_db)]
    start, end = ([noise(level, 900 + level + 30 * i) for i in range(4)] for level in (0, 20))
    ladder = positions(steps, start, end)
    made = MixSeries("cork", "tile", "sum", tuple(s[0] for s in steps), ladder, None, None, simulated=True)
    return replace(made, **changes)


@pytest.mark.parametrize(
    ("levels_db", "said"),
    [
        ((0, 7, 13, 20), "moves one way, from "),
        ((0, 15, 5, 20), "rises, but falls back by 0.5"),
        ((20, 10, 0, 0), "does not rise beyond what chance explains"),
        ((0, 12, 20), "half way at 0.4"),
        ((0, 2, 4, 6), "It never gets half way to tile."),
    ],
)
def test_words_say_what_the_measure_found(levels_db, said):
    assert said in mixes(levels_db).in_words()


def test_both_weights_are_named():
    made = mixes((0, 5, 10, 20, 20, 20))
    assert made.caption(2) == "0.4 tile, 0.6 cork"
    assert replace(made, mode="add").caption(2) == "0.4 tile, 1 cork"
    assert made.start_weights.tolist() == [1, 0.8, 0.6, 0.4, 0.2, 0]

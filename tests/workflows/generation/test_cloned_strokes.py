"""Strokes of a clone, over speed and force."""

import numpy as np

from tactogram.signal import Signal
from tactogram.workflows.generation.cloned_strokes import live_map


def test_a_live_map_covers_the_speeds_that_a_model_predicts():
    seen = []

    class Predicted:
        @property
        def generator(self):
            return self

        def limits(self, condition):
            return []

        def generate(self, condition, *, seconds, seed):
            seen.append(condition)
            noise = np.random.default_rng(seed).standard_normal((1, 4000))
            return Signal(noise * condition["speed_mm_s"], 1000.0, "m/s^2", ("z",))

    surface = live_map(Predicted(), {"words": {"rough": 6}}, {"speed_mm_s": (50.0, 200.0)})
    assert surface.conditions[:, 0].tolist() == [50, 60, 120, 200]
    assert np.isnan(surface.conditions[:, 1]).all()
    assert [condition.keys() for condition in seen] == [{"words", "speed_mm_s"}] * 4
    assert surface.at(200.0).deviation[0] > surface.at(50.0).deviation[0] + 1

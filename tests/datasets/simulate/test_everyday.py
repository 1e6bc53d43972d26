"""Everyday surfaces: names, and strokes at any speed and force."""

import numpy as np
import pytest

from tactogram.datasets.simulate import make, tasks
from tactogram.datasets.simulate.everyday import EVERYDAY, SYNONYMS
from tactogram.datasets.simulate.random_surfaces import FORCES_N, SPEEDS_MM_S


def strokes(name, speed):
    number = [surface.name for surface in EVERYDAY].index(name)
    found = tasks("everyday", seed=0, per_class=1, seconds=1.0, speeds_mm_s=[speed])
    return make(found[number]).streams["acceleration"].samples


def test_names_are_different_and_only_surfaces_have_others():
    names = [surface.name for surface in EVERYDAY]
    assert len(set(names)) == len(names)
    assert set(SYNONYMS) <= set(names)
    others = [other for called in SYNONYMS.values() for other in called]
    assert len(set(others)) == len(others)


def test_each_stroke_has_a_speed_and_a_force_of_its_own():
    found = tasks("everyday", seed=0, own_images=False)
    assert len(found) == 8 * len(EVERYDAY)
    assert {task.contactor for task in found} == {"finger"}
    assert len({(task.speed_mm_s, task.force_n) for task in found}) > 0.99 * len(found)
    for limits, values in (
        (SPEEDS_MM_S, [task.speed_mm_s for task in found]),
        (FORCES_N, [task.force_n for task in found]),
    ):
        assert limits[0] <= min(values) < 1.2 * limits[0]
        assert limits[1] >= max(values) > 0.8 * limits[1]


@pytest.mark.parametrize(("rough", "smooth"), [("coarse-sandpaper", "fine-sandpaper"), ("brick", "glass")])
def test_what_is_called_rough_vibrates_more(rough, smooth):
    levels = [np.std(strokes(name, 100.0), axis=1).max() for name in (rough, smooth)]
    assert levels[0] > 2 * levels[1]


def test_ribs_are_felt_at_the_speed_over_their_period():
    x = strokes("ribbed-rubber-mat", 140.0)[2][200:-200]
    density = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)))) ** 2
    frequency = np.fft.rfftfreq(len(x), 1 / 2500)
    band = (frequency > 20) & (frequency < 65)
    assert frequency[band][density[band].argmax()] == pytest.approx(140 / 3.5, rel=0.2)

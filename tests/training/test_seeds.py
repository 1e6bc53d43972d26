"""Seeds of surfaces: other surfaces differ in noise, one surface at other speeds does not."""

from itertools import combinations

import numpy as np
import pytest

from tactogram.signal import Image, Signal
from tactogram.training.seeds import surface_seed
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.training.loaded_run import load_run

STROKE = Signal(np.ones((1, 8), np.float32), 1000.0, "m/s^2", ("z",))
PICTURE = Image(np.zeros((2, 2, 3), np.uint8))


def test_surfaces_have_different_seeds():
    other = STROKE.with_samples(2 * STROKE.samples)
    described = [
        {"material": "cork"},
        {"material": "tile"},
        {"material": {"cork": 0.5, "tile": 0.5}},
        {"words": {"rough": 2.0, "warm": 1.0}},
        {"words": {"rough": 2.5, "warm": 1.0}},
        {"words": {"rough": 1.0, "warm": 2.0}},
        {"image": PICTURE},
        {"image": Image(np.full((2, 2, 3), 9, np.uint8))},
        {"vibration": STROKE},
        {"vibration": other},
    ]
    assert len({surface_seed(seed, each) for each in described for seed in (0, 1)}) == 2 * len(described)


@pytest.mark.parametrize("given", [{"material": "cork"}, {"vibration": STROKE}, {"words": {"rough": 2.0}}])
def test_a_surface_keeps_its_seed_at_another_speed(given):
    moved = {"speed_mm_s": 90.0, "force_n": 2.0, "vibration_speed_mm_s": 60.0, "motion": None}
    assert surface_seed(3, given) == surface_seed(3, {**given, **moved})


def test_mixes_of_the_same_materials_share_a_seed():
    seeds = [surface_seed(3, {"material": {"tile": w, "cork": 1 - w}}) for w in (0.25, 0.5, 1.0, 0.0)]
    assert seeds[0] == seeds[1]
    assert seeds[2:] == [surface_seed(3, {"material": name}) for name in ("tile", "cork")]


def test_materials_of_one_seed_do_not_swell_together():
    run = load_run("texture_flow")

    def levels(name, speed=120.0):
        [made] = generate(run, {"material": name, "speed_mm_s": speed, "force_n": 1.0}, seconds=6.0, seed=5)
        frame = round(0.02 * made.rate)
        frames = made.samples[0, : len(made) // frame * frame].reshape(-1, frame)
        return np.log(np.std(frames, axis=1))

    names = run.kind.materials[:5]
    found = [levels(name) for name in names]
    apart = [np.corrcoef(one, other)[0, 1] for one, other in combinations(found, 2)]
    assert np.mean(apart) < 0.2
    assert np.corrcoef(found[1], levels(names[1], 110.0))[0, 1] > 0.6

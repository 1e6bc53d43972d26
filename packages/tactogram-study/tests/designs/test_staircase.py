import numpy as np
import pytest
from scipy.stats import norm

from tactogram_study.designs.staircase import Staircase, StaircaseTrack


def test_a_staircase_moves_by_levitts_rule():
    design = Staircase(start_db=0, steps_db=(4, 2), up=1, down=2, reversals=3, lowest_db=-10)
    track, path = StaircaseTrack(0.0), []
    for correct in (1, 1, 1, 1, 0, 1, 0, 1, 1, 1):
        track = design.after(track, correct=bool(correct))
        path.append(track.intensity)
    # Two right: down 4. A wrong one turns it: up 2, the second step. And so on; counted by hand.
    assert path == [0, -4, -4, -8, -6, -6, -4, -4, -6, -6]
    assert track.reversals == (-8, -4)
    assert not design.ended(track)
    assert design.ended(StaircaseTrack(0.0, 9, (1, 2, 3)))


def test_a_staircase_stays_within_its_limits():
    design = Staircase(start_db=0, steps_db=(8,), down=1, lowest_db=-10, highest_db=5)
    down = StaircaseTrack(0.0)
    for _ in range(3):
        down = design.after(down, correct=True)
    up = design.after(StaircaseTrack(0.0), correct=False)
    assert (down.intensity, up.intensity) == (-10, 5)


def test_three_down_one_up_settles_at_79_percent():
    # Levitt (1971): p**3 = 1/2, p = 0.794. Simulated observer: 0.5 + 0.5 Phi(x / 4), which is there at x = 0.89.
    design = Staircase(steps_db=(2,), down=3, reversals=100, start_db=4, lowest_db=-60, highest_db=60)
    rng, track, met = np.random.default_rng(0), StaircaseTrack(4.0), []
    for _ in range(2500):
        met.append(track.intensity)
        track = design.after(track, correct=rng.random() < 0.5 + 0.5 * norm.cdf(track.intensity / 4))
    turned = np.array(track.reversals)
    assert turned.mean() == pytest.approx(norm.ppf((0.5 ** (1 / 3) - 0.5) / 0.5) * 4, abs=0.8)


def test_staircases_of_several_targets_are_mixed_against_one_standard(make_study, taken, trials):
    design = {"kind": "staircase", "standard": "cork-recorded", "most_trials": 10}
    pages, _ = taken(make_study(design))
    assert {page.more["staircase"] for page in trials(pages)} == {
        "cork-generated",
        "tile-recorded",
        "tile-generated",
    }
    for page in trials(pages):
        beside = page.slot("B" if page.questions[0].side == "A" else "A")
        assert (beside.stimulus.name, beside.gain_db) == ("cork-recorded", 0.0)
        assert page.slot(page.questions[0].side).gain_db == page.questions[0].values["A"]

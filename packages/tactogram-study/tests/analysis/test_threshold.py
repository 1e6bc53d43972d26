import numpy as np
import pytest
from scipy.special import expit, logit

from tactogram.errors import DataError, ParameterError
from tactogram_study.analysis.threshold import SETTLED_3_DOWN, estimate_threshold, settled_share
from tactogram_study.designs.staircase import Staircase, StaircaseTrack


def taken(design, place, slope, rng):
    """Return intensities and answers of a simulated person."""
    track, x, right = StaircaseTrack(design.start_db), [], []
    while not design.ended(track):
        x.append(track.intensity)
        right.append(bool(rng.random() < 0.5 + 0.48 * expit(slope * (track.intensity - place))))
        track = design.after(track, correct=right[-1])
    return np.array(x), np.array(right, float)


def test_thresholds_of_staircases_are_neither_high_nor_low():
    design = Staircase(reversals=12, most_trials=120, lowest_db=-60, highest_db=6)
    rng, slope = np.random.default_rng(0), 0.45
    places = -20 + 3 * rng.standard_normal(120)
    at_share = logit((SETTLED_3_DOWN - 0.5) / 0.48) / slope
    found = [estimate_threshold(*taken(design, place, slope, rng)) for place in places]
    errors = np.array([one.threshold for one in found]) - places - at_share
    assert abs(errors.mean()) < 0.45  # 0.3, and what 120 leave to chance
    assert errors.std() < 2.2
    covered = np.mean(
        [one.low <= place + at_share <= one.high for one, place in zip(found, places, strict=True)]
    )
    assert covered > 0.9


def test_many_answers_decide_whatever_the_priors_say():
    x = np.repeat(np.arange(-24.0, -8, 2), 400)
    rng = np.random.default_rng(1)
    right = rng.random(len(x)) < 0.5 + 0.5 * expit(1.5 * (x + 16))
    found = estimate_threshold(x, right)
    assert found.threshold == pytest.approx(-16 + logit((SETTLED_3_DOWN - 0.5) / 0.5) / 1.5, abs=0.2)
    assert found.slope == pytest.approx(1.5, rel=0.15)
    assert found.high - found.low < 0.8
    assert found.inside


@pytest.mark.parametrize(("down", "share"), [(2, 0.5**0.5), (3, 0.5 ** (1 / 3)), (1, None)])
def test_the_rule_is_seen_in_the_answers(down, share):
    design = Staircase(down=down, reversals=8, lowest_db=-60, highest_db=6)
    found = settled_share(*taken(design, -20.0, 0.5, np.random.default_rng(2)))
    assert found == (None if share is None else pytest.approx(share))


def test_what_gives_no_threshold_is_refused():
    with pytest.raises(DataError, match="both right and wrong"):
        estimate_threshold([0.0, -2.0], [1, 1])
    with pytest.raises(ParameterError, match="guess < share"):
        estimate_threshold([0.0, -2.0], [1, 0], share=0.4)
    assert settled_share([0.0, 0.0], [1, 1]) is None

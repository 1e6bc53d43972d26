import numpy as np
import pytest
from scipy import special
from simulated_answers import only, simulated

from tactogram_study.analysis.threshold import reversal_threshold
from tactogram_study.answers import Answers
from tactogram_study.designs.analysis.staircase import reversals_of, simulated_thresholds
from tactogram_study.designs.staircase import Staircase
from tactogram_study.planned import AnalysisPlan
from tactogram_study.study_analysis import analyse


def test_reversals_leave_out_the_first_and_count_peaks_and_valleys_alike():
    x, turned = [0, 8, 4, 6, 2, 4, 3], [False, True, True, True, True, True, False]
    assert reversal_threshold(x, turned) == pytest.approx((2 + 4) / 2)
    assert reversal_threshold(x, [False] * 7) is None


def test_simulated_staircases_settle_where_three_in_a_row_are_as_likely_as_not():
    rng = np.random.default_rng(0)
    place = np.full(400, -20.0)
    found = simulated_thresholds(place, 120, slope=0.5, rng=rng)
    settled = -20 + special.logit((0.5 ** (1 / 3) - 0.5) / 0.5) / 0.5
    assert found.mean() == pytest.approx(settled, abs=0.5)


@pytest.mark.parametrize("trials", [4, 12, 25, 60])
def test_many_simulated_staircases_at_once_are_those_of_the_design_one_by_one(trials):
    place, slope = np.array([-25.0, -20.0, -8.0, -3.0, 2.0, 6.0]), 0.5
    found = simulated_thresholds(place, trials, slope=slope, rng=np.random.default_rng(3))
    rule = Staircase(most_trials=10_000, reversals=100, lowest_db=-900, highest_db=900)
    tracks, rng = [rule.start() for _ in place], np.random.default_rng(3)
    for _ in range(trials):
        x = np.array([track.intensity for track in tracks])
        right = rng.random(len(place)) < 0.5 + 0.5 * special.expit(slope * (x - place))
        tracks = [rule.after(track, correct=bool(r)) for track, r in zip(tracks, right, strict=True)]
    counted = [track.reversals[2:] for track in tracks]
    expected = [np.mean(c) if len(c) > 1 else t.intensity for c, t in zip(counted, tracks, strict=True)]
    assert found == pytest.approx(expected)
    assert any(len(c) > 1 for c in counted) == (trials > 4)


def staircase(people=4, threshold=-18.0, seed=0, trials=50):
    rng = np.random.default_rng(seed)
    rows = []
    for p in range(people):
        x, run, own = 0.0, 0, threshold + 2 * rng.standard_normal()
        for t in range(trials):
            right = bool(rng.random() < 0.5 + 0.5 / (1 + np.exp(-(x - own))))
            rows.append((p, t + 1, {"condition": "tone", "stimulus": "tone", "value": x, "correct": right}))
            run = run + 1 if right else 0
            if not right or run == 3:
                x, run = x + (-4.0 if right else 4.0), 0
    return simulated("staircase", "which", rows)


def test_the_threshold_that_was_put_in_is_found():
    section = only(analyse(staircase(), plan=AnalysisPlan({}, draws=100)))
    [by_reversals] = section.role("confirmatory")
    settled = -18 + np.log((0.5 ** (1 / 3) - 0.5) / (1 - 0.5 ** (1 / 3)))
    assert by_reversals.low < settled < by_reversals.high
    assert [f.test for f in section.role("as printed")] == []


def test_the_last_reversal_counts_though_nothing_follows_it():
    values, right = [0, 0, 0, -4, 0, 0, 0, -4], [1, 1, 1, 0, 1, 1, 1, 0]
    rows = [
        (0, t + 1, {"value": float(v), "correct": bool(r)})
        for t, (v, r) in enumerate(zip(values, right, strict=True))
    ]
    own = simulated("staircase", "which", rows)
    assert np.flatnonzero(reversals_of(own)).tolist() == [3, 6, 7]
    assert np.flatnonzero(reversals_of(Answers(own.rows[:7]))).tolist() == [3, 6]
    assert np.flatnonzero(reversals_of(Answers(own.rows[:6]))).tolist() == [3]

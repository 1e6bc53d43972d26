"""The truth that a recovery is held against, by rule and by many simulated answers."""

import numpy as np
import pytest
from benchmarks.experiments import study_recovery as recovery, study_truths
from benchmarks.experiments.study_cases import STUDIES

from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.simulated_participants import simulated_answers
from tactogram_study.study_file import Study


@pytest.mark.parametrize(
    ("name", "changes", "group", "first", "second"),
    [
        ("plate-words", {"grid.count": 2}, "stimulus", "plate01", "plate02"),
        ("evoked-words", {"grid.count": 2, "design.set_size": 2}, "stimulus", "image001", "image002"),
        ("image-words", {"grid.count": 1}, "condition", "1", "1000"),
    ],
)
def test_the_truth_is_that_of_many_simulated_answers(name, changes, group, first, second):
    study, of = Study.load(name, changes=changes), STUDIES[name]
    effect = SimulatedEffect(**of.effect, **of.people)
    answers = simulated_answers(study, 120, effect=effect, seed=1).where(
        lambda row: row.design != "questions"
    )
    means = [np.mean(answers.where(**{group: key}).numbers()) for key in (first, second)]
    truth = STUDIES[name].findings[0].truth(effect, study, 1)
    assert abs(truth) > 0.3
    assert means[0] - means[1] == pytest.approx(truth, abs=0.1 if name != "evoked-words" else 0.04)
    nothing = STUDIES[name].findings[0].truth(SimulatedEffect(**of.people), study, 1)
    assert nothing == pytest.approx(0, abs=1e-12)


def test_steps_are_rounded_and_held_at_the_ends():
    rng = np.random.default_rng(0)
    drawn = np.clip(np.round(5.5 + 1.4 * rng.standard_normal(200_000)), 1, 7)
    assert study_truths.expected_steps(5.5, 1.4, 1, 7) == pytest.approx(drawn.mean(), abs=0.01)
    assert study_truths.expected_steps(4, 1.4, 1, 7) == pytest.approx(4)


def test_a_pair_that_stands_the_other_way_round_is_turned():
    one = {"of": "cloth over carpet", "estimate": -1.0, "low": -1.5, "high": -0.5}
    turned = recovery._found([one], "carpet over cloth")
    assert (turned["estimate"], turned["low"], turned["high"]) == (1.0, 0.5, 1.5)
    gap = {**one, "measure": "carpet minus tile, dB"}
    assert recovery._in_order(gap, "tile minus carpet")["measure"] == "tile minus carpet, dB"
    assert recovery._in_order(gap, "tile minus carpet")["estimate"] == 1.0
    assert recovery._in_order(gap, "carpet minus tile") == gap
    assert recovery._in_order(gap, "") == gap

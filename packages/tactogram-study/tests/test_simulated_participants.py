import numpy as np
import pytest
from scipy.stats import norm

from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.trials import Participant


def test_an_effect_that_is_put_in_is_there_and_none_is_none(make_study, taken, trials):
    study = make_study({"kind": "two_area", "repeats": 100, "realism": False})
    right = {}
    for d_prime in (0.0, 2.0):
        pages, given = taken(study, effect=SimulatedEffect(d_prime=d_prime))
        asked = [page.questions[0] for page in trials(pages)]
        told = [one.responses["which"] for one in given[2:-1]]
        right[d_prime] = np.mean([a.right == t for a, t in zip(asked, told, strict=True)])
    assert right[0.0] == pytest.approx(0.5, abs=0.1)
    assert right[2.0] == pytest.approx(norm.cdf(2**0.5), abs=0.07)


def test_simulated_participants_can_prefer_differently_and_each_the_same_again(make_study, taken, trials):
    study = make_study({"kind": "pairwise", "choice": "listed", "repeats": 20})
    won = []
    for number in range(1, 9):
        pages, given = taken(study, Participant(f"P{number}", number), SimulatedEffect(preference_sd=3.0))
        asked = [page.questions[0] for page in trials(pages)]
        first = [one.responses["preferred"] == a.side for a, one in zip(asked, given[2:-1], strict=True)]
        pair = (asked[0].stimulus, asked[0].condition, asked[0].other, asked[0].other_condition)
        same = [(a.stimulus, a.condition, a.other, a.other_condition) == pair for a in asked]
        won.append(np.mean(np.array(first)[same]))
    assert np.mean(np.abs(np.array(won) - 0.5)) > 0.3  # alike, they would be 0.09 from one half
    assert min(won) < 0.2 < 0.8 < max(won)

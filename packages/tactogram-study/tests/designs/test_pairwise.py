import itertools

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize
from scipy.stats import norm

from tactogram_study.designs.pairwise import expected_information, posterior
from tactogram_study.simulated_observer import SimulatedEffect


def test_the_posterior_of_preferences_is_at_its_maximum():
    won = [(0, 1), (0, 1), (1, 2), (0, 2), (2, 1)]

    def loss(u):
        return sum(np.log1p(np.exp(u[j] - u[i])) for i, j in won) + (u**2).sum() / 8

    mean, covariance = posterior(won, 3, prior_sd=2.0)
    assert mean == pytest.approx(minimize(loss, np.zeros(3), tol=1e-12).x, abs=1e-5)
    assert np.linalg.eigvalsh(covariance).min() > 0
    assert posterior([], 3, prior_sd=2.0)[1] == pytest.approx(4 * np.eye(3))


@pytest.mark.parametrize(("mean", "sd"), [(0.0, 0.5), (1.0, 2.0), (-3.0, 3.0)])
def test_expected_information_is_that_of_naive_integration(mean, sd):
    def entropy(p):
        return 0.0 if p in (0.0, 1.0) else -(p * np.log2(p) + (1 - p) * np.log2(1 - p))

    def p(d):
        return 1 / (1 + np.exp(-d))

    def expected(f):
        return quad(lambda d: f(d) * norm.pdf(d, mean, sd), mean - 9 * sd, mean + 9 * sd, limit=200)[0]

    naive = entropy(expected(p)) - expected(lambda d: entropy(p(d)))
    covariance = np.diag([sd**2 / 2, sd**2 / 2])
    [ours] = expected_information(np.array([mean, 0.0]), covariance, [(0, 1)])
    assert ours == pytest.approx(naive, abs=2e-6)


def test_the_next_pair_is_the_one_that_tells_most_and_never_the_same_at_once(make_study, taken, trials):
    study = make_study({"kind": "pairwise", "comparisons": 12})
    pages, _ = taken(study, effect=SimulatedEffect(shift={"generated": 3.0}))
    pairs = [(page.more["first"], page.more["second"]) for page in trials(pages)]
    assert all(one != other for one, other in itertools.pairwise(pairs))
    assert len(set(pairs)) > 3
    bits = [float(page.more["expected_bits"]) for page in trials(pages)]
    assert bits[0] == max(bits)
    assert bits[-1] < bits[0]

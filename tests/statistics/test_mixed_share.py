import numpy as np
import pytest
from scipy import integrate, optimize, special, stats

from tactogram.errors import ParameterError
from tactogram.statistics.mixed_share import MixedShareModel, mixed_share


def answers(hits, asked):
    """Return answers, and who answered and of which texture, from hits of shape (person, texture)."""
    people, textures = hits.shape
    flat = np.concatenate([[1.0] * one + [0.0] * (asked - one) for one in hits.ravel()])
    who = np.repeat(np.arange(people), textures * asked).tolist()
    return flat, {
        "participant": who,
        "texture": np.tile(np.repeat(np.arange(textures), asked), people).tolist(),
    }


def test_where_nobody_differs_the_interval_is_that_of_all_answers_together():
    found = mixed_share(*answers(np.full((12, 3), 6), 10))

    def beyond(logit):
        return 2 * 360 * (
            special.rel_entr([0.6, 0.4], special.expit([logit, -logit]))
        ).sum() - stats.chi2.isf(0.05, 1)

    ends = [optimize.brentq(beyond, special.logit(0.6), end) for end in (-1, 2)]
    assert (found.low, found.high) == pytest.approx(special.expit(ends), abs=1e-3)
    assert found.estimate == pytest.approx(0.6, abs=1e-4)
    assert found.note == "the fit leaves participants and textures no spread"


def test_people_who_differ_widen_it_as_t_of_their_logits():
    own = special.expit(0.4 + 1.5 * stats.norm.ppf((np.arange(16) + 0.5) / 16))
    found = mixed_share(*answers(np.round(20 * own).astype(int)[:, None], 20))
    low, high = special.logit([found.low, found.high])
    spread = np.std(special.logit((20 * own + 0.5) / 21), ddof=1)
    assert high - low == pytest.approx(2 * stats.t.isf(0.025, 15) * spread / 4, rel=0.1)
    assert low < 0.4 < high
    assert found.note == ""


def test_few_textures_that_differ_leave_the_interval_that_t_of_as_many_values_leaves():
    hits, groups = answers(np.array([[80, 120, 160]]), 200)
    found = mixed_share(hits, groups)  # one participant: of textures alone
    logits = special.logit([0.4, 0.6, 0.8])
    half = stats.t.isf(0.025, 2) * logits.std(ddof=1) / np.sqrt(3)
    assert special.logit(found.high) - special.logit(found.low) == pytest.approx(2 * half, rel=0.1)


def test_laplace_is_near_the_integral():
    hits = np.array([3.0, 12.0, 20.0, 17.0, 25.0])
    model = MixedShareModel(hits, np.full(5, 30.0), np.eye(5), np.zeros(5, np.int64))

    def exact(logit, spread):
        def at(effect, hit):
            eta = logit + spread * effect
            return np.exp(hit * eta - 30 * np.logaddexp(0, eta) + 15) * stats.norm.pdf(effect)

        return sum(-2 * (np.log(integrate.quad(at, -6, 6, (hit,), points=[0])[0]) - 15) for hit in hits)

    for logit, spread in ((0.0, 1.0), (0.5, 0.6), (-1.0, 2.0)):
        assert model.deviance(logit, np.array([spread])) == pytest.approx(exact(logit, spread), abs=0.15)
    assert model.deviance(0.3, np.zeros(1)) == pytest.approx(
        -2 * (hits * 0.3 - 30 * np.logaddexp(0, 0.3)).sum(), abs=1e-9
    )


def test_what_has_no_model_is_refused():
    with pytest.raises(ParameterError, match="two members of a group"):
        mixed_share([0, 1], {"participant": ["a", "a"]})
    with pytest.raises(ParameterError, match="answers of both kinds"):
        mixed_share([1, 1], {"participant": ["a", "b"]})


def test_effects_are_the_likeliest_where_whole_newton_steps_go_back_and_forth():
    hits, asked, logit, spread = np.array([0.0, 59, 12]), np.full(3, 60.0), 2.4, 4.9
    model = MixedShareModel(hits, asked, np.eye(3), np.zeros(3, np.int64))

    def alone(hit):
        def below(u):
            eta = logit + spread * u
            return u**2 - 2 * (hit * eta - 60 * np.logaddexp(0, eta))

        found = optimize.minimize_scalar(below, bracket=(-9, 9), options={"xtol": 1e-12})
        p = special.expit(logit + spread * found.x)
        return found.fun + np.log(1 + spread**2 * 60 * p * (1 - p))

    assert model.deviance(logit, np.array([spread])) == pytest.approx(sum(map(alone, hits)), abs=1e-6)


def test_a_spread_that_comes_to_0_on_the_way_can_grow_again():
    hits = np.array([[1, 0, 0], [4, 2, 1], [0, 0, 0], [1, 0, 0], [5, 5, 5]], np.float64)
    members = np.hstack([np.repeat(np.eye(5), 3, 0), np.tile(np.eye(3), (5, 1))])
    model = MixedShareModel(hits.ravel(), np.full(15, 5.0), members, np.repeat([0, 1], [5, 3]))
    logits, spreads = np.linspace(-3, 1, 5), np.linspace(0, 5, 6)
    least = min(model.deviance(a, np.array([b, c])) for a in logits for b in spreads for c in spreads)
    assert model.fitted()[2] <= least

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import ParameterError
from tactogram.evaluation.checkpoint_selection import (
    IterationSelector,
    SelectedIteration,
    SelectionRule,
    choose,
    smoothed,
)

RULE = SelectionRule(window=3)


def curves(losses, rates):
    return np.array(losses, float), np.array(rates, float)


def test_selects_the_smallest_loss_where_the_smoothed_rate_is_40_to_60_percent():
    """Hatori & Takemura 2023, Sec. IV-C: correct "between 40% and 60%"."""
    losses = [9.0, 5.0, 0.1, 3.0, 0.7, 2.0, 0.2]
    rates = [1.0, 1.0, 1.0, 0.3, 0.3, 0.5, 0.9]
    # Smoothed: -, -, 1, 0.767, 0.533, 0.367, 0.567
    assert choose(*curves(losses, rates), RULE) == SelectedIteration(7, 0.2, pytest.approx(0.5667, abs=1e-4))


def test_uses_the_smoothed_rate_not_that_of_one_batch():
    losses, rates = curves([1, 1, 1, 0.1, 1], [0.9, 0.9, 0.9, 0.5, 0.9])
    assert choose(losses, rates, RULE) is None
    assert choose(losses, rates, SelectionRule(window=1)) == SelectedIteration(4, 0.1, 0.5)


def test_training_fails_if_the_discriminator_is_always_right():
    assert choose(np.linspace(3, 9, 500), np.full(500, 0.99), SelectionRule()) is None


def test_training_fails_if_the_discriminator_is_always_wrong():
    assert choose(np.linspace(1, 0.01, 500), np.full(500, 0.1), SelectionRule()) is None


def test_a_loss_of_zero_is_never_selected():
    """Hatori & Takemura 2023, Sec. IV-C: "the generator's loss was the smallest non-zero value"."""
    losses, rates = curves([0, 0, 0, 0.4, 0], [0.5] * 5)
    assert choose(losses, rates, RULE) == SelectedIteration(4, 0.4, 0.5)
    assert choose(np.zeros(5), rates, RULE) is None


def test_limits_are_inclusive():
    for edge in (0.4, 0.6):
        assert choose(np.ones(4), np.full(4, edge), SelectionRule(window=1)) == SelectedIteration(
            1, 1.0, edge
        )
    assert choose(np.ones(4), np.full(4, 0.39), SelectionRule(window=1)) is None
    assert choose(np.ones(4), np.full(4, 0.61), SelectionRule(window=1)) is None


def test_nothing_is_selected_before_the_window_is_full():
    assert choose(*curves([0.1, 0.1], [0.5, 0.5]), RULE) is None
    assert choose(*curves([0.1, 0.2, 0.3], [0.5, 0.5, 0.5]), RULE) == SelectedIteration(3, 0.3, 0.5)


def test_initial_iterations_are_skipped():
    losses, rates = curves([0.1, 0.2, 0.3, 0.4], [0.5] * 4)
    assert choose(losses, rates, SelectionRule(window=1, after=2)) == SelectedIteration(3, 0.3, 0.5)
    assert choose(losses, rates, SelectionRule(window=1, after=4)) is None


def test_the_first_of_equal_losses_is_selected():
    assert choose(np.ones(6), np.full(6, 0.5), RULE).iteration == 3


def test_an_empty_training_fails():
    assert choose(np.empty(0), np.empty(0), RULE) is None


def test_smoothing_uses_only_past_values():
    values = np.random.default_rng(0).random(20)
    expected = [np.nan if n < 4 else values[n - 4 : n + 1].mean() for n in range(20)]
    np.testing.assert_allclose(smoothed(values, 5), expected)


made_up = st.lists(
    st.tuples(st.sampled_from([0.0, 0.1, 0.5, 0.7, 2.0]), st.integers(0, 128)), min_size=1, max_size=60
)


@settings(deadline=None)
@given(made_up, st.integers(1, 8), st.integers(0, 59), st.integers(0, 9))
def test_a_resumed_selector_agrees_with_choose(made_up, window, pause, after):
    losses, rates = curves(*zip(*((loss, right / 128) for loss, right in made_up), strict=True))
    rule = SelectionRule(window=window, after=after)
    follower, kept = IterationSelector(rule), None
    for number, (loss, rate) in enumerate(zip(losses, rates, strict=True)):
        if number == pause:
            follower = IterationSelector(
                rule, follower.chosen, tuple(rates[max(0, number - window) : number]), number
            )
        if follower.update(loss, rate):
            kept = number + 1
    assert follower.chosen == choose(losses, rates, rule)
    assert kept == (follower.chosen and follower.chosen.iteration)


def test_invalid_rules_are_refused():
    with pytest.raises(ParameterError, match="low < high"):
        SelectionRule(0.6, 0.4)
    with pytest.raises(ParameterError, match="window must be at least 1"):
        SelectionRule(window=0)

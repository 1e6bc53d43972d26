"""Bars with standard errors: what they show, which pairs are marked, and levels for comparison."""

import pytest

from tactogram.statistics.figures import error_figure

ROWS = {"sensor": (1.3, 0.02), "A": (1.1, 0.05)}


def test_a_bar_is_a_mean_and_a_pair_is_marked():
    axes = error_figure(ROWS, marked=[("sensor", "A", "*")]).axes[0]
    assert [patch.get_height() for patch in axes.patches] == [1.3, 1.1]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["sensor", "A"]
    assert [text.get_text() for text in axes.texts] == ["*"]
    bracket = [line for line in axes.lines if list(line.get_xdata()) == [0, 0, 1, 1]]
    assert len(bracket) == 1
    assert min(bracket[0].get_ydata()) > 1.3 + 0.02


def test_a_level_for_comparison_is_drawn_with_its_value():
    axes = error_figure(ROWS, lines={"guess": 1.234}).axes[0]
    [line] = [line for line in axes.lines if line.get_label() == "guess (1.23)"]
    assert set(line.get_ydata()) == {1.234}


def test_a_longer_error_bar_needs_a_higher_axis():
    plain, wide = (error_figure({"a": (1.0, error)}).axes[0].get_ylim()[1] for error in (0.0, 0.5))
    assert wide == pytest.approx(1.5 * plain)

"""Words and figure of a series of mixes."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image as Pillow

from tactogram.errors import ParameterError
from tactogram.evaluation.mixing.ladder import MixSeries, mixing_figure
from tactogram.evaluation.mixing.placement import positions
from tactogram.evaluation.report import save_figure
from tactogram.signal import Signal


def noise(level_db, seed):
    samples = np.random.default_rng(seed).standard_normal((1, 1000))
    return Signal(10 ** (level_db / 20) * samples, 1000, "N")


def mixes(levels_db, **changes):
    steps = [[noise(level, 10 * k + i) for i in range(4)] for k, level in enumerate(levels_db)]
    start, end = ([noise(level, 900 + level + 30 * i) for i in range(4)] for level in (0, 20))
    ladder = positions(steps, start, end)
    made = MixSeries("cork", "tile", "sum", tuple(s[0] for s in steps), ladder, None, None, simulated=True)
    return replace(made, **changes)


@pytest.mark.parametrize(
    ("levels_db", "said"),
    [
        ((0, 7, 13, 20), "moves one way, from "),
        ((0, 15, 5, 20), "rises, but falls back by 0.5"),
        ((20, 10, 0, 0), "does not rise beyond what chance explains"),
        ((0, 12, 20), "half way at 0.4"),
        ((0, 2, 4, 6), "It never gets half way to tile."),
    ],
)
def test_words_say_what_the_measure_found(levels_db, said):
    assert said in mixes(levels_db).in_words()


def test_both_weights_are_named():
    made = mixes((0, 5, 10, 20, 20, 20))
    assert made.caption(2) == "0.4 tile, 0.6 cork"
    assert replace(made, mode="add").caption(2) == "0.4 tile, 1 cork"
    assert made.start_weights.tolist() == [1, 0.8, 0.6, 0.4, 0.2, 0]


def white(gain, seed, axes=3):
    return Signal(gain * np.random.default_rng(seed).standard_normal((axes, 1000)), 1000, "m/s^2")


def ladder(axes=3):
    weights = np.linspace(0, 1, 3)
    steps = [[white(1 + w, 10 * k + i, axes) for i in range(3)] for k, w in enumerate(weights)]
    ends = ([white(gain, 90 * gain + i, axes) for i in range(3)] for gain in (1, 2))
    return [step[0] for step in steps], positions(steps, *ends, weights=weights)


@pytest.mark.parametrize("axes", [1, 3])
def test_a_ladder_shows_its_weights_and_where_it_lies(axes, tmp_path):
    steps, measured = ladder(axes)
    figure = mixing_figure(steps, measured, start="cork", end="tile", start_weights=[1, 1, 1], title="t")
    upper, lower = figure.subfigs
    shown = [place for place in upper.axes if place.images]
    assert len(shown) == 3 * axes
    assert [place.get_title() for place in shown[:3]] == ["0", "0.5", "1"]
    assert [place.get_xlabel() for place in shown[-3:]] == ["1", "1", "1"]
    curves = lower.axes[0].get_lines()
    assert any(np.array_equal(c.get_ydata(), measured.position[:, -1]) for c in curves)
    with Pillow.open(save_figure(tmp_path / "ladder.png", figure)) as picture:
        assert picture.width > 1000


def test_an_axis_without_ends_is_left_out():
    steps, measured = ladder()
    nothing = np.full_like(measured.position, np.nan)
    nothing[:, -1] = measured.position[:, -1]
    object.__setattr__(measured, "position", nothing)
    lower = mixing_figure(steps, measured, start="cork", end="tile").subfigs[1]
    assert lower.axes[0].get_legend_handles_labels()[1] == ["all axes"]


def test_steps_of_another_ladder_are_refused():
    steps, measured = ladder()
    with pytest.raises(ParameterError, match="steps must be 3 as in the ladder, got 2"):
        mixing_figure(steps[:2], measured, start="a", end="b")

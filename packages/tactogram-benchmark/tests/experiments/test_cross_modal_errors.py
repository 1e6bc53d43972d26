"""Errors by condition, and which test says what of whom."""

import numpy as np
import pytest
from scipy import stats

from tactogram.datasets.ratings.ratings import Ratings, Scale
from tactogram.errors import ParameterError
from tactogram.statistics.comparison import steel_dwass
from tactogram_benchmark.experiments.cross_modal_errors import (
    compare_cross_modal,
    errors_of,
    overall_figure,
    per_word_figure,
    stars,
)

WORDS = ("rough", "sleek")
LATER = ("weight 1", "weight 1000", "weight 5000", "weight 10000")


def errors(mean, seed, people=20, plates=12):
    rng = np.random.default_rng(seed)
    return np.abs(
        mean + 0.3 * rng.standard_normal((people, 1, 1)) + rng.standard_normal((people, plates, 2)) * 0.5
    )


@pytest.fixture(scope="module")
def found():
    earlier = {"without models": errors(2.2, 0), "without images": errors(2.0, 1)}
    later = {
        name: errors(mean, 2 + n)
        for n, (name, mean) in enumerate(zip(LATER, (1.8, 1.7, 1.2, 2.0), strict=True))
    }
    shown = ("without models", "without images", "weight 5000")
    return compare_cross_modal(earlier, later, WORDS, shown=shown), earlier, later


def test_errors_are_against_the_plates_means():
    """Hatori et al. 2025, Sec. III-B: "the tactile evaluation scores of the metal plate samples"."""
    rows = [("ann", "a/p1", "rough", 3.0), ("ann", "a/p1", "sleek", 5.0), ("bob", "a/p2", "rough", 7.0),
            ("eve", "b/p1", "rough", 1.0)]  # fmt: skip
    columns = [list(column) for column in zip(*rows, strict=True)]
    table = Ratings(*columns[:3], np.array(columns[3]), words=WORDS)
    targets = {"p1": (2.0, 5.5), "p2": (6.5, 1.0), "p3": (1.0, 1.0)}
    got = errors_of(table, targets, ["a"])["a"]
    assert got.shape == (2, 2, 2)
    np.testing.assert_allclose(got[0, 0], [1.0, 0.5])
    np.testing.assert_allclose(got[1, 1], [0.5, np.nan])
    with pytest.raises(ParameterError, match="has no ratings; items must be called"):
        errors_of(table, targets, ["a", "c"])


def test_people_stay_in_their_rows_where_one_missed_a_condition_and_another_another():
    """As many in each condition, but not the same: they must not be paired with each other."""
    rng = np.random.default_rng(3)
    met = {"x": "abcdefgh", "y": "bcdefghi", "z": "abcdefghi"}
    rows = [
        (rater, f"{condition}/p1", word, 4.0 + "abcdefghi".index(rater) / 4 + rng.random() / 9)
        for condition, raters in met.items()
        for rater in raters
        for word in WORDS
    ]
    columns = [list(column) for column in zip(*rows, strict=True)]
    table = Ratings(*columns[:3], np.array(columns[3]), Scale("any", 0, 9), words=WORDS)
    got = errors_of(table, {"p1": (1.0, 1.0)}, ["x", "y", "z"])
    assert {len(errors) for errors in got.values()} == {9}
    assert np.isnan(got["x"][8]).all()
    assert np.isnan(got["y"][0]).all()
    result = compare_cross_modal({"e": errors(2, 0)}, got, WORDS, shown=("e", "x", "y"))
    assert (result.by_person.left_out, result.by_person.groups["x"].n) == (2, 7)
    both = [got[name][1:8].mean((1, 2)) for name in "xy"]
    assert result.by_person.pair("x", "y").difference == pytest.approx(both[0].mean() - both[1].mean())
    assert result.overall["x"].n == 8 * 2


def test_tests_as_printed_take_every_answer(found):
    """Hatori et al. 2025, Sec. III-B: "The Steel-Dwass test was performed as a non-parametric multiple comparison"."""
    result, earlier, later = found
    flat = {name: values.ravel() for name, values in {**earlier, **later}.items()}
    expected = steel_dwass(flat)
    assert result.as_printed.pair("weight 5000", "without images").p == pytest.approx(
        expected.pair("weight 5000", "without images").p
    )
    assert result.overall["weight 1"].n == 20 * 12 * 2
    assert "independent" in result.as_printed.caveat


def test_tests_by_person_take_one_value_each(found):
    result, earlier, later = found
    assert result.by_person.groups["weight 1"].n == 20
    assert result.by_person.overall[1] == pytest.approx(
        stats.friedmanchisquare(*[later[name].mean((1, 2)) for name in LATER]).pvalue
    )
    alone = stats.mannwhitneyu(
        later["weight 5000"].mean((1, 2)), earlier["without models"].mean((1, 2))
    ).pvalue
    assert alone <= result.against_earlier["weight 5000"]["without models"] <= 8 * alone


def test_a_word_improves_where_it_is_lower_and_the_test_says_so(found):
    """Hatori et al. 2025, Sec. III-B: "significantly reduced the error for eight out of ten evaluation terms"."""
    result, _, _ = found
    assert result.improved("weight 5000", "without models") == ["rough", "sleek"]
    assert result.improved("without models", "weight 5000") == []


def test_missing_answers_are_left_out():
    one, other = errors(2, 0), errors(1, 1)
    one[0, 0, 0] = np.nan
    result = compare_cross_modal({"x": one}, {"y": other, "z": errors(1, 2)}, WORDS, shown=("x", "y"))
    assert result.overall["x"].n == 20 * 12 * 2 - 1


def test_figures_say_who_was_asked(found):
    result, _, _ = found
    first = overall_figure(
        result, against="without images", published={"weight 5000": 1.6}, told_by="simulated observers"
    )
    assert "simulated observers" in first.axes[0].get_title()
    assert len(first.axes[0].patches) == 6
    second = per_word_figure(
        result, ("without models", "without images", "weight 5000"), told_by="simulated observers"
    )
    assert "simulated observers" in second.axes[0].get_title()
    assert len(second.axes[0].patches) == 6


def test_stars_are_those_of_the_captions():
    """Hatori et al. 2025, Sec. III-B, Fig. 6: "**: p < 0.01, *: p < 0.05"."""
    assert [stars(p) for p in (0.009, 0.01, 0.049, 0.05)] == ["**", "*", "*", ""]

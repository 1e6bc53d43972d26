"""Word scores of a request: given, filled from ratings, and refused."""

import numpy as np
import pytest
from made_up_runs import pictures, vibrations

from tactogram.errors import ParameterError
from tactogram.workflows.generation.word_scores import ask, rated_means


def test_missing_words_are_asked_for_by_name():
    with pytest.raises(
        ParameterError, match="scores are missing for sleek, sticky; give them in `words`, or"
    ):
        ask([pictures()], {"rough": 6})


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"rough": 8}, "rough must be 1 to 7, the raters' scale; got 8"),
        ({"rough": float("nan")}, "rough must be 1 to 7"),
        ({"sour": 2}, "words must be of rough, sleek, sticky, got 'sour'"),
    ],
)
def test_words_off_the_scale_or_unknown_are_refused(words, message):
    with pytest.raises(ParameterError, match=message):
        ask([pictures()], words, rest="mean")


def test_the_rest_is_the_mean_of_the_first_run_that_knows_items():
    """Of plate01 alone: 7, 1, 4 on the 7-point scale."""
    asked = ask([vibrations(), pictures()], {"rough": 2}, rest="mean")
    assert asked.scores == {"rough": 2.0, "sleek": 1.0, "sticky": 4.0}
    assert asked.filled_from == "mean over the 1 rated items of touch (simulated raters)"
    other = ask([pictures(), vibrations()], {"rough": 2}, rest="mean")
    assert other.scores == pytest.approx({"rough": 2.0, "sleek": 4.0, "sticky": 4.0})
    without = ask([pictures({}), vibrations()], rest="mean")
    assert without.scores["rough"] == 7.0


def test_like_takes_measured_means_and_words_go_before_them():
    asked = ask([vibrations(), pictures()], {"sleek": 3}, like="image1")
    assert asked.scores == pytest.approx({"rough": 1.0, "sleek": 3.0, "sticky": 7.0})
    assert dict(asked.given) == {"sleek": 3.0}
    with pytest.raises(ParameterError, match="like must be one of plate01, image1, image2; got 'plate99'"):
        ask([vibrations(), pictures()], like="plate99")


def test_one_scale_for_both_the_share_of_people_for_the_other():
    """4 of 7 stays 4 where raters had 7 points, and is one half where they said yes or no."""
    asked = ask([vibrations(), pictures()], {"rough": 4, "sleek": 1, "sticky": 7})
    assert asked.on_scale_of(vibrations()) == {"rough": 4.0, "sleek": 1.0, "sticky": 7.0}
    assert asked.on_scale_of(pictures()) == {"rough": 0.5, "sleek": 0.0, "sticky": 1.0}


def test_items_that_nobody_rated_in_a_word_are_no_means():
    assert rated_means(pictures({"image1": [np.nan, 0, 0]})) == {}


@pytest.mark.parametrize("name", ["ざらざらする", "Rough", "rough (Zarazara-suru)"])
def test_words_of_the_studies_go_by_any_of_their_spellings(name):
    assert ask([pictures()], {name: 6}, rest="mean").given == {"rough": 6.0}
    with pytest.raises(ParameterError, match="words name 'rough' twice"):
        ask([pictures()], {name: 6, "rough": 5} if name != "Rough" else {"rough": 5, name: 6}, rest="mean")

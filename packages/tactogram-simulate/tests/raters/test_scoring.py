"""Scores of simulated raters."""

import numpy as np
import pytest

from tactogram.datasets.ratings.ratings import EVOKED, SEVEN_POINT
from tactogram.datasets.ratings.words import WORDS
from tactogram.errors import ParameterError
from tactogram.statistics.reliability import intraclass_correlation
from tactogram_simulate.materials import PLATES
from tactogram_simulate.raters import (
    draw_people,
    score_images,
    score_plates,
    score_together,
    score_vibrations,
    sight_weight,
)
from tactogram_simulate.raters.rules import (
    sight_cues,
    sight_words,
)
from tactogram_simulate.studies import drives
from tactogram_simulate.tactile_images import tactile_image

SHOWN = {drive.name: drive.signal for drive in drives()}
FEW = {name: SHOWN[name] for name in ("signal05", "signal12", "signal15", "signal26", "signal28", "signal33")}


def test_people_differ_and_are_the_same_whoever_else_is_drawn():
    few, many = draw_people(3, seed=1), draw_people(8, seed=1)
    assert [p.name for p in few] == ["rater01", "rater02", "rater03"]
    np.testing.assert_array_equal(few[2].lean, many[2].lean)
    assert len({p.spread for p in many}) == 8
    assert draw_people(3, seed=2)[0].spread != few[0].spread
    assert draw_people(3, seed=1, prefix="participant")[0].spread != few[0].spread
    with pytest.raises(ParameterError, match="at least one simulated rater"):
        draw_people(0, seed=0)


def test_scores_are_whole_points_met_in_an_order_of_ones_own():
    ratings = score_vibrations(FEW, draw_people(6, seed=0), seed=0)
    assert ratings.scale == SEVEN_POINT
    assert ratings.words == WORDS
    assert set(ratings.score) <= set(range(1, 8))
    orders = {
        name: [
            (o, i) for r, i, o in zip(ratings.rater, ratings.item, ratings.order, strict=True) if r == name
        ]
        for name in ratings.raters
    }
    assert all({place for place, _ in met} == set(range(1, 7)) for met in orders.values())
    assert len({tuple(sorted(set(met))) for met in orders.values()}) > 1


def test_the_same_seed_gives_the_same_scores_and_further_people_change_none():
    people = draw_people(5, seed=0)
    ratings = score_vibrations(FEW, people, seed=3)
    assert score_vibrations(FEW, people, seed=3).sha256 == ratings.sha256
    assert score_vibrations(FEW, people, seed=4).sha256 != ratings.sha256
    more = score_vibrations(FEW, draw_people(9, seed=0), seed=3).select(raters=ratings.raters)
    assert more.sha256 == ratings.sha256


def test_a_few_scores_are_missing():
    ratings = score_vibrations(FEW, draw_people(60, seed=0), seed=0)
    assert 0.001 < 1 - len(ratings) / (6 * 60 * 10) < 0.01


def test_raters_agree_moderately_and_other_people_on_the_means():
    one, other = (
        score_vibrations(SHOWN, draw_people(32, seed=0, prefix=name), seed=0) for name in ("rater", "person")
    )
    rough = WORDS.index("rough")
    agreement = intraclass_correlation(one.cube[:, :, rough]).single
    assert 0.3 < agreement < 0.7
    assert np.corrcoef(one.means[:, rough], other.means[:, rough])[0, 1] > 0.9


def test_first_scores_are_held_back_from_the_ends():
    ratings = score_vibrations(FEW, draw_people(120, seed=0), seed=0)
    away, place = np.abs(ratings.score - 4), np.asarray(ratings.order)
    assert away[place == 1].mean() < 0.92 * away[place == 6].mean()


def test_vision_and_touch_weigh_alike_on_roughness_and_vision_more_on_shape():
    weight = dict(zip(WORDS, sight_weight(), strict=True))
    assert weight["rough"] == pytest.approx(0.5)
    assert weight["uneven"] == pytest.approx(0.7**-2 / (0.7**-2 + 1.2**-2))
    assert weight["sticky"] < 0.5 < weight["rugged"]


def test_both_at_once_lie_between_touch_and_sight():
    people = draw_people(60, seed=0, prefix="participant")
    signal, image = SHOWN["signal12"], tactile_image("bark", 0, seed=0)
    felt = score_vibrations({"a": signal}, people, seed=0).means[0]
    seen = 1 + 6 * score_images({"a": image}, people, seed=0).means[0]
    both = score_together({"a": (signal, image)}, people, seed=0).means[0]
    rough, sleek = WORDS.index("rough"), WORDS.index("sleek")
    assert felt[rough] + 0.5 < both[rough] < seen[rough] - 0.5
    assert seen[sleek] + 0.5 < both[sleek] < felt[sleek] - 0.5


def test_the_share_of_yes_follows_the_readiness():
    image = tactile_image("glazed", 0, seed=0)
    ratings = score_images({"a": image}, draw_people(300, seed=0), seed=0)
    assert ratings.scale == EVOKED
    readiness = 1 / (1 + np.exp(-sight_words(sight_cues(image))))
    # People's leanings draw shares towards one half, so it is not the logistic itself.
    assert np.corrcoef(ratings.means[0], readiness)[0, 1] > 0.98


def test_plates_are_scored_unseen_in_a_session_of_their_own():
    ratings = score_plates(PLATES[7:8], draw_people(8, seed=0), seed=0)
    assert ratings.items == ("plate08",)
    assert set(ratings.session) == {"plates"}
    assert ratings.means[0, WORDS.index("uneven")] > ratings.means[0, WORDS.index("sleek")] + 2


def test_nothing_to_score_is_refused():
    with pytest.raises(ParameterError, match="items to score"):
        score_images({}, draw_people(1, seed=0), seed=0)

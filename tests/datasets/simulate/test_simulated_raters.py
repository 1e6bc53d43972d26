from dataclasses import replace

import numpy as np
import pytest

from tactogram.datasets.ratings.ratings import EVOKED, SEVEN_POINT
from tactogram.datasets.ratings.words import WORDS
from tactogram.datasets.simulate.materials import PLATES
from tactogram.datasets.simulate.raters import (
    draw_people,
    score_images,
    score_plates,
    score_together,
    score_vibrations,
    sight_weight,
)
from tactogram.datasets.simulate.raters.rules import (
    SightCues,
    TouchCues,
    sight_cues,
    sight_words,
    touch_cues,
    touch_words,
)
from tactogram.datasets.simulate.studies import drives
from tactogram.datasets.simulate.tactile_images import FAMILIES, tactile_image
from tactogram.datasets.simulate.touch import display_touched, plate_touched
from tactogram.errors import ParameterError
from tactogram.signal import Image
from tactogram.statistics.reliability import intraclass_correlation

MIDDLING = TouchCues(15.0, 0.5, 0.5, 0.2, 0.2, 0.2, 0.2, 0.4, 0.1)
PLAIN = SightCues(0.3, 0.3, 0.3, 0.5, 0.2, 0.2, 0.2, 0.5, 0.3, 0.5)
SHOWN = {drive.name: drive.signal for drive in drives()}
FEW = {name: SHOWN[name] for name in ("signal05", "signal12", "signal15", "signal26", "signal28", "signal33")}


def said(rule, cues, word, **changes):
    return rule(replace(cues, **changes))[WORDS.index(word)]


@pytest.mark.parametrize(
    ("word", "cue", "low", "high"),
    [
        ("rough", "level_db", 0.0, 35.0),
        ("rough", "irregular", 0.1, 0.9),
        ("uneven", "coarse", 0.1, 0.9),
        ("rugged", "coarse", 0.1, 0.9),
        ("uneven", "flutter", 0.1, 0.9),
        ("prickle", "impulsive", 0.1, 0.9),
        ("prickle", "steep", 0.1, 0.9),
        ("sticky", "friction", 0.1, 0.9),
        ("sticky", "catching", 0.1, 0.9),
        ("rustle", "irregular", 0.1, 0.9),
        ("dry", "fine", 0.1, 0.9),
    ],
)
def test_touch_calls_up_a_word_the_more_there_is_of_its_cue(word, cue, low, high):
    assert said(touch_words, MIDDLING, word, **{cue: high}) > said(touch_words, MIDDLING, word, **{cue: low})


@pytest.mark.parametrize(
    ("word", "cue"), [("sleek", "level_db"), ("slippery", "friction"), ("dry", "coarse"), ("sleek", "coarse")]
)
def test_touch_takes_a_word_back_the_more_there_is_of_its_contrary(word, cue):
    low, high = (0.0, 35.0) if cue == "level_db" else (0.1, 0.9)
    assert said(touch_words, MIDDLING, word, **{cue: high}) < said(touch_words, MIDDLING, word, **{cue: low})


@pytest.mark.parametrize(
    ("word", "cue", "sign"),
    [
        ("rough", "fine", 1),
        ("uneven", "coarse", 1),
        ("rugged", "irregular", 1),
        ("slippery", "gloss", 1),
        ("dry", "gloss", -1),
        ("prickle", "thin", 1),
        ("sticky", "colour", 1),
        ("sleek", "middle", -1),
        ("squishy", "fine", -1),
        ("rustle", "middle", 1),
    ],
)
def test_sight_calls_up_a_word_by_its_cue(word, cue, sign):
    more, less = (said(sight_words, PLAIN, word, **{cue: x}) for x in (0.9, 0.1))
    assert sign * (more - less) > 0


def test_words_are_shares_whatever_the_cues():
    for extreme in (0.0, 1.0):
        words = touch_words(TouchCues(-100.0 + 200 * extreme, *[extreme] * 8))
        assert words.shape == (10,)
        assert words.min() >= 0
        assert words.max() <= 1


def test_a_display_signal_can_call_up_smoothness_but_not_relief():
    """What has no geometry reaches rugged and uneven less than a knurled plate does."""
    shown = np.array([touch_words(touch_cues(display_touched(signal))) for signal in SHOWN.values()])
    knurled = touch_words(touch_cues(plate_touched(PLATES[7])))
    for word in ("rugged", "uneven"):
        assert shown[:, WORDS.index(word)].max() < 0.75 * knurled[WORDS.index(word)]
    for word in ("sleek", "slippery", "rough", "dry"):
        assert shown[:, WORDS.index(word)].max() > 0.6


def test_level_says_the_same_wherever_a_loop_begins():
    sweep = SHOWN["signal37"]
    turned = sweep.with_samples(np.roll(sweep.samples, 2500, axis=1))
    first, second = (touch_cues(display_touched(x)).level_db for x in (sweep, turned))
    assert first == pytest.approx(second, abs=0.3)


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


def test_an_image_says_the_same_at_another_size():
    image = tactile_image("stones", 3, seed=0)
    pixels = image.pixels.reshape(64, 2, 64, 2, 3).mean((1, 3)).round().astype(np.uint8)
    one, half = (sight_words(sight_cues(x)) for x in (image, Image(pixels)))
    np.testing.assert_allclose(half, one, atol=0.15)


def test_a_flat_grey_is_sleek_and_noise_is_rough():
    rng = np.random.default_rng(0)
    flat = sight_words(sight_cues(Image(np.full((64, 64, 3), 150, np.uint8))))
    grain = np.clip(150 + 45 * rng.standard_normal((64, 64, 1)), 0, 255).repeat(3, 2).astype(np.uint8)
    noisy = sight_words(sight_cues(Image(grain)))
    rough, sleek = WORDS.index("rough"), WORDS.index("sleek")
    assert noisy[rough] > flat[rough] + 2
    assert flat[sleek] > noisy[sleek] + 2


@pytest.mark.parametrize(
    ("word", "family", "other"),
    [
        ("prickle", "spikes", "fabric"),
        ("slippery", "glazed", "bark"),
        ("rough", "bark", "polished"),
        ("uneven", "stones", "sand"),
        ("sticky", "wet", "sand"),
        ("rustle", "crumpled", "wood"),
        ("squishy", "gel", "stones"),
        ("dry", "sand", "wet"),
    ],
)
def test_pictures_call_up_what_they_are_of(word, family, other):
    def mean(name):
        return np.mean([sight_words(sight_cues(tactile_image(name, n, seed=0))) for n in range(6)], 0)

    assert mean(family)[WORDS.index(word)] > mean(other)[WORDS.index(word)] + 0.5


def test_pictures_are_the_same_for_the_same_seed():
    for family in FAMILIES:
        image = tactile_image(family, 1, seed=0)
        assert image.pixels.shape == (128, 128, 3)
        assert image.pixels.std() > 2
    np.testing.assert_array_equal(image.pixels, tactile_image(family, 1, seed=0).pixels)
    assert not np.array_equal(image.pixels, tactile_image(family, 2, seed=0).pixels)
    assert not np.array_equal(image.pixels, tactile_image(family, 1, seed=1).pixels)

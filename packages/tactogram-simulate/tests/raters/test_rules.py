"""Rules of simulated raters."""

from dataclasses import replace

import numpy as np
import pytest

from tactogram.datasets.ratings.words import WORDS
from tactogram.signal import Image
from tactogram_simulate.materials import PLATES
from tactogram_simulate.raters.rules import (
    SightCues,
    TouchCues,
    sight_cues,
    sight_words,
    touch_cues,
    touch_words,
)
from tactogram_simulate.studies import drives
from tactogram_simulate.tactile_images import tactile_image
from tactogram_simulate.touch import display_touched, plate_touched

MIDDLING = TouchCues(15.0, 0.5, 0.5, 0.2, 0.2, 0.2, 0.2, 0.4, 0.1)
PLAIN = SightCues(0.3, 0.3, 0.3, 0.5, 0.2, 0.2, 0.2, 0.5, 0.3, 0.5)
SHOWN = {drive.name: drive.signal for drive in drives()}


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

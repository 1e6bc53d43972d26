"""Images from words: labels, missing words, what was learned and is refused."""

from functools import cache

import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.model import ImageExample, ImageKind, ItemRatings
from tactogram.models.texture_flow import Config, build
from tactogram.signal import Image
from tactogram.training.loop import TrainingPosition, fit

WORDS = ("bright", "loud")
SMALL = Config(
    widths=(16, 16), embedding=16, size=16, batch_size=8, steps=150, warm_up=5, learning_rate=0.01, solver_steps=4,
    moving_average=0.9,
)  # fmt: skip


def example(number, bright, scores=None):
    """Simulated: a grey as bright as the first score, with noise; the second says nothing."""
    rng = np.random.default_rng(number)
    pixels = 40 + 160 * bright + rng.normal(0, 10, (20, 24, 3))
    rated = np.array([[bright, number % 5 / 4]] * 2) if scores is None else scores
    return ImageExample(
        f"k{number}", (Image(pixels.astype(np.uint8)),), f"i{number}", ItemRatings(WORDS, ("a", "b"), rated)
    )


EXAMPLES = [example(number, number % 4 / 3) for number in range(16)]
KIND = ImageKind(WORDS, (1.0, 7.0), tuple(sorted(e.item for e in EXAMPLES)), simulated=True)


@cache
def trained(**config):
    learner = build(SMALL.model_copy(update=config), KIND, seed=0)
    fit(learner, EXAMPLES, seed=0)
    return learner


def brightness(words, *, learner=None, draws=6):
    learner = learner or trained()
    return [learner.generate({"words": words}, seed=seed).pixels.mean() for seed in range(draws)]


def test_images_follow_their_words():
    """Scores of 1 and 7 are 40 and 200 of 255."""
    dark, light = brightness({"bright": 1.0, "loud": 4.0}), brightness({"bright": 7.0, "loud": 4.0})
    assert np.mean(dark) == pytest.approx(40, abs=25)
    assert np.mean(light) == pytest.approx(200, abs=25)
    assert trained().generate({"words": {"bright": 1.0}}, seed=0).pixels.shape == (16, 16, 3)


def test_one_step_is_enough_for_a_straightened_flow():
    config = SMALL.model_copy(update={"straightening_steps": 100, "guidance": 2.0})
    learner = build(config, KIND, seed=0)
    learner.load_state(trained().state())
    fit(learner, EXAMPLES, seed=0, start=TrainingPosition(1, SMALL.steps))
    assert np.mean(brightness({"bright": 1.0}, learner=learner)) == pytest.approx(40, abs=25)
    assert np.mean(brightness({"bright": 7.0}, learner=learner)) == pytest.approx(200, abs=25)


def test_any_word_may_be_missing():
    assert np.mean(brightness({"bright": 7.0})) == pytest.approx(200, abs=30)
    unsaid = brightness({"loud": 4.0}, draws=12)
    assert np.std(unsaid) > 2 * np.std(brightness({"bright": 7.0}, draws=12))
    none = [trained().generate({}, seed=seed).pixels for seed in range(2)]
    np.testing.assert_array_equal(none[0], trained().generate({"words": {}}, seed=0).pixels)
    assert not np.array_equal(*none)


def test_guidance_of_zero_ignores_the_words():
    free = trained(steps=5, guidance=0.0)
    one, other = (free.generate({"words": {"bright": score}}, seed=1).pixels for score in (1.0, 7.0))
    np.testing.assert_array_equal(one, other)


def test_a_label_is_in_deviations_of_the_training_scores_and_says_which_are_known():
    learner = trained()
    label = learner._label(torch.tensor([[0.0, torch.nan], [1.0, 0.5], [9.0, torch.nan]]))
    deviation = np.std([0, 1 / 3, 2 / 3, 1])
    assert label[0].tolist() == pytest.approx([-0.5 / deviation, 0, 1, 0])
    assert label[1, 0].item() == pytest.approx(0.5 / deviation)
    assert label[1, 2:].tolist() == [1, 1]
    assert label[2, 0] == 4


def test_words_are_hidden_from_half_of_the_images():
    learner = build(SMALL.model_copy(update={"incomplete": 0.5, "dropped": 0.2}), KIND, seed=0)
    torch.manual_seed(0)
    known = ~learner._with_some_missing(torch.full((4000, 10), 0.5)).isnan()
    count = known.sum(1)
    # Of the others, each share of words from 0 to 1 is equally probable: a tenth has all of 10, a tenth none.
    assert (count == 10).float().mean().item() == pytest.approx(0.8 * (0.5 + 0.5 / 11), abs=0.03)
    assert (count == 0).float().mean().item() == pytest.approx(0.2 + 0.8 * 0.5 / 11, abs=0.03)


def test_pixels_have_mean_zero_and_deviation_one():
    learner = trained()
    [(_, images, _)] = [next(learner.batches(learner.stages(EXAMPLES)[1], EXAMPLES, seed=0))]
    assert images.shape == (8, 3, 16, 16)
    whole = learner._whitened(
        np.stack([e.image.pixels[2:18, 4:20].transpose(2, 0, 1) / 127.5 - 1 for e in EXAMPLES])
    )
    assert whole.mean().item() == pytest.approx(0, abs=0.05)
    assert whole.std().item() == pytest.approx(1, abs=0.05)


def test_an_image_that_nobody_scored_in_a_word_is_learned_from():
    data = [*EXAMPLES[:3], example(3, 1.0, np.array([[1.0, np.nan]] * 2))]
    learner = build(SMALL.model_copy(update={"steps": 2}), KIND, seed=0)
    fit(learner, data, seed=0)
    assert np.isnan(learner.rated_means["i3"]).tolist() == [False, True]
    assert learner.generate({"words": {"loud": 2.0}}, seed=0).pixels.shape == (16, 16, 3)
    assert np.isfinite(learner.image_spread().by_noise)


def test_the_loss_of_unseen_images_is_measured():
    unseen = [example(number, number % 4 / 3) for number in range(50, 58)]
    loss, untrained = (learner.validate(unseen)["loss_unseen"] for learner in (trained(), trained(steps=1)))
    assert loss < 0.6 * untrained
    assert trained().validate([]) == {}


def test_a_size_that_the_network_cannot_halve_is_refused():
    with pytest.raises(ParameterError, match="config.size must be a multiple of 4"):
        build(SMALL.model_copy(update={"size": 18}), KIND, seed=0)

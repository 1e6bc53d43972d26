"""Labels, weights, noise, and what a collapsed generator is called."""

import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.model import ImageExample, ImageKind, ItemRatings
from tactogram.models.tactile_image_cgan.config import Config
from tactogram.models.tactile_image_cgan.learner import TactileImageLearner
from tactogram.nn.initial_weights import normal_
from tactogram.recipe import Recipe
from tactogram.signal import Image
from tactogram.training.labelled_images import LabelledImages, as_floats, as_pixels, square
from tactogram.training.loop import fit

WORDS = ("rough", "sleek")
TINY = Config(widths=(8, 4), noise=5, batch_size=4, updates=3)


def examples(count=6, side=20):
    rng = np.random.default_rng(0)
    return [
        ImageExample(
            f"p{n}",
            (Image(rng.integers(0, 256, (side, side + 4, 3), np.uint8)),),
            f"image{n}",
            ItemRatings(WORDS, ("ann", "bob", "eve", "kim"), rng.integers(0, 2, (4, 2)).astype(float)),
        )
        for n in range(count)
    ]


def learner(config=TINY, given=None):
    items = tuple(sorted(e.item for e in given or examples()))
    return TactileImageLearner(config, ImageKind(WORDS, (0.0, 1.0), items, simulated=True), seed=0)


def test_a_label_is_the_share_of_raters_for_whom_a_word_was_evoked():
    rated = ItemRatings(WORDS, ("a", "b", "c"), np.array([[1, 0], [1, np.nan], [0, 0]]))
    one = ImageExample("p", (Image(np.zeros((16, 16, 3), np.uint8)),), "image", rated)
    images = LabelledImages.of([one, one], WORDS, 16)
    np.testing.assert_allclose(images.labels[0], [2 / 3, 0])


def test_pixels_go_to_tanh_and_back():
    pixels = np.arange(256, dtype=np.uint8)
    assert (as_floats(pixels).min(), as_floats(pixels).max()) == (-1, 1)
    np.testing.assert_array_equal(as_pixels(as_floats(pixels)), pixels)


def test_the_middle_square_of_a_photograph_is_taken():
    pixels = np.zeros((64, 96, 3), np.uint8)
    pixels[:, 16:80] = 200
    assert (square(Image(pixels), 64) == 200).all()
    assert square(Image(pixels), 16).shape == (3, 16, 16)


def test_each_image_comes_as_often_as_any_other():
    given = examples()
    images = LabelledImages.of(given, WORDS, 16)
    labels = np.concatenate([images.batch(n, 4, seed=1)[1] for n in range(3)])
    assert len(labels) == 2 * len(given)
    pixels = np.concatenate([images.batch(n, 4, seed=1)[0] for n in range(3)])
    _, counts = np.unique(pixels.reshape(12, -1), axis=0, return_counts=True)
    assert (counts == 2).all()


def test_an_image_nobody_scored_in_a_word_is_refused_by_name():
    given = examples()
    given[2] = ImageExample(
        "p2", given[2].photographs, "image2", ItemRatings(WORDS, ("a",), np.array([[1, np.nan]]))
    )
    with pytest.raises(ParameterError, match="image2: nobody scored it in sleek"):
        learner().stages(given)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"rough": 0.5}, "a score is needed of sleek"),
        ({"rough": 0.5, "sleek": 6.0}, "sleek must be 0 to 1, got 6"),
        ({"rough": 0.5, "sleek": 0.1, "sour": 0.2}, "words must be of rough, sleek; got 'sour'"),
    ],
)
def test_words_that_make_no_sense_are_refused(words, message):
    with pytest.raises(ParameterError, match=message):
        learner().generate({"words": words}, seed=0)


def test_means_of_the_training_images_come_with_the_run():
    given, model, other = examples(), learner(), learner()
    fit(model, given, seed=0)
    other.load_state(model.state())
    for example in given:
        np.testing.assert_allclose(other.rated_means[example.item], example.rated.means, rtol=1e-6)


def test_collapse_is_named():
    model, given = learner(), examples()
    model.stages(given)
    torch.manual_seed(0)
    normal_(model.gan.bare_generator, 0.5)
    first = model.gan.bare_generator.layers[0].weight.data
    first[: TINY.noise] = 0.0
    assert model.image_spread().collapse == "one image per label, whatever the noise"
    first[:] = torch.randn_like(first)
    first[TINY.noise :] = 0.0
    assert model.image_spread().collapse == "the label makes no difference"
    first[:] = 0.0
    assert model.image_spread().collapse == "one image for all labels and noises"
    assert model.validate(given)["collapsed"] == 1.0


def test_an_example_without_a_label_leaves_the_spread_finite():
    given, model = examples(6), learner()
    model.stages(given)
    expected = model.validate(given[1:])
    given[0].rated.scores[:, 0] = np.nan
    assert model.validate(given) == expected


def test_the_four_weights_are_recipes():
    from tactogram import models

    facts = models.find("tactile_image_cgan")
    for weight in (1, 1000, 5000, 10000):
        assert facts.config(Recipe.load(facts.recipe(f"weight-{weight}")).config).image_weight == weight
    assert facts.config(Recipe.load(facts.recipe("paper")).config) == facts.config()
    assert facts.config(Recipe.load(facts.recipe("weight-5000")).config) == facts.config()

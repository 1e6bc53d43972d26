"""Labels, crops and batches of images."""

import numpy as np

from tactogram.model import ImageExample, ItemRatings
from tactogram.signal import Image
from tactogram.training.labelled_images import LabelledImages, as_floats, as_pixels, square

WORDS = ("rough", "sleek")


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


def test_a_label_is_the_share_of_raters_for_whom_a_word_was_evoked():
    """Hatori et al. 2025, Sec. II-B: whether sensations "were “evoked” or “not evoked” when viewing the images"."""
    rated = ItemRatings(WORDS, ("a", "b", "c"), np.array([[1, 0], [1, np.nan], [0, 0]]))
    one = ImageExample("p", (Image(np.zeros((16, 16, 3), np.uint8)),), "image", rated)
    images = LabelledImages.of([one, one], WORDS, 16)
    np.testing.assert_allclose(images.labels[0], [2 / 3, 0])


def test_pixels_go_to_tanh_and_back():
    """Hatori et al. 2025, Sec. II-C: "The output is then converted to the range [0, 255]"."""
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

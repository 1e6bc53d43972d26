"""Mean ratings of an item, and images that are decoded on access."""

import numpy as np

from tactogram.model import ImageExample, ItemRatings
from tactogram.signal import Image


def test_a_mean_is_over_those_who_gave_a_score():
    scores = np.array([[0.0, np.nan, 1.0], [1.0, np.nan, np.nan], [0.5, np.nan, 0.5]])
    means = ItemRatings(("rough", "warm", "soft"), ("a", "b", "c"), scores).means
    np.testing.assert_array_equal(means, [0.5, np.nan, 0.75])


def test_an_image_is_decoded_when_it_is_asked_for():
    class Decoded(list):
        times = 0

        def __getitem__(self, place):
            Decoded.times += 1
            return super().__getitem__(place)

    shown = Image(np.zeros((4, 4, 3), np.uint8))
    example = ImageExample("p", Decoded([shown]), "i", ItemRatings((), (), np.zeros((0, 0))))
    assert Decoded.times == 0
    assert example.image is shown
    assert Decoded.times == 1

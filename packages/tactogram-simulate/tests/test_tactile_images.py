"""Pictures that look tactile."""

import numpy as np

from tactogram_simulate.tactile_images import FAMILIES, tactile_image


def test_pictures_are_the_same_for_the_same_seed():
    for family in FAMILIES:
        image = tactile_image(family, 1, seed=0)
        assert image.pixels.shape == (128, 128, 3)
        assert image.pixels.std() > 2
    np.testing.assert_array_equal(image.pixels, tactile_image(family, 1, seed=0).pixels)
    assert not np.array_equal(image.pixels, tactile_image(family, 2, seed=0).pixels)
    assert not np.array_equal(image.pixels, tactile_image(family, 1, seed=1).pixels)

"""Features of images without a pretrained network."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.features.photo_descriptor import descriptor
from tactogram.models.rater.image_features import ImageFeatures
from tactogram.signal import Image


def image(seed, rows=48, columns=64):
    return Image(np.random.default_rng(seed).integers(0, 256, (rows, columns, 3), np.uint8))


def test_without_a_trunk_they_are_those_of_colour_and_texture():
    features, images = ImageFeatures("none", 224), [image(0), image(1, rows=40)]
    features.prepare()
    expected = [descriptor(photo) for photo in images]
    np.testing.assert_array_equal(features(images), expected)
    assert features.blocks == (len(expected[0]),)
    assert (features.used, features.state()) == ("none", {"used": "none", "weights": {}})


def test_a_run_that_used_no_trunk_has_none_whatever_is_asked_for():
    features = ImageFeatures("auto", 224)
    features.load_state(ImageFeatures("none", 224).state())
    np.testing.assert_array_equal(features([image(0)]), [descriptor(image(0))])


def test_a_small_image_is_refused_by_its_size():
    with pytest.raises(ParameterError, match="at least 8 x 8 pixels, got 64 x 7"):
        ImageFeatures("none", 224)([image(0), image(1, rows=7)])

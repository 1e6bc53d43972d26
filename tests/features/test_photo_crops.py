import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.features.photo_crops import PhotoCrops, to_network
from tactogram.signal import Image


def photo(seed=0, rows=320, columns=480):
    return Image(np.random.default_rng(seed).integers(0, 256, (rows, columns, 3), np.uint8))


def rng(seed=0):
    return np.random.default_rng(seed)


PLAIN = {"flips": False, "brightness": 0.0, "contrast": 0.0}


def test_defaults_are_the_papers():
    """Neshov et al. 2026, Sec. 4.1: "augmentation ten times", crops of "256 × 256", "converted to grayscale"."""
    crops = PhotoCrops()
    made = crops.random(photo(), rng())
    assert made.shape == (1, 256, 256)
    assert made.dtype == np.uint8
    assert (crops.crop, crops.per_photo, crops.repeats) == (256, 10, 10)


def test_the_place_is_drawn_first_and_covers_the_photograph():
    crops = PhotoCrops(crop=256, grayscale=False, **PLAIN)
    places = np.array([crops.place(320, 480, rng(seed)) for seed in range(2000)])
    assert places.min(0).tolist() == [0, 0]
    assert places.max(0).tolist() == [64, 224]
    top, left = crops.place(320, 480, rng(3))
    made = crops.random(photo(), rng(3))
    np.testing.assert_array_equal(made, photo().pixels[top : top + 256, left : left + 256].transpose(2, 0, 1))


def test_flips_are_left_right_and_up_down():
    """Neshov et al. 2026, Sec. 4.1: "random horizontal and vertical flipping"."""
    crops = PhotoCrops(crop=32, size=32, grayscale=False, brightness=0.0, contrast=0.0)
    image = photo(rows=32, columns=32)
    whole = image.pixels.transpose(2, 0, 1)
    flips = {
        "none": whole,
        "left-right": whole[:, :, ::-1],
        "top-bottom": whole[:, ::-1],
        "both": whole[:, ::-1, ::-1],
    }
    seen = {
        name
        for seed in range(40)
        for name, expected in flips.items()
        if np.array_equal(crops.random(image, rng(seed)), expected)
    }
    assert seen == set(flips)


def test_grey_is_what_pillow_makes():
    from PIL import Image as Pillow

    made = PhotoCrops(crop=64, size=64, **PLAIN).random(photo(rows=64, columns=64), rng())
    expected = np.asarray(Pillow.fromarray(photo(rows=64, columns=64).pixels).convert("L"))
    assert np.abs(made[0].astype(int) - expected).max() <= 1


def test_brightness_and_contrast_are_those_of_torchvision():
    pytest.importorskip("captum", reason="the extra vision is not installed")
    from tactogram.nn.vision_import import vision_module

    functional = vision_module("torchvision.transforms.functional")
    crops = PhotoCrops(crop=64, size=64, grayscale=False, flips=False)
    image = photo(rows=64, columns=64)
    random = rng(9)
    crops.place(64, 64, random)
    random.random(2)
    brightness, contrast = 1 + random.uniform(-1, 1, 2) * 0.2
    pixels = torch.from_numpy(image.pixels.transpose(2, 0, 1).astype(np.float32) / 255)
    expected = functional.adjust_contrast(functional.adjust_brightness(pixels, brightness), contrast)
    assert (torch.from_numpy(crops.random(image, rng(9)) / 255) - expected).abs().max() <= 1 / 255


def test_a_smaller_size_is_the_mean_of_pixels():
    made = PhotoCrops(crop=64, size=16, grayscale=False, **PLAIN).random(photo(rows=64, columns=64), rng())
    expected = photo(rows=64, columns=64).pixels.astype(float).reshape(16, 4, 16, 4, 3).mean((1, 3))
    assert np.abs(made.transpose(1, 2, 0) - expected).max() <= 0.5 + 1e-4


def test_black_is_minus_one_and_white_is_one():
    """Neshov et al. 2026, Sec. 4.1: "All data are normalized to the range" of -1 to 1."""
    assert to_network(np.array([0, 255], np.uint8)).tolist() == [-1.0, 1.0]


def test_bad_input_is_one_line():
    with pytest.raises(ParameterError, match=r"200 x 300 pixels is smaller than the crop of 256"):
        PhotoCrops().random(photo(rows=200, columns=300), rng())
    with pytest.raises(ParameterError, match=r"size must be <= crop"):
        PhotoCrops(crop=64, size=128)
    with pytest.raises(ParameterError, match=r"crop must be a whole number >= 1"):
        PhotoCrops(crop=0)
    with pytest.raises(ParameterError, match=r"contrast must be in 0..1"):
        PhotoCrops(contrast=2.0)

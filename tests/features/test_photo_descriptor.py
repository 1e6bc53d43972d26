"""Descriptors of photographs, and their novelty, on simulated ones."""

import json

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from tactogram.features.photo_descriptor import UNLIKE, PhotoNovelty, descriptor
from tactogram.signal import Image


def photograph(rng, colour, grain, contrast):
    noise = gaussian_filter(rng.standard_normal((64, 64)), grain)
    pixels = colour * (1 + contrast * noise / noise.std())[..., None]
    return Image(np.clip(pixels, 0, 255).astype(np.uint8))


@pytest.fixture(scope="module")
def looks():
    """Six photographs of each of twelve surfaces, of random colour, grain and contrast."""
    rng = np.random.default_rng(1)
    found = {}
    for number in range(12):
        look = rng.uniform(60, 200, 3), np.exp(rng.uniform(-1, 1.5)), rng.uniform(0.05, 0.3)
        found[f"surface-{number}"] = [photograph(rng, *look) for _ in range(6)]
    return found


def unlike(known, images):
    return [known.nearest(image).novelty >= UNLIKE for image in images]


def test_an_unseen_photograph_of_a_known_surface_is_known(looks):
    known = PhotoNovelty.of({name: images[:4] for name, images in looks.items()})
    unseen = [image for images in looks.values() for image in images[4:]]
    assert np.mean(unlike(known, unseen)) <= 0.05
    assert (
        np.mean([known.nearest(image).material == name for name in looks for image in looks[name][4:]]) > 0.9
    )


def test_most_surfaces_that_were_left_out_are_unlike(looks):
    found = []
    for left_out in looks:
        known = PhotoNovelty.of({name: images for name, images in looks.items() if name != left_out})
        found += unlike(known, looks[left_out])
    assert 0.6 <= np.mean(found) <= 0.9  # three quarters by construction


def test_pictures_of_no_surface_are_unlike(looks):
    rng = np.random.default_rng(0)
    y, x = np.mgrid[:200, :200]
    pictures = [
        rng.integers(0, 256, (200, 200, 3)),
        np.repeat(255 * ((x // 40 + y // 40) % 2)[..., None], 3, axis=2),
        np.stack([x, y, 255 - x], axis=-1),
    ]
    assert all(unlike(PhotoNovelty.of(looks), [Image(each.astype(np.uint8)) for each in pictures]))


def test_novelty_is_the_share_of_nearer_materials():
    grey = {
        name: [Image(np.full((16, 16, 3), level, np.uint8))]
        for name, level in zip("abc", (0, 100, 150), strict=True)
    }
    known = PhotoNovelty.of(grey)
    assert known.nearest(grey["b"][0]) == ("b", 0.0)
    assert known.nearest(Image(np.full((16, 16, 3), 255, np.uint8))).material == "c"
    assert PhotoNovelty.of({"a": grey["a"], "b": grey["b"]}) is None


def test_facts_are_read_back(looks):
    known = PhotoNovelty.of(looks)
    again = PhotoNovelty.from_facts(json.loads(json.dumps(known.facts())))
    image = looks[next(iter(looks))][0]
    assert again.nearest(image)[0] == known.nearest(image)[0]


def test_a_turned_photograph_is_nearly_the_same():
    stripes = np.zeros((128, 128, 3), np.uint8)
    stripes[::4] = 200
    upright, turned = (
        descriptor(Image(stripes)),
        descriptor(Image(np.ascontiguousarray(stripes.swapaxes(0, 1)))),
    )
    np.testing.assert_allclose(upright, turned, atol=1e-6)


def test_grain_is_seen_in_its_octave():
    rows = np.arange(128)
    for period, band in ((4, 0), (8, 1), (16, 2)):
        pixels = np.uint8(128 + 60 * np.sin(2 * np.pi * (rows + 0.3) / (1.2 * period)))
        levels = descriptor(Image(np.broadcast_to(pixels[:, None, None], (128, 128, 3))))[3:].reshape(6, 4)
        assert np.argmax(levels.max(axis=1)) == band + 1

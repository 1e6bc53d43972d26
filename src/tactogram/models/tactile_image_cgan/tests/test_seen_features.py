"""Colour, highlights and contrast of plain, striped and spotted images."""

import math

import pytest
import torch

from tactogram.models.tactile_image_cgan.seen_features import DARK, FLOOR, seen_features


def test_a_plain_image_has_its_colour_and_no_contrast():
    image = torch.tensor([1.0, 0.0, -0.5])[None, :, None, None].expand(1, 3, 64, 64)
    [features] = seen_features(image)
    assert features[:5].tolist() == pytest.approx([100, 50, 25, 75, 0], abs=1e-3)
    assert features[5:].tolist() == pytest.approx([10 * math.log10(FLOOR)] * 5, abs=1e-3)


@pytest.mark.parametrize(("cycles", "band"), [(24, 0), (12, 1), (6, 2)])
def test_stripes_are_in_the_band_of_their_size(cycles, band):
    stripes = 0.4 * torch.sin(2 * torch.pi * cycles * torch.arange(64) / 64).expand(1, 3, 64, 64)
    [features] = seen_features(stripes)
    power = (0.2 / (0.5 + DARK)) ** 2 / 2
    assert features[5:].argmax() == band
    assert features[5 + band].item() == pytest.approx(10 * math.log10(power + FLOOR), abs=0.3)
    turned = seen_features(stripes.transpose(2, 3))[0]
    torch.testing.assert_close(turned, features, atol=1e-3, rtol=1e-4)


def test_spots_of_light_are_skewed():
    spots = torch.full((1, 3, 64, 64), -0.5)
    spots[..., ::8, ::8] = 1.0
    light = spots[0, 0].flatten()
    skewness = ((light - light.mean()) / light.std()).pow(3).mean().item()
    assert seen_features(spots)[0, 4].item() == pytest.approx(10 * skewness, rel=0.02)
    assert seen_features(-spots)[0, 4].item() < 0

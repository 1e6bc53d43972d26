import math

import pytest
import torch

from tactogram.models.texture_gan.config import Config
from tactogram.models.texture_gan.networks import Generator, Periodic, split_bands


def test_bands_sum_to_the_noise_and_lie_in_octaves():
    noise = torch.randn(4, 2, 4096, generator=torch.Generator().manual_seed(0))
    bands = split_bands(noise, 4)
    torch.testing.assert_close(bands.sum(3), noise, atol=1e-5, rtol=1e-4)
    power = torch.fft.rfft(bands, dim=2).abs().square().mean((0, 1))  # F, band
    centre = (power * torch.arange(len(power))[:, None]).sum(0) / power.sum(0) / len(power)
    assert centre.tolist() == pytest.approx([1 / 16, 3 / 16, 3 / 8, 3 / 4], rel=0.15)


def test_generator_of_noise_begins_as_plain_noise():
    config = Config(channels=(16, 8, 4), noise_bands=3, sinusoids=0)
    network = Generator(config, axes=2, labels=1)
    noise = torch.randn(8, 2, config.length, generator=torch.Generator().manual_seed(0))
    with torch.no_grad():
        output = network(torch.rand(8, 100), torch.ones(8, 1), split_bands(noise, 3))
    assert output.std().item() == pytest.approx(1, abs=0.2)
    assert torch.corrcoef(torch.stack((output.flatten(), noise.flatten())))[0, 1] > 0.95


def test_sinusoids_have_their_frequencies_and_labels_mix_in_them():
    config = Config(channels=(16, 8, 4), noise_bands=2, sinusoids=6)
    periodic = Periodic(config, axes=2, labels=3)
    latent = torch.rand(1, 12, generator=torch.Generator().manual_seed(0)) * 2 - 1
    with torch.no_grad():
        periodic.wave.zero_()
        periodic.wave[1, 4, 0] = 1.0  # sine 4 in the first axis of label 1
    label = torch.eye(3)
    hidden, wave = periodic(latent, label[1:2])
    assert hidden.shape == (1, 4, config.length // 4)
    assert wave.shape == (1, 2, config.length)
    assert not wave[0, 1].any()
    spectrum = torch.fft.rfft(wave[0, 0] * torch.hann_window(config.length)).abs()
    step = math.log(0.2 * config.length / 8) / 6
    expected = 8 / config.length * math.exp(step * (4.5 + latent[0, 4].item() / 2))
    assert spectrum.argmax().item() / config.length == pytest.approx(expected, abs=1 / config.length)
    both = periodic(latent, 0.5 * label[:1] + 0.5 * label[1:2])
    for mixed, one, other in zip(
        both, periodic(latent, label[:1]), periodic(latent, label[1:2]), strict=True
    ):
        torch.testing.assert_close(mixed, (one + other) / 2)

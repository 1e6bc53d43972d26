"""Random numbers per signal, and weights of which one must train the generator."""

import pytest

from tactogram.models.texture_gan.config import Config


def test_each_sinusoid_takes_two_random_numbers():
    assert Config(latent=6, sinusoids=5).latents == 16


def test_a_loss_trains_the_generator():
    assert Config(adversarial=0).statistics > 0
    with pytest.raises(ValueError, match="adversarial and statistics must not both be 0"):
        Config(adversarial=0, statistics=0)

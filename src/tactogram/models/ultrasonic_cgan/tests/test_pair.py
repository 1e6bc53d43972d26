"""Losses by hand, the optimisers of Table 4, and an iteration beside its plainest form."""

import math

import pytest
import torch
from torch import nn

from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.models.ultrasonic_cgan.pair import ClusterNetworks

SMALL = Config(
    bins=6, generator_widths=(5,), dropout_after=(), discriminator_widths=(4,), batch_size=8, smooth=1
)


def pair():
    return ClusterNetworks(SMALL, words=2, seed=0, device=torch.device("cpu"))


def batch(seed):
    return torch.rand(1, 8, 8, generator=torch.Generator().manual_seed(seed))


def test_optimisers_are_those_of_table_4():
    config = Config()
    assert (config.learning_rate, config.betas, config.epsilon) == (0.001, (0.9, 0.999), 1e-8)
    assert (config.batch_size, config.iterations) == (64, 200_000)
    for optimiser in pair().optimisers:
        group = optimiser.param_groups[0]
        assert (group["lr"], group["betas"], group["eps"]) == (0.001, (0.9, 0.999), 1e-8)


def test_first_losses_are_the_cross_entropy_by_hand():
    """E = -t log y - (1 - t) log(1 - y): the discriminator's before its update, the generator's after it."""
    one, other = pair(), pair()
    sensor, display = batch(1), batch(2)
    with torch.no_grad():
        fake = torch.cat((other.generator(sensor[0]), sensor[0, :, 6:]), 1)
        y = other.discriminator.probability(torch.cat((display[0], fake)))[:, 0].tolist()
    figures = one.iterate(sensor, display)
    by_hand = -(sum(map(math.log, y[:8])) + sum(math.log(1 - p) for p in y[8:])) / 16
    assert figures["discriminator_loss"] == pytest.approx(by_hand, rel=1e-5)
    assert figures["correct_rate"] == (sum(p > 0.5 for p in y[:8]) + sum(p <= 0.5 for p in y[8:])) / 16
    with torch.no_grad():
        updated = one.discriminator.probability(fake)[:, 0].tolist()
    assert figures["generator_loss"] == pytest.approx(-sum(map(math.log, updated)) / 8, rel=1e-5)


def test_an_iteration_is_adam_on_both_networks_in_turn():
    """Beside the plainest form: two forward passes, two optimisers without a trick."""
    ours, plain = pair(), pair()
    for each in (
        ours,
        plain,
    ):  # Adam divides by a gradient's size: rounding alone moves a weight whose gradient is none
        each.generator.double(), each.discriminator.double()
    optimisers = [torch.optim.Adam(n.parameters(), lr=1e-3) for n in (plain.generator, plain.discriminator)]
    ones, zeros = torch.ones(8, 1).double(), torch.zeros(8, 1).double()
    for seed in range(5):
        sensor, display = batch(seed).double(), batch(seed + 100).double()
        ours.iterate(sensor, display)
        label = sensor[0, :, 6:]
        fake = torch.cat((plain.generator(sensor[0]), label), 1)
        told, known = (plain.discriminator.probability(x) for x in (fake.detach(), display[0]))
        loss = (
            nn.functional.binary_cross_entropy(told, zeros) + nn.functional.binary_cross_entropy(known, ones)
        ) / 2
        optimisers[1].zero_grad()
        loss.backward()
        optimisers[1].step()
        optimisers[0].zero_grad()
        nn.functional.binary_cross_entropy(plain.discriminator.probability(fake), ones).backward()
        optimisers[0].step()
    for mine, theirs in zip(
        (*ours.generator.parameters(), *ours.discriminator.parameters()),
        (*plain.generator.parameters(), *plain.discriminator.parameters()),
        strict=True,
    ):
        torch.testing.assert_close(mine, theirs, atol=1e-5, rtol=1e-4)

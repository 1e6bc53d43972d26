import math

import pytest
import torch
from torch import nn

from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.models.ultrasonic_cgan.networks import Discriminator, Generator, discriminator_of
from tactogram.models.ultrasonic_cgan.pair import ClusterNetworks

TABLE_2 = [
    ("Linear", 1024), ("LeakyReLU", 1024), ("BatchNorm1d", 1024),
    ("Linear", 512), ("LeakyReLU", 512), ("BatchNorm1d", 512), ("Dropout", 512),
    ("Linear", 256), ("LeakyReLU", 256), ("BatchNorm1d", 256),
    ("Linear", 128), ("LeakyReLU", 128), ("BatchNorm1d", 128), ("Dropout", 128),
    ("Linear", 1000), ("LeakyReLU", 1000),
]  # fmt: skip
TABLE_3 = [("Linear", 64), ("LeakyReLU", 64), ("Linear", 32), ("LeakyReLU", 32), ("Linear", 1)]


def layers_of(network, x):
    """Kind and output width of each layer, in order."""
    seen = []
    for layer in network.layers:
        layer.register_forward_hook(lambda m, _, y: seen.append((type(m).__name__, y.shape[1])))
    with torch.no_grad():
        network(x)
    return seen


def counts(network):
    return [n for layer in network.layers if (n := sum(p.numel() for p in layer.parameters()))]


def test_generator_is_table_2():
    network = Generator(Config(), words=10)
    assert layers_of(network, torch.rand(2, 1010)) == TABLE_2
    assert [layer.p for layer in network.layers if isinstance(layer, nn.Dropout)] == [0.5, 0.5]


def test_generator_has_the_weights_of_table_2():
    assert counts(Generator(Config(), words=10)) == [
        (1000 + 10) * 1024 + 1024, 2 * 1024,
        1024 * 512 + 512, 2 * 512,
        512 * 256 + 256, 2 * 256,
        256 * 128 + 128, 2 * 128,
        128 * 1000 + 1000,
    ]  # fmt: skip
    assert sum(counts(Generator(Config(), words=10))) == 1_857_128


def test_discriminator_is_table_3():
    network = Discriminator(Config(), words=10)
    assert layers_of(network, torch.rand(2, 1010)) == TABLE_3
    assert counts(network) == [(1000 + 10) * 64 + 64, 64 * 32 + 32, 32 + 1]
    assert sum(counts(network)) == 66_817


def test_projection_sees_words_only_in_an_inner_product_with_the_last_hidden_layer():
    network = discriminator_of(Config(discriminator="projection"), words=10)
    assert counts(network) == [1000 * 64 + 64, 64 * 32 + 32, 32 + 1]
    x = torch.randn(5, 1010)
    spectrum, words = x[:, :1000], x[:, 1000:]
    hidden = network.layers[:-1](spectrum)
    by_hand = network.layers[-1](hidden)[:, 0] + torch.einsum(
        "bh,hw,bw->b", hidden, network.projection.embedding.weight, words
    )
    torch.testing.assert_close(network(x)[:, 0], by_hand)
    torch.testing.assert_close(network(torch.cat((spectrum, 0 * words), 1)), network.layers(spectrum))


def test_last_layer_of_the_discriminator_is_a_sigmoid():
    network, x = Discriminator(Config(), words=10), torch.randn(5, 1010)
    torch.testing.assert_close(network.probability(x), 1 / (1 + torch.exp(-network(x))))


def test_negative_slope_is_that_of_equation_1():
    for network in (Generator(Config(), words=10), Discriminator(Config(), words=10)):
        slopes = {layer.negative_slope for layer in network.layers if isinstance(layer, nn.LeakyReLU)}
        assert slopes == {0.01}


def test_output_can_go_below_zero():
    with torch.no_grad():
        made = Generator(Config(), words=10).eval()(torch.rand(8, 1010))
    assert made.min() < 0 < made.max()


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

import torch
from torch import nn

from tactogram.models.ultrasonic_cgan.config import Config
from tactogram.models.ultrasonic_cgan.networks import Discriminator, Generator

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


def test_last_layer_of_the_discriminator_is_a_sigmoid():
    network, x = Discriminator(Config(), words=10), torch.randn(5, 1010)
    torch.testing.assert_close(network.probability(x), 1 / (1 + torch.exp(-network(x))))


def test_negative_slope_is_that_of_equation_1():
    for network in (Generator(Config(), words=10), Discriminator(Config(), words=10)):
        slopes = {layer.negative_slope for layer in network.layers if isinstance(layer, nn.LeakyReLU)}
        assert slopes == {0.01}


def test_output_can_go_below_zero():
    with torch.no_grad():
        output = Generator(Config(), words=10).eval()(torch.rand(8, 1010))
    assert output.min() < 0 < output.max()

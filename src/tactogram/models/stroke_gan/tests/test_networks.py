import torch

from tactogram.models.stroke_gan.config import Config
from tactogram.models.stroke_gan.learner import Generator

NARROW = Config(channels=(16, 8, 4, 2, 1))  # the published layout, a 64th of its channels
AXES, CLASSES = 3, 9


def as_in_table_iii(y):
    """The shape as (batch, axis, time, channel); a dense layer's as it is."""
    return tuple(y.shape if y.dim() == 2 else y.reshape(-1, AXES, *y.shape[-2:]).mT.shape)


def shapes_of(network, *inputs):
    """The output shape of each convolution and dense layer, in order."""
    seen = []
    for name, module in network.named_modules():
        if name and not isinstance(module, torch.nn.ModuleList):
            module.register_forward_hook(lambda m, x, y: seen.append(as_in_table_iii(y)))
    with torch.no_grad():
        out = network(*inputs)
    return seen, tuple(out.shape)


def one_hot(place=0, count=1):
    return torch.eye(CLASSES)[place].expand(count, -1)


def test_generator_has_the_shapes_of_table_iii():
    network = Generator(NARROW, axes=AXES, labels=CLASSES)
    seen, out = shapes_of(network, torch.zeros(2, 100), one_hot(count=2))
    assert seen == [
        (2, 49152 // 64),
        (2, 3, 64, 512 // 64), (2, 3, 256, 256 // 64), (2, 3, 1024, 128 // 64), (2, 3, 4096, 64 // 64),
        (2, 3, 16384, 1),
    ]  # fmt: skip
    assert out == (2, 3, 16384)


def test_discriminator_has_the_shapes_of_table_iii_with_its_typing_error_mended():
    """Table III says (n, 64, 4096, 64) and so on where the axes must stand: (n, 3, 4096, 64)."""
    network = NARROW.discriminator(axes=AXES, labels=CLASSES)
    seen, out = shapes_of(network, torch.zeros(2, 3, 16384), one_hot(count=2))
    shuffled = [
        (2, 3, 4096, 64 // 64),
        (2, 3, 1024, 128 // 64),
        (2, 3, 256, 256 // 64),
        (2, 3, 64, 512 // 64),
    ]
    convolved = [*shuffled[1:], (2, 3, 16, 1024 // 64)]
    assert seen == [s for pair in zip(shuffled, convolved, strict=True) for s in pair] + [(2, 1)]
    assert out == (2, 1)


def test_published_networks_have_the_weights_of_table_iii():
    config = Config()
    assert config.length == 16384
    with torch.device("meta"):
        generator = Generator(config, axes=AXES, labels=CLASSES)
        critic = config.discriminator(axes=AXES, labels=CLASSES)
    kernels = [(512, 1024), (256, 512), (128, 256), (64, 128)]
    shared = sum(25 * a * b for a, b in kernels)
    by_hand = (100 + 9) * 49152 + 49152 + shared + 25 * 1 * 64 + (512 + 256 + 128 + 64 + 1)
    assert sum(p.numel() for p in generator.parameters()) == by_hand == 22_817_281
    by_hand = 25 * (1 + 9) * 64 + shared + (64 + 128 + 256 + 512 + 1024) + 49152 + 1
    assert sum(p.numel() for p in critic.parameters()) == by_hand == 17_475_137
    assert tuple(generator.layers[0].weight.shape) == (1024, 512, 25)
    assert tuple(critic.first.weight.shape) == (64, 1 + 9, 25)


def test_activations_and_their_places():
    """Leaky before each transposed convolution, tanh at the end; negative slopes of 0.2."""
    network = Generator(NARROW, axes=1, labels=1)
    seen = []
    network.layers[0].register_forward_pre_hook(lambda m, x: seen.append(x[0]))
    network.dense.register_forward_hook(lambda m, x, y: seen.append(y))
    out = network(torch.rand(1, 100), torch.ones(1, 1))
    before, after = seen[0].view(1, 16, 16).mT, seen[1]
    torch.testing.assert_close(after, torch.where(before > 0, before, 0.2 * before))
    assert out.abs().max() < 1


def test_axes_share_their_filters_and_are_not_convolved_together():
    network = Generator(NARROW, axes=3, labels=1)
    latent, label = torch.rand(2, 100), torch.ones(2, 1)
    whole = network(latent, label)
    with torch.no_grad():
        network.dense.weight.view(3, 16 * 16, -1)[0] = 0  # the first axis begins with nothing
    without = network(latent, label)
    torch.testing.assert_close(without[:, 1:], whole[:, 1:])
    assert not torch.allclose(without[:, 0], whole[:, 0])
    with torch.no_grad():
        network.dense.weight.view(3, 16 * 16, -1)[:] = network.dense.weight.view(3, 16 * 16, -1)[1].clone()
    same = network(latent, label)
    torch.testing.assert_close(same[:, 0], same[:, 2])


def test_label_channels_are_constant_channels_beside_the_signal():
    network = NARROW.discriminator(axes=2, labels=CLASSES)
    with torch.no_grad():
        network.first.bias.uniform_(-1, 1)
    x, label = torch.randn(3, 2, 16384), torch.rand(3, CLASSES)
    channels = label.repeat_interleave(2, 0)[:, :, None].expand(-1, -1, 16384)
    plain = network.first(torch.cat((x.view(6, 1, -1), channels), 1))  # B A, 1 + C, T
    torch.testing.assert_close(network._first(x, label), plain, atol=1e-4, rtol=1e-4)


def test_half_a_label_is_half_its_part_of_the_first_layer():
    """What mixing rests on: the label enters linearly."""
    network = Generator(NARROW, axes=1, labels=CLASSES)
    latent, zero = torch.rand(1, 100), torch.zeros(1, CLASSES)

    def first(label):
        return network.dense(torch.cat((latent, label), 1)) - network.dense(torch.cat((latent, zero), 1))

    both = 0.3 * first(one_hot(0)) + 0.7 * first(one_hot(4))
    torch.testing.assert_close(first(0.3 * one_hot(0) + 0.7 * one_hot(4)), both, atol=1e-5, rtol=1e-4)

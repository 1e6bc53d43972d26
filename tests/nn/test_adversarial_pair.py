"""Schedule, updates and choice of weights of a generator and its discriminator, by hand."""

from types import SimpleNamespace

import pytest
import torch
from torch import nn

from tactogram.nn.adversarial_networks import AdversarialPair


def pair(**changes):
    networks = (nn.Linear(1, 1, bias=False), nn.Linear(1, 1, bias=False))
    return AdversarialPair(
        *networks, learning_rate=0.1, betas=(0.3, 0.4), device=torch.device("cpu"), **changes
    )


class Pairs:
    """Forty pairs of photographs and pictures of one pixel: the picture of photograph x is 2 x."""

    def __len__(self):
        return 40

    def batch(self, places):
        photo = torch.as_tensor(places).view(-1, 1).float()
        return SimpleNamespace(photo=photo, picture=2 * photo)


def largest(made, real):
    return (made - real).abs().max()


@pytest.mark.parametrize(
    ("constant", "expected"),
    [
        (0.5, {0.0: 0.1, 0.5: 0.1, 0.75: 0.05, 0.9: 0.02}),
        (0.0, {0.0: 0.1, 0.25: 0.075, 0.9: 0.01}),
        (1.0, {0.0: 0.1, 0.9: 0.1}),
    ],
)
def test_the_learning_rate_stays_then_falls_linearly(constant, expected):
    gan = pair(constant=constant)
    gan.generator.eval()
    for done, rate in expected.items():
        gan.train(done)
        assert [o.param_groups[0]["lr"] for o in gan.optimisers] == pytest.approx([rate, rate])
    assert gan.generator.training


def test_each_network_descends_by_adam_along_its_own_loss():
    gan = pair()
    plain = [nn.Parameter(network.weight.detach().clone()) for network in (gan.generator, gan.discriminator)]
    adams = [torch.optim.Adam([weight], lr=0.1, betas=(0.3, 0.4)) for weight in plain]
    for target in (1.0, -3.0):
        gan.descend(0, (gan.generator.weight - target).square().sum())
        gan.descend(1, (gan.discriminator.weight + target).square().sum())
        for weight, adam, aim in zip(plain, adams, (target, -target), strict=True):
            adam.zero_grad()
            (weight - aim).square().sum().backward()
            adam.step()
    torch.testing.assert_close([gan.generator.weight, gan.discriminator.weight], plain)


def test_the_generators_loss_leaves_the_discriminator_without_gradients():
    gan = pair()
    with gan.fixed_discriminator():
        loss = gan.discriminator(gan.generator(torch.ones(1, 1))).sum()
    gan.descend(0, loss)
    assert gan.discriminator.weight.grad is None
    assert gan.discriminator.weight.requires_grad


def test_the_figure_is_the_mean_over_batches_of_32_and_8():
    gan = pair()
    gan.distance = largest
    assert gan.validation_distance(lambda photo: photo, Pairs()) == pytest.approx((32 * 31 + 8 * 39) / 40)


def test_the_least_distance_decides_and_of_equal_ones_the_later():
    gan = pair()
    gan.distance = largest
    for weight in (1.0, 2.5, 1.5, 7.0):  # off by 1, 0.5, 0.5 and 5 times the photograph
        nn.init.constant_(gan.generator.weight, weight)
        figures = gan.choose(gan.generator, Pairs())
    assert figures == {"row_statistics_unseen": pytest.approx((32 * 31 + 8 * 39) / 40 * 5)}
    gan.settle()
    assert gan.generator.weight.item() == 1.5
    assert gan.state()["chosen_by"] == "row_statistics"
    gan.settle()
    assert gan.generator.weight.item() == 1.5


def test_without_validation_pairs_the_last_weights_remain():
    gan = pair()
    nn.init.constant_(gan.generator.weight, 1.0)
    assert gan.choose(gan.generator, None) == {}
    nn.init.constant_(gan.generator.weight, 4.0)
    gan.settle()
    assert gan.generator.weight.item() == 4.0
    assert gan.state()["chosen_by"] == "last step"

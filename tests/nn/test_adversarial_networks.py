"""Losses and gradient penalty by hand, and two networks that descend each its own."""

import math
from types import SimpleNamespace

import pytest
import torch
from torch import nn

from tactogram.nn import gradient_penalty
from tactogram.nn.adversarial_networks import AdversarialPair, adversarial_loss, feature_matching_loss


def test_penalty_of_a_linear_critic_by_hand():
    """The slope of w.x is w everywhere: (|w| - 1)^2, here (5 - 1)^2."""
    w = torch.tensor([3.0, 4.0])
    found = gradient_penalty(lambda x: x @ w, torch.randn(7, 2), torch.randn(7, 2))
    assert found.item() == pytest.approx(16.0, rel=1e-5)


def test_the_penalty_is_evaluated_between_real_and_generated():
    """The slope of x^2 / 2 is x: at a quarter of the way from 0 to 8 it is 2, at three quarters 6."""
    real, made = torch.full((2, 1), 8.0), torch.zeros(2, 1)
    share = torch.tensor([0.25, 0.75])
    found = gradient_penalty(lambda x: x.square() / 2, real, made, share)
    assert found.item() == pytest.approx(((2 - 1) ** 2 + (6 - 1) ** 2) / 2)


def test_the_penalty_has_a_gradient_for_the_critic():
    """d/dw (|w| - 1)^2 = 2 (|w| - 1) w / |w|."""
    w = torch.tensor([3.0, 4.0], requires_grad=True)
    gradient_penalty(lambda x: x @ w, torch.randn(7, 2), torch.randn(7, 2)).backward()
    torch.testing.assert_close(w.grad, 2 * 4 * torch.tensor([0.6, 0.8]))


def test_signals_of_several_axes_have_one_slope():
    w = torch.full((2, 3), 1.0)
    found = gradient_penalty(lambda x: (x * w).sum((1, 2)), torch.randn(4, 2, 3), torch.randn(4, 2, 3))
    assert found.item() == pytest.approx((6**0.5 - 1) ** 2, rel=1e-5)


def test_adversarial_loss_by_hand():
    scores = [torch.tensor([0.0, 2.0]), torch.tensor([-1.0])]
    real = (math.log(2) + math.log(1 + math.exp(-2))) / 2 + math.log(1 + math.exp(1))
    fake = (math.log(2) + math.log(1 + math.exp(2))) / 2 + math.log(1 + math.exp(-1))
    assert adversarial_loss(scores, real=True).item() == pytest.approx(real)
    assert adversarial_loss(scores, real=False).item() == pytest.approx(fake)
    least = adversarial_loss(scores, real=True, kind="least-squares")
    assert least.item() == pytest.approx((1 + 1) / 2 + 4)


def test_feature_matching_by_hand_leaves_the_score_out_and_the_real_ones_alone():
    """Neshov et al. 2026, Sec. 3.1: "from all discriminator layers (excluding the final layer)"."""
    real = [[torch.zeros(2, requires_grad=True), torch.zeros(1), torch.full((1,), 9.0)] for _ in range(2)]
    made = [[torch.tensor([1.0, 3.0]), torch.tensor([-4.0]), torch.zeros(1)],
            [torch.tensor([0.0, 0.0]), torch.tensor([2.0]), torch.zeros(1)]]  # fmt: skip
    made[0][0].requires_grad_()
    loss = feature_matching_loss(made, real)
    assert loss.item() == pytest.approx(((2 + 4) / 2 + (0 + 2) / 2) / 2)
    loss.backward()
    assert real[0][0].grad is None
    assert made[0][0].grad is not None


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
    """Neshov et al. 2026, Sec. 3.2: rates fall "across the final 100 of the 200 total training epochs"."""
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

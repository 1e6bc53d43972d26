"""One update of generator and discriminators beside Eq. 5 of Wang et al. 2018 with least squares, written out."""

from copy import deepcopy

import pytest
import torch
from torch import nn
from torch.testing import assert_close

from tactogram.model import SignalKind, Stage
from tactogram.models.pix2pixhd.config import Config
from tactogram.models.pix2pixhd.learner import Pix2PixHDLearner

pytestmark = pytest.mark.usefixtures("double_precision")

KIND = SignalKind(1000.0, "m/s^2", ("z",), ("coarse", "fine"), simulated=True)
STEPS = 8
SMALL = {"generator_width": 3, "downsamplings": 2, "blocks": 1, "discriminators": 2, "layers": 2, "width": 4}


class SquaredDistance(nn.Module):
    """Stands for VGG-19."""

    def forward(self, generated, real):
        return (generated - real).square().mean()


def batch(number):
    generator = torch.Generator().manual_seed(number)
    photo, picture = (torch.rand(3, 1, 16, 16, generator=generator) * 2 - 1 for _ in range(2))
    return number, photo, picture, torch.tensor([0, 1, 1]), torch.arange(3), 1000


def squares(outputs, target):
    """Mean over patches of (score - target)^2, summed over the discriminators."""
    return sum((features[-1] - target).square().mean() for features in outputs)


def gradients(loss, network):
    return list(torch.autograd.grad(loss, list(network.parameters()), retain_graph=True))


@pytest.mark.parametrize("perceptual", [False, True], ids=["plain", "perceptual"])
def test_an_update_is_least_squares_and_10_feature_matching_and_10_perceptual(perceptual):
    """Feature matching as in the authors' code: a sum over layers, times 4 / (L + 1), mean over discriminators."""
    ours = Pix2PixHDLearner(Config(**SMALL, steps=STEPS), KIND, seed=0)
    if perceptual:
        ours.perceptual = SquaredDistance()
    g, d = deepcopy(ours.gan.generator), deepcopy(ours.gan.discriminator)
    adams = [torch.optim.Adam(n.parameters(), lr=2e-4, betas=(0.5, 0.999)) for n in (g, d)]
    for number, share in ((0, 1.0), (4, 1.0), (6, 0.5)):
        inputs = _, photo, picture, *_ = batch(number)
        figures = ours.step(Stage("gan", STEPS), inputs)
        generated = g(photo)
        real, fake, outputs = (d(torch.cat((photo, x), 1)) for x in (picture, generated.detach(), generated))
        layers = [(outputs[k][layer], real[k][layer]) for k in (0, 1) for layer in (0, 1, 2)]
        losses = {
            "discriminator": (squares(real, 1) + squares(fake, 0)) / 2,
            "adversarial": squares(outputs, 1),
            "matching": sum(4 / 3 * (a - b).abs().mean() for a, b in layers) / 2,
        }
        loss_g = losses["adversarial"] + 10 * losses["matching"]
        if perceptual:
            losses["perceptual"] = (generated - picture).square().mean()
            loss_g = loss_g + 10 * losses["perceptual"]
        expected = gradients(loss_g, g), gradients(losses["discriminator"], d)
        for network, adam, slopes in zip((g, d), adams, expected, strict=True):
            for parameter, slope in zip(network.parameters(), slopes, strict=True):
                parameter.grad = slope
            adam.param_groups[0]["lr"] = 2e-4 * share
            adam.step()
        assert figures == pytest.approx({name: loss.item() for name, loss in losses.items()})
        for mine, slopes in zip((ours.gan.generator, ours.gan.discriminator), expected, strict=True):
            assert_close([p.grad for p in mine.parameters()], slopes)
    for mine, theirs in ((ours.gan.generator, g), (ours.gan.discriminator, d)):
        assert_close(list(mine.parameters()), list(theirs.parameters()), rtol=0, atol=1e-8)

"""One step of critic and generator beside Algorithm 1 of Gulrajani et al. 2017, written out."""

from copy import deepcopy

import pytest
import torch
from torch import nn
from torch.testing import assert_close

from tactogram.model import SignalKind, Stage
from tactogram.models.residue_fusion_gan.config import Config
from tactogram.models.residue_fusion_gan.learner import ResidueFusionLearner
from tactogram.nn.label_predictor import PredictorConfig

pytestmark = pytest.mark.usefixtures("double_precision")

KIND = SignalKind(1000.0, "m/s^2", ("z",), ("coarse", "fine"), simulated=True)
STEPS = 4
SMALL = {"widths": (4, 6, 6), "width": 4, "layers": 2, "batch_size": 3}


class SquaredDistance(nn.Module):
    """Stands for VGG-19."""

    def forward(self, generated, real):
        return (generated - real).square().mean()


def batch(number):
    generator = torch.Generator().manual_seed(number)
    photo, picture = (torch.rand(15, 1, 16, 16, generator=generator) * 2 - 1 for _ in range(2))
    return number, photo, picture, torch.arange(15) % 2, torch.arange(15), 1000


class Plain:
    """Critic D and generator G; ``maps`` are the classifier's, which stays as it is."""

    def __init__(self, d, g, maps):
        self.d, self.g, self.maps = d, g, maps
        self.d_adam, self.g_adam = (
            torch.optim.Adam(n.parameters(), lr=1e-4, betas=(0.0, 0.9)) for n in (d, g)
        )

    def score(self, photo, picture):
        """One number per pair: the mean over its patches."""
        return self.d(torch.cat((photo, picture), 1))[-1].mean((1, 2, 3))

    def update_critic(self, photo, picture):
        generated = self.g(photo, self.maps(photo)).detach()
        distance = self.score(photo, picture).mean() - self.score(photo, generated).mean()
        epsilon = torch.rand(len(photo))[:, None, None, None]
        between = (epsilon * picture + (1 - epsilon) * generated).requires_grad_()
        (slope,) = torch.autograd.grad(self.score(photo, between).sum(), between, create_graph=True)
        penalty = ((slope.square().sum((1, 2, 3)).sqrt() - 1) ** 2).mean()
        self.d_adam.zero_grad()
        (-distance + 10 * penalty).backward()
        self.d_adam.step()
        return {"wasserstein": distance.item(), "penalty": penalty.item()}

    def update_generator(self, photo, picture, *, perceptual):
        generated = self.g(photo, self.maps(photo))
        outputs, real = (self.d(torch.cat((photo, x), 1)) for x in (generated, picture))
        losses = {
            "adversarial": -outputs[-1].mean(),
            "matching": sum((a - b).abs().mean() for a, b in zip(outputs[:3], real[:3], strict=True)) / 3,
        }
        loss = losses["adversarial"] + 40 * losses["matching"]
        if perceptual:
            losses["perceptual"] = (generated - picture).square().mean()
            loss = loss + 10 * losses["perceptual"]
        self.g_adam.zero_grad()
        loss.backward()
        slopes = [p.grad.clone() for p in self.g.parameters()]
        self.g_adam.step()
        return {name: value.item() for name, value in losses.items()}, slopes


@pytest.mark.parametrize("perceptual", [False, True], ids=["plain", "perceptual"])
def test_a_step_is_five_critic_updates_and_one_of_the_generator(perceptual):
    config = Config(**SMALL, steps=STEPS, predictor=PredictorConfig(trunk="own", hidden=4))
    ours = ResidueFusionLearner(config, KIND, seed=0)
    assert ours.pairs_per_step == 15
    if perceptual:
        ours.perceptual = SquaredDistance()
    trunk = deepcopy(ours.predictor.bare.trunk).eval()
    plain = Plain(deepcopy(ours.gan.discriminator), deepcopy(ours.gan.generator), trunk.maps)
    before = deepcopy(ours.predictor.bare.state_dict())
    for number in (0, 3):
        inputs = _, photo, picture, *_ = batch(number)
        torch.manual_seed(number)  # of the places between
        figures = ours.step(Stage("gan", STEPS), inputs)
        torch.manual_seed(number)
        expected = {}
        for part in (slice(3 * update, 3 * update + 3) for update in range(5)):
            expected |= plain.update_critic(photo[part], picture[part])
        losses, slopes = plain.update_generator(photo[:3], picture[:3], perceptual=perceptual)
        assert figures == pytest.approx(expected | losses)
        assert_close([p.grad for p in ours.gan.generator.parameters()], slopes)
    for mine, theirs in ((ours.gan.generator, plain.g), (ours.gan.discriminator, plain.d)):
        assert_close(list(mine.parameters()), list(theirs.parameters()), rtol=0, atol=1e-8)
    assert_close(ours.predictor.bare.state_dict(), before, rtol=0, atol=0)

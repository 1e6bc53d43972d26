"""The published update of critic and generator beside Algorithm 1 of Gulrajani et al. 2017, written out."""

from copy import deepcopy

import pytest
import torch
from torch.testing import assert_close

from tactogram.model import SignalKind, Stage
from tactogram.models.stroke_gan.config import Config
from tactogram.models.stroke_gan.learner import StrokeGANLearner

pytestmark = pytest.mark.usefixtures("double_precision")

SMALL = {"points": 4, "channels": (6, 4), "latent": 5, "batch_size": 4, "phase_shuffle": 0}
STEPS = 3


def learner(**changes):
    kind = SignalKind(1000.0, "m/s^2", ("x", "y"), ("cork", "felt"), simulated=True)
    return StrokeGANLearner(Config(**SMALL, **changes), kind, seed=0)


class Plain:
    """Critic D and generator G, updated as Algorithm 1 and Table IV have it."""

    def __init__(self, d, g, draw):
        self.d, self.g, self.draw = d, g, draw
        self.d_adam, self.g_adam = (
            torch.optim.Adam(n.parameters(), lr=1e-4, betas=(0.5, 0.9)) for n in (d, g)
        )

    def made(self, label):
        return self.g(2 * self.draw(len(label), 5) - 1, label)

    def update_critic(self, real, label):
        fake = self.made(label).detach()
        epsilon = self.draw(len(real))[:, None, None]
        between = (epsilon * real + (1 - epsilon) * fake).requires_grad_()
        (slope,) = torch.autograd.grad(self.d(between, label).sum(), between, create_graph=True)
        penalty = ((slope.square().sum((1, 2)).sqrt() - 1) ** 2).mean()
        distance = self.d(real, label).mean() - self.d(fake, label).mean()
        self.d_adam.zero_grad()
        (-distance + 10 * penalty).backward()
        self.d_adam.step()
        return {"wasserstein": distance.item(), "penalty": penalty.item()}

    def update_generator(self, label):
        loss = -self.d(self.made(label), label).mean()
        self.g_adam.zero_grad()
        loss.backward()
        gradients = [p.grad.clone() for p in self.g.parameters()]
        self.g_adam.step()
        return {"generator_loss": loss.item()}, gradients


@pytest.mark.parametrize(("critic_updates", "generator_updates"), [(1, 2), (2, 1)], ids=["paper", "critic2"])
def test_a_step_is_algorithm_1_with_the_numbers_of_table_iv(monkeypatch, critic_updates, generator_updates):
    values = {} if critic_updates == 1 else {"critic_updates": 2, "generator_updates": 1}
    ours, rand = learner(**values), torch.rand
    stream = [torch.Generator().manual_seed(7) for _ in range(2)]
    plain = Plain(
        deepcopy(ours.discriminator), deepcopy(ours.generator), lambda *size: rand(size, generator=stream[1])
    )
    monkeypatch.setattr(torch, "rand", lambda *size: rand(size, generator=stream[0]))
    for number in range(STEPS):
        real = rand(4 * critic_updates, 2, 64, generator=torch.Generator().manual_seed(number)) * 2 - 1
        label = torch.eye(2)[torch.arange(4 * critic_updates) % 2]
        figures = ours.step(Stage("train", STEPS), (real.numpy(), label.numpy()))
        expected = {}
        for update in range(critic_updates):
            expected |= plain.update_critic(real[4 * update :][:4], label[4 * update :][:4])
        for _ in range(generator_updates):
            losses, gradients = plain.update_generator(label[:4])
        assert figures == pytest.approx(expected | losses)
        assert_close([p.grad for p in ours.generator.parameters()], gradients)
    for mine, theirs in ((ours.discriminator, plain.d), (ours.generator, plain.g)):
        assert_close(list(mine.parameters()), list(theirs.parameters()), rtol=0, atol=1e-8)

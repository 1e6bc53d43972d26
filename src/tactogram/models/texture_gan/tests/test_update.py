"""One update of critic and generator beside their losses, written out."""

from copy import deepcopy

import pytest
import torch
from torch.testing import assert_close

from tactogram.model import SignalKind, Stage
from tactogram.models.texture_gan.config import Config
from tactogram.models.texture_gan.learner import TextureGANLearner
from tactogram.models.texture_gan.networks import split_bands
from tactogram.models.texture_gan.texture_statistics import energy_distance, statistics

pytestmark = pytest.mark.usefixtures("double_precision")

VALUES = {
    "points": 8, "channels": (6, 4, 2), "latent": 5, "sinusoids": 0, "batch_size": 4, "phase_shuffle": 0,
    "conditions": (), "moving_average": 0.5,
}  # fmt: skip
RATE, GENERATOR_RATE = 1e-3, 2e-3


@pytest.mark.parametrize("weights", [(0.03, 1.0), (0.4, 0.0), (0.0, 0.7)], ids=str)
def test_a_step_is_the_critics_loss_then_the_weighted_sum_of_the_generators(monkeypatch, weights):
    adversarial, energy = weights
    kind = SignalKind(1000.0, "m/s^2", ("x", "y"), ("cork", "felt"), simulated=True)
    ours = TextureGANLearner(Config(**VALUES, adversarial=adversarial, statistics=energy), kind, seed=0)
    real = torch.randn(4, 2, 512, generator=torch.Generator().manual_seed(1))
    label = torch.eye(2)[[0, 1, 0, 1]]
    ours.spread = 1 + torch.rand(
        statistics(real).shape[1], generator=torch.Generator().manual_seed(2), dtype=torch.float64
    )
    d, g, average = deepcopy(ours.discriminator), deepcopy(ours.generator), deepcopy(ours.generator)
    streams = [torch.Generator().manual_seed(7) for _ in range(2)]
    rand, randn = torch.rand, torch.randn
    monkeypatch.setattr(torch, "rand", lambda *size: rand(size, generator=streams[0]))
    monkeypatch.setattr(torch, "randn", lambda *size, generator=None: randn(size, generator=streams[0]))
    figures = ours.step(Stage("train", 4), (1, real.numpy(), label.numpy()))

    def made():
        latent = 2 * rand((4, 5), generator=streams[1]) - 1
        return g(latent, label, split_bands(randn((4, 2, 512), generator=streams[1]), 4))

    share = (1 + 0.5**0.5) / 2  # of the learning rates, a quarter of the way along a cosine
    expected = {}
    if adversarial:
        adam = torch.optim.Adam(d.parameters(), lr=RATE * share, betas=(0.5, 0.9))
        fake = made().detach()
        epsilon = rand((4,), generator=streams[1])[:, None, None]
        between = (epsilon * real + (1 - epsilon) * fake).requires_grad_()
        (slope,) = torch.autograd.grad(d(between, label).sum(), between, create_graph=True)
        penalty = ((slope.square().sum((1, 2)).sqrt() - 1) ** 2).mean()
        distance = d(real, label).mean() - d(fake, label).mean()
        (10 * penalty - distance).backward()
        adam.step()
        expected |= {"wasserstein": distance.item(), "penalty": penalty.item()}
    adam = torch.optim.Adam(g.parameters(), lr=GENERATOR_RATE * share, betas=(0.5, 0.9))
    fake, loss = made(), torch.zeros(())
    if adversarial:
        expected["generator_loss"] = (verdict := -d(fake, label).mean()).item()
        loss = loss + adversarial * verdict
    if energy:
        theirs, mine, again = (statistics(x) / ours.spread for x in (real, fake, made()))
        expected["statistics"] = (score := energy_distance(theirs, mine, again)).item()
        loss = loss + energy * score
    loss.backward()
    adam.step()
    assert figures == pytest.approx(expected)
    if adversarial:
        assert_close(list(ours.discriminator.parameters()), list(d.parameters()), rtol=0, atol=1e-8)
    assert_close(list(ours.generator.parameters()), list(g.parameters()), rtol=0, atol=1e-8)
    kept = 2 / 11  # by the average, of its first update
    averaged = [
        kept * old + (1 - kept) * new for old, new in zip(average.parameters(), g.parameters(), strict=True)
    ]
    assert_close(list(ours.average.network.parameters()), averaged, rtol=0, atol=1e-8)

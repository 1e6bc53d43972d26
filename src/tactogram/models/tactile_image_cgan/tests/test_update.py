"""One update of discriminator and generator beside Eq. 2 and Table 4 of Hatori et al. 2025, written out."""

from copy import deepcopy

import pytest
import torch
from torch.testing import assert_close

from tactogram.model import ImageKind, Stage
from tactogram.models.tactile_image_cgan.config import Config
from tactogram.models.tactile_image_cgan.learner import TactileImageLearner

pytestmark = pytest.mark.usefixtures("double_precision")

STEPS = 3


def cross_entropy(probability, label):
    """Eq. 2."""
    return -(label * probability.log() + (1 - label) * (1 - probability).log()).mean()


def descend(adam, loss):
    adam.zero_grad()
    loss.backward()
    slopes = [p.grad.clone() for p in adam.param_groups[0]["params"]]
    adam.step()
    return slopes


def test_an_update_is_the_discriminators_then_the_generators():
    """Real images have label 1 and their own scores, made ones label 0 and random scores; the generator wants 1."""
    config = Config(widths=(6, 4), noise=3, batch_size=4, updates=STEPS)
    ours = TactileImageLearner(config, ImageKind(("rough", "sleek"), (0.0, 1.0), ("a",)), seed=0)
    g, d = deepcopy(ours.gan.generator), deepcopy(ours.gan.discriminator)
    g_adam, d_adam = (
        torch.optim.Adam(n.parameters(), lr=0.002, betas=(0.5, 0.999), eps=1e-8) for n in (g, d)
    )
    for number in range(STEPS):
        generator = torch.Generator().manual_seed(number)
        images, scores = (
            torch.rand(4, 3, 16, 16, generator=generator) * 2 - 1,
            torch.rand(4, 2, generator=generator),
        )
        torch.manual_seed(number)
        figures = ours.step(Stage("gan", STEPS), (images, scores))
        torch.manual_seed(number)
        noise, drawn = torch.randn(4, 3), torch.rand(4, 2)
        made = g(noise, drawn)
        real, fake = torch.sigmoid(d(images, scores)), torch.sigmoid(d(made.detach(), drawn))
        loss_d = cross_entropy(real, 1) + cross_entropy(fake, 0)
        slopes_d = descend(d_adam, loss_d)
        loss_g = cross_entropy(torch.sigmoid(d(made, drawn)), 1)
        slopes_g = descend(g_adam, loss_g)
        correct = ((real > 0.5).sum() + (fake < 0.5).sum()).item() / 8
        assert figures == pytest.approx(
            {"generator": loss_g.item(), "discriminator": loss_d.item(), "correct": correct}
        )
        assert_close([p.grad for p in ours.gan.discriminator.parameters()], slopes_d)
        assert_close([p.grad for p in ours.gan.generator.parameters()], slopes_g)
    for mine, theirs in ((ours.gan.generator, g), (ours.gan.discriminator, d)):
        assert_close(list(mine.parameters()), list(theirs.parameters()), rtol=0, atol=1e-7)

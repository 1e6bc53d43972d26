"""One update of discriminator and generator beside Eq. 2 and Table 4 of Hatori et al. 2025, written out."""

import math
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
        generated = g(noise, drawn)
        real, fake = torch.sigmoid(d(images, scores)[0]), torch.sigmoid(d(generated.detach(), drawn)[0])
        loss_d = cross_entropy(real, 1) + cross_entropy(fake, 0)
        slopes_d = descend(d_adam, loss_d)
        loss_g = cross_entropy(torch.sigmoid(d(generated, drawn)[0]), 1)
        slopes_g = descend(g_adam, loss_g)
        correct = ((real > 0.5).sum() + (fake < 0.5).sum()).item() / 8
        assert figures == pytest.approx(
            {"generator": loss_g.item(), "discriminator": loss_d.item(), "correct": correct}
        )
        assert_close([p.grad for p in ours.gan.discriminator.parameters()], slopes_d)
        assert_close([p.grad for p in ours.gan.generator.parameters()], slopes_g)
    for mine, theirs in ((ours.gan.generator, g), (ours.gan.discriminator, d)):
        assert_close(list(mine.parameters()), list(theirs.parameters()), rtol=0, atol=1e-7)


def test_both_networks_descend_the_cross_entropy_of_the_predicted_scores():
    """A discriminator that predicts 1/2 for every word: log 2 times the weight; its slopes are those of the sum."""
    config = Config(
        widths=(6, 4), noise=3, batch_size=4, image_weight=1.0, label_input="none", regression_weight=2.0
    )
    ours = TactileImageLearner(config, ImageKind(("rough", "sleek"), (0.0, 1.0), ("a",)), seed=0)
    head = ours.gan.discriminator.regression
    head.weight.data.zero_()
    head.bias.data.zero_()
    d = deepcopy(ours.gan.discriminator)
    images, scores = torch.rand(4, 3, 16, 16) * 2 - 1, torch.rand(4, 2)
    features = d.layers[:-1](images).mean((2, 3))
    predicted = torch.sigmoid(d.regression(features))
    loss = -2 * (scores * predicted.log() + (1 - scores) * (1 - predicted).log()).mean()
    [slope] = torch.autograd.grad(loss, [d.regression.weight])
    figures = ours.step(Stage("gan", 1), (images, scores))
    assert figures["words_discriminator"] == pytest.approx(2 * math.log(2))
    assert figures["words_generator"] != pytest.approx(2 * math.log(2))  # the head is one update on
    assert_close(head.weight.grad, slope)


def test_fakes_may_have_the_scores_of_the_real_images(monkeypatch):
    config = Config(widths=(6, 4), noise=3, batch_size=4, fake_scores="rated")
    ours = TactileImageLearner(config, ImageKind(("rough", "sleek"), (0.0, 1.0), ("a",)), seed=0)
    seen, forward = [], ours.gan.discriminator.forward
    monkeypatch.setattr(ours.gan.discriminator, "forward", lambda x, y: seen.append(y) or forward(x, y))
    scores = torch.rand(4, 2)
    ours.step(Stage("gan", 1), (torch.rand(4, 3, 16, 16), scores))
    assert all(torch.equal(labels, scores) for labels in seen)

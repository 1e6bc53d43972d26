"""One update of discriminator and generator beside Eq. 2 and Table 4 of Hatori et al. 2025, written out."""

from copy import deepcopy

import pytest
import torch
from torch.testing import assert_close

from tactogram.model import ImageKind, Stage
from tactogram.models.tactile_image_cgan.config import Config
from tactogram.models.tactile_image_cgan.learner import TactileImageLearner
from tactogram.models.tactile_image_cgan.seen_features import seen_features
from tactogram.nn.score_regression import ScoreRegression

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
        real, fake = torch.sigmoid(d(images, scores)), torch.sigmoid(d(generated.detach(), drawn))
        loss_d = cross_entropy(real, 1) + cross_entropy(fake, 0)
        slopes_d = descend(d_adam, loss_d)
        loss_g = cross_entropy(torch.sigmoid(d(generated, drawn)), 1)
        slopes_g = descend(g_adam, loss_g)
        correct = ((real > 0.5).sum() + (fake < 0.5).sum()).item() / 8
        assert figures == pytest.approx(
            {"generator": loss_g.item(), "discriminator": loss_d.item(), "correct": correct}
        )
        assert_close([p.grad for p in ours.gan.discriminator.parameters()], slopes_d)
        assert_close([p.grad for p in ours.gan.generator.parameters()], slopes_g)
    for mine, theirs in ((ours.gan.generator, g), (ours.gan.discriminator, d)):
        assert_close(list(mine.parameters()), list(theirs.parameters()), rtol=0, atol=1e-7)


def test_words_weight_adds_the_error_of_the_scores_predicted_of_the_generated_images():
    config = Config(widths=(6, 4), noise=3, batch_size=4, words_weight=2.0)
    ours = TactileImageLearner(config, ImageKind(("rough", "sleek"), (0.0, 1.0), ("a",)), seed=0)
    images, scores = torch.rand(6, 3, 16, 16) * 2 - 1, torch.rand(6, 2)
    ours.regression = ScoreRegression(seen_features(images), scores)
    g, d = deepcopy(ours.gan.generator), ours.gan.discriminator
    torch.manual_seed(0)
    figures = ours.step(Stage("gan", 1), (images, scores))
    torch.manual_seed(0)
    noise, drawn = torch.randn(6, 3), torch.rand(6, 2)
    generated = g(noise, drawn)
    words = 2 * ours.regression.loss(seen_features(generated), drawn)
    loss = cross_entropy(torch.sigmoid(d(generated, drawn)), 1) + words  # by the updated discriminator
    assert figures["words"] == pytest.approx(words.item())
    assert_close(
        [p.grad for p in ours.gan.generator.parameters()], torch.autograd.grad(loss, [*g.parameters()])
    )

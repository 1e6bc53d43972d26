"""One update of generator and discriminators beside Sec. 3.1 (losses) and 3.2 (optimisers), written out."""

from copy import deepcopy

import pytest
import torch
from torch.nn.functional import one_hot
from torch.testing import assert_close

from tactogram.model import SignalKind, Stage
from tactogram.models.visual_tactile_gan.config import Config
from tactogram.models.visual_tactile_gan.learner import VisualTactileLearner
from tactogram.nn.label_predictor import PredictorConfig

pytestmark = pytest.mark.usefixtures("double_precision")

KIND = SignalKind(1000.0, "m/s^2", ("z",), ("coarse", "fine"), simulated=True)
STEPS = 8


def learner(**changes):
    config = Config(
        widths=(4, 6, 6), width=4, discriminators=2, layers=2, label_gain=1.0, steps=STEPS,
        predictor=PredictorConfig(trunk="own", hidden=4), **changes,
    )  # fmt: skip
    return VisualTactileLearner(config, KIND, seed=0)


def batch(number):
    generator = torch.Generator().manual_seed(number)
    photo, picture = (torch.rand(4, 1, 16, 16, generator=generator) * 2 - 1 for _ in range(2))
    return number, photo, picture, torch.tensor([0, 1, 1, 0]), torch.arange(4) + 4 * number, 1000


def says_real(outputs):
    """-log D, mean over patches, summed over the discriminators."""
    return sum(-torch.sigmoid(features[-1]).log().mean() for features in outputs)


def says_made(outputs):
    """-log(1 - D), likewise."""
    return sum(-(1 - torch.sigmoid(features[-1])).log().mean() for features in outputs)


def feature_distance(outputs, real):
    """Mean over two discriminators of the mean over three layers of features, without the score."""
    return (
        sum((a - b).abs().mean() for d in (0, 1) for a, b in zip(outputs[d][:3], real[d][:3], strict=True))
        / 6
    )


def gradients(loss, network):
    return list(torch.autograd.grad(loss, list(network.parameters()), retain_graph=True))


@pytest.mark.parametrize("label", ["predicted", "true", "probabilities"])
def test_an_update_is_adversarial_and_10_l1_and_40_feature_matching(label):
    """Both losses are of the weights before either's update; the learning rate falls in the second half."""
    ours = learner(label=label)
    g, d = deepcopy(ours.gan.generator), deepcopy(ours.gan.discriminator)
    adams = [torch.optim.Adam(n.parameters(), lr=2e-4, betas=(0.5, 0.999)) for n in (g, d)]
    for number, share in ((0, 1.0), (4, 1.0), (6, 0.5)):
        inputs = _, photo, picture, true, *_ = batch(number)
        figures = ours.step(Stage("gan", STEPS), inputs)
        probabilities = ours.predictor.bare.eval()(photo).softmax(1)
        predicted = one_hot(probabilities.argmax(1), 2)
        assert not torch.equal(predicted.argmax(1), true)  # else this would not notice whose label it is
        condition = {"true": one_hot(true, 2), "predicted": predicted, "probabilities": probabilities.float()}
        generated = g(photo, condition[label].double())
        real, fake, outputs = (d(torch.cat((photo, x), 1)) for x in (picture, generated.detach(), generated))
        adversarial, l1, matching = (
            says_real(outputs),
            (generated - picture).abs().mean(),
            feature_distance(outputs, real),
        )
        loss_d = says_real(real) + says_made(fake)
        expected = gradients(adversarial + 10 * l1 + 40 * matching, g), gradients(loss_d, d)
        for network, adam, slopes in zip((g, d), adams, expected, strict=True):
            for parameter, slope in zip(network.parameters(), slopes, strict=True):
                parameter.grad = slope
            adam.param_groups[0]["lr"] = 2e-4 * share
            adam.step()
        assert figures == pytest.approx(
            {"discriminator": loss_d.item(), "adversarial": adversarial.item(), "l1": l1.item(),
             "matching": matching.item()}
        )  # fmt: skip
        for mine, slopes in zip((ours.gan.generator, ours.gan.discriminator), expected, strict=True):
            assert_close([p.grad for p in mine.parameters()], slopes)
    for mine, theirs in ((ours.gan.generator, g), (ours.gan.discriminator, d)):
        assert_close(list(mine.parameters()), list(theirs.parameters()), rtol=0, atol=1e-8)

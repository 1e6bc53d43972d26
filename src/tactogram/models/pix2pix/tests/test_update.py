"""One update of discriminator and generator beside the objective of Isola et al. 2017, written out."""

from copy import deepcopy

import pytest
import torch
from torch.testing import assert_close

from tactogram.model import SignalKind, Stage
from tactogram.models.pix2pix.config import Config
from tactogram.models.pix2pix.learner import Pix2PixLearner

pytestmark = pytest.mark.usefixtures("double_precision")

KIND = SignalKind(1000.0, "m/s^2", ("z",), ("coarse", "fine"), simulated=True)
STEPS = 8


def batch(number):
    generator = torch.Generator().manual_seed(number)
    photo, picture = (torch.rand(4, 1, 16, 16, generator=generator) * 2 - 1 for _ in range(2))
    return number, photo, picture, torch.tensor([0, 1, 1, 0]), torch.arange(4), 1000


def descend(adam, loss, share):
    adam.zero_grad()
    loss.backward()
    adam.param_groups[0]["lr"] = 2e-4 * share
    slopes = [p.grad.clone() for p in adam.param_groups[0]["params"]]
    adam.step()
    return slopes


def test_an_update_is_equations_1_to_4_with_lambda_100():
    """The discriminator first, its objective halved (Sec. 3.3), then the generator against it by -log D (Eq. 1)."""
    ours = Pix2PixLearner(Config(widths=(4, 6, 6), dropout=1, width=4, layers=1, steps=STEPS), KIND, seed=0)
    g, d = deepcopy(ours.gan.generator), deepcopy(ours.gan.discriminator)
    g_adam, d_adam = (torch.optim.Adam(n.parameters(), lr=2e-4, betas=(0.5, 0.999)) for n in (g, d))
    for number, share in ((0, 1.0), (4, 1.0), (6, 0.5)):
        inputs = _, photo, picture, *_ = batch(number)
        torch.manual_seed(number)  # of dropout
        figures = ours.step(Stage("gan", STEPS), inputs)
        torch.manual_seed(number)
        g.train(), d.train()
        generated = g(photo)
        real, fake = (torch.sigmoid(d(torch.cat((photo, x), 1))[-1]) for x in (picture, generated.detach()))
        loss_d = -(real.log().mean() + (1 - fake).log().mean()) / 2
        slopes_d = descend(d_adam, loss_d, share)
        adversarial = -torch.sigmoid(d(torch.cat((photo, generated), 1))[-1]).log().mean()
        l1 = (generated - picture).abs().mean()
        slopes_g = descend(g_adam, adversarial + 100 * l1, share)
        assert figures == pytest.approx(
            {"discriminator": loss_d.item(), "adversarial": adversarial.item(), "l1": l1.item()}
        )
        assert_close([p.grad for p in ours.gan.discriminator.parameters()], slopes_d)
        assert_close([p.grad for p in ours.gan.generator.parameters()], slopes_g)
    for mine, theirs in ((ours.gan.generator, g), (ours.gan.discriminator, d)):
        assert_close(list(mine.parameters()), list(theirs.parameters()), rtol=0, atol=1e-8)

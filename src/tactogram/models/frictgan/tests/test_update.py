"""One step of critic and generator beside Eq. 2 and 3 of Cai et al. 2020 and Arjovsky et al. 2017, written out."""

from copy import deepcopy

import pytest
import torch
from torch.testing import assert_close

from tactogram.model import SignalKind, Stage
from tactogram.models.frictgan.config import Config
from tactogram.models.frictgan.learner import FrictGANLearner

pytestmark = pytest.mark.usefixtures("double_precision")

KIND = SignalKind(20.0, "1", ("along",), ("coarse", "fine"), True, "displacement")
STEPS = 2
SMALL = {
    "pixels": 32, "n_fft": 64, "hop": 16, "frames": 9, "channels": (4, 4, 6), "strides": (2, 2, 4),
    "up_strides": (4, 2, 2), "wide": 1, "latent": 4, "noise": 3, "match": "pool", "critic_channels": (4, 4, 4, 4),
    "steps": STEPS,
}  # fmt: skip


def learner(**changes):
    gan = FrictGANLearner(Config(**SMALL, **changes), KIND, seed=0)
    gan.as_learned = lambda spectra: spectra  # batches hold spectrograms here, not the friction they are of
    return gan


def batch(number):
    generator = torch.Generator().manual_seed(number)
    return (
        torch.rand(10, 3, 32, 32, generator=generator) * 2 - 1,
        torch.rand(10, 1, 33, 9, generator=generator),
    )


class Plain:
    """Critic D and generator G, updated as Algorithm 1 has it, with the weights clipped."""

    def __init__(self, d, g, *, wasserstein):
        self.d, self.g, self.wasserstein = d, g, wasserstein
        self.d_step, self.g_step = (
            torch.optim.RMSprop(n.parameters(), lr=5e-5, alpha=0.9, eps=1e-7) for n in (d, g)
        )

    def made(self, photo):
        return self.g(photo, torch.randn(len(photo), 3))

    def update_critic(self, photo, real):
        fake = self.made(photo).detach()
        real, fake = self.d(photo, real), self.d(photo, fake)
        if self.wasserstein:
            figures = {"wasserstein": real.mean() - fake.mean()}
            loss = -figures["wasserstein"]
        else:
            loss = -torch.sigmoid(real).log().mean() - (1 - torch.sigmoid(fake)).log().mean()
            figures = {"critic_loss": loss}
        self.d_step.zero_grad()
        loss.backward()
        self.d_step.step()
        with torch.no_grad():
            for weight in self.d.parameters():
                weight.clip_(-0.01, 0.01)
        return {name: value.item() for name, value in figures.items()}

    def update_generator(self, photo, real):
        fake = self.made(photo)
        score, l1 = self.d(photo, fake), (fake - real).abs().mean()
        adversarial = -score.mean() if self.wasserstein else -torch.sigmoid(score).log().mean()
        self.g_step.zero_grad()
        (adversarial + 100 * l1).backward()
        slopes = [p.grad.clone() for p in self.g.parameters()]
        self.g_step.step()
        return {"l1": l1.item(), "adversarial": adversarial.item()}, slopes


@pytest.mark.parametrize("loss", ["wasserstein", "cross-entropy"])
def test_a_step_is_five_clipped_critic_updates_and_one_of_the_generator_with_lambda_100(loss):
    ours = learner(loss=loss)
    plain = Plain(deepcopy(ours.discriminator), deepcopy(ours.generator), wasserstein=loss == "wasserstein")
    for number in range(STEPS):
        photo, real = batch(number)
        torch.manual_seed(number)  # of noise and dropout
        figures = ours.step(Stage("train", STEPS), (photo, real, number / STEPS))
        torch.manual_seed(number)
        expected = {}
        for part in (slice(2 * update, 2 * update + 2) for update in range(5)):
            expected |= plain.update_critic(photo[part], real[part])
        losses, slopes = plain.update_generator(photo[8:], real[8:])
        assert figures == pytest.approx(expected | losses)
        assert_close([p.grad for p in ours.generator.parameters()], slopes)
    for mine, theirs in ((ours.generator, plain.g), (ours.discriminator, plain.d)):
        assert_close(list(mine.parameters()), list(theirs.parameters()), rtol=0, atol=1e-8)

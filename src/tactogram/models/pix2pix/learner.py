"""pix2pix as Isola et al. 2017, Sec. 3, train it; from a photograph to a signal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import torch
import torch.nn.functional as F
from torch import Tensor

from tactogram.evaluation.pictures.checkpoint_choice import picture_choice
from tactogram.model import Condition, Example, SignalKind, Stage, check_condition
from tactogram.models.pix2pix.config import Config
from tactogram.models.pix2pix.networks import discriminator, generator
from tactogram.nn.adversarial_loss import adversarial_loss
from tactogram.nn.adversarial_pair import AdversarialPair
from tactogram.nn.photo_translation import PhotoTranslation
from tactogram.nn.picture_training import PictureTraining
from tactogram.signal import Signal
from tactogram.training.seeds import torch_seeded


class Pix2PixLearner:
    """U-Net and PatchGAN; dropout is the generator's only noise, in use as in training.

    Parameters
    ----------
    config : Config
    kind : SignalKind
        Rate, unit, axis and materials of the training signals.
    seed : int
        Decides initial weights, crops and pairs.
    device : str or torch.device
    """

    predictor = None

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        self.config, self.kind, self.materials = config, kind, kind.materials
        self.ends = PhotoTranslation(config.pairs, kind, seed=seed)
        with torch_seeded(seed, "weights"):
            self.gan = AdversarialPair(
                generator(config),
                discriminator(config),
                learning_rate=config.learning_rate,
                betas=config.betas,
                device=torch.device(device),
                constant=config.constant,
            )
        self.training = PictureTraining(
            self.ends,
            self.gan,
            batch_size=config.batch_size,
            epochs=config.epochs,
            steps=config.steps,
            choose_every=config.choose_every,
        )

    def setup(self, fabric: Any) -> None:
        self.training.setup(fabric)

    def set_validation(self, examples: Sequence[Example]) -> str:
        """Choose weights by ``examples``, which are not trained on; return a note if not by the distance asked for."""
        choice = picture_choice(self.config.choose_by, self.config.lpips_weights)
        self.training.watch(examples, choice.name, choice.distance)
        return choice.note

    # -- training ----------------------------------------------------------------------------------------

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        return self.training.stages(examples)

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        return self.training.batches(stage, examples, seed=seed, start=start)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        return self.training.step(stage, batch, self._update, self.make)

    def _update(self, photo: Tensor, picture: Tensor, label: Tensor, crops: Tensor) -> dict[str, float]:
        """Update the discriminator, its objective divided by 2, then the generator against it (Sec. 3.3)."""
        made = self.gan.generator(photo)  # B, 1, R, C
        real = self.gan.discriminator(torch.cat((photo, picture), 1))[-1:]
        fake = self.gan.discriminator(torch.cat((photo, made.detach()), 1))[-1:]
        loss_d = (adversarial_loss(real, real=True) + adversarial_loss(fake, real=False)) / 2
        self.gan.descend_discriminator(loss_d)
        with self.gan.fixed_discriminator():
            judged = self.gan.discriminator(torch.cat((photo, made), 1))[-1:]
            adversarial, l1 = adversarial_loss(judged, real=True), F.l1_loss(made, picture)
        self.gan.descend_generator(adversarial + self.config.l1 * l1)
        return {"discriminator": loss_d.item(), "adversarial": adversarial.item(), "l1": l1.item()}

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        with torch_seeded(0, "validate"):
            return self.training.validate(examples, self.make)

    def state(self) -> dict[str, Any]:
        return self.training.state()

    def load_state(self, state: Mapping[str, Any]) -> None:
        self.training.load_state(state)

    # -- use ---------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return what the photographed surface feels like, at the training data's level.

        ``seed`` decides which crop of the photograph is seen, what dropout leaves out, and the phase.
        """
        check_condition(condition, needs=("image",))
        with torch_seeded(seed, "dropout"):
            return self.ends.signal(self.make, condition, seconds=seconds, seed=seed)

    @torch.inference_mode()
    def make(self, photo: Tensor) -> Tensor:
        """Return pictures, shape (batch, 1, row, column), of photographs of that shape."""
        made: Tensor = self.gan.bare_generator.eval()(photo.to(self.gan.device))
        return made

    def conditioning(self, photo: Tensor) -> tuple[()]:
        """Return nothing: the generator takes photographs alone."""
        return ()


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> Pix2PixLearner:
    """Return an untrained model for signals of ``kind``."""
    return Pix2PixLearner(config, kind, seed=seed, device=device)

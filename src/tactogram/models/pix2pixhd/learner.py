"""pix2pixHD's global generator as Wang et al. 2018, Sec. 3, train it; from a photograph to a signal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import torch
from torch import Tensor

from tactogram.evaluation.pictures.checkpoint_choice import picture_choice
from tactogram.model import Condition, Example, SignalKind, Stage, check_condition
from tactogram.models.pix2pixhd.config import Config
from tactogram.models.pix2pixhd.networks import discriminator, generator
from tactogram.nn.adversarial_loss import adversarial_loss, feature_matching_loss
from tactogram.nn.adversarial_pair import AdversarialPair
from tactogram.nn.patch_discriminator import scores
from tactogram.nn.perceptual_loss import PerceptualLoss
from tactogram.nn.photo_translation import VARIATION, PhotoTranslation
from tactogram.nn.picture_training import PictureTraining
from tactogram.signal import Signal
from tactogram.training.seeds import torch_seeded


class Pix2PixHDLearner:
    """Residual generator and discriminators at several scales, by least squares and feature matching.

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
    variation = VARIATION

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
        self.perceptual: PerceptualLoss | None = None
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
        if self.config.vgg_weights and self.perceptual is None:  # a finished run needs no file but its own
            self.perceptual = PerceptualLoss(self.config.vgg_weights).to(self.gan.device)
        return self.training.stages(examples)

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        return self.training.batches(stage, examples, seed=seed, start=start)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        return self.training.step(stage, batch, self._update, self.make)

    def _update(self, photo: Tensor, picture: Tensor, label: Tensor, crops: Tensor) -> dict[str, float]:
        """Both networks once, both losses of the weights before either's update, as the authors' code."""
        made = self.gan.generator(photo)  # B, 1, R, C
        real = self.gan.discriminator(torch.cat((photo, picture), 1))
        fake = self.gan.discriminator(torch.cat((photo, made.detach()), 1))
        kind = self.config.adversarial
        loss_d = adversarial_loss(scores(real), real=True, kind=kind)
        loss_d = (loss_d + adversarial_loss(scores(fake), real=False, kind=kind)) / 2
        with self.gan.fixed_discriminator():
            judged = self.gan.discriminator(torch.cat((photo, made), 1))
            adversarial = adversarial_loss(scores(judged), real=True, kind=kind)
            # The authors' code sums over a discriminator's layers with weights 4 / (L + 1).
            matching = 4 * feature_matching_loss(judged, real)
        loss_g = adversarial + self.config.feature_matching * matching
        figures = {"discriminator": loss_d, "adversarial": adversarial, "matching": matching}
        if self.perceptual:
            figures["perceptual"] = self.perceptual.to(made.device)(made, picture)
            loss_g = loss_g + self.config.perceptual * figures["perceptual"]
        self.gan.descend_generator(loss_g)
        self.gan.descend_discriminator(loss_d)
        return {name: value.item() for name, value in figures.items()}

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        return self.training.validate(examples, self.make)

    def state(self) -> dict[str, Any]:
        return self.training.state()

    def load_state(self, state: Mapping[str, Any]) -> None:
        self.training.load_state(state)

    # -- use ---------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return what the photographed surface feels like, at the training data's level.

        The network takes no noise: ``seed`` decides which crop of the photograph it sees, and the phase.
        """
        check_condition(condition, needs=("image",))
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
) -> Pix2PixHDLearner:
    """Return an untrained model for signals of ``kind``."""
    return Pix2PixHDLearner(config, kind, seed=seed, device=device)

"""Residue-Fusion GAN as Neshov et al. 2026, Sec. 2, describe it; from a photograph to a signal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import torch
from torch import Tensor

from tactogram.evaluation.pictures.checkpoint_choice import picture_choice
from tactogram.model import Condition, Example, SignalKind, Stage, check_condition
from tactogram.models.residue_fusion_gan.config import Config
from tactogram.models.residue_fusion_gan.networks import discriminator, generator
from tactogram.nn.adversarial_loss import feature_matching_loss
from tactogram.nn.adversarial_pair import AdversarialPair
from tactogram.nn.bare_and_fixed import bare
from tactogram.nn.gradient_penalty import gradient_penalty
from tactogram.nn.label_predictor import PredictorTraining
from tactogram.nn.perceptual_loss import PerceptualLoss
from tactogram.nn.photo_translation import VARIATION, PhotoTranslation
from tactogram.nn.picture_training import PictureTraining
from tactogram.signal import Image, Signal
from tactogram.training.seeds import torch_seeded


class ResidueFusionLearner:
    """U-Net into which a classifier's feature maps are fused, against one Wasserstein critic.

    Parameters
    ----------
    config : Config
    kind : SignalKind
        Rate, unit, axis and materials of the training signals.
    seed : int
        Decides initial weights, crops and pairs.
    device : str or torch.device
    """

    variation = VARIATION

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        self.config, self.kind, self.materials = config, kind, kind.materials
        self.ends = PhotoTranslation(config.pairs, kind, seed=seed)
        with torch_seeded(seed, "predictor"):
            self.predictor = PredictorTraining(
                config.predictor, len(kind.materials), device=torch.device(device)
            )
        with torch_seeded(seed, "weights"):
            self.gan = AdversarialPair(
                generator(config, self.predictor.bare.trunk.features),
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
            batch_size=config.batch_size * config.critic_updates,
            epochs=config.epochs,
            steps=config.steps,
            choose_every=config.choose_every,
            predictor=self.predictor,
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
        """Gulrajani et al. 2017, Algorithm 1; the generator goes by features and, where there is one, VGG too."""
        figures: dict[str, Tensor] = {}
        size = self.config.batch_size
        for begin in range(0, len(photo), size):
            part = slice(begin, begin + size)
            figures |= self._update_critic(photo[part], picture[part])
        figures |= self._update_generator(photo[:size], picture[:size])
        return {name: value.item() for name, value in figures.items()}

    def _update_critic(self, photo: Tensor, picture: Tensor) -> dict[str, Tensor]:
        with torch.no_grad():
            made = self.gan.generator(photo, self._maps(photo))
        real = self.gan.discriminator(torch.cat((photo, picture), 1))[-1].mean()
        fake = self.gan.discriminator(torch.cat((photo, made), 1))[-1].mean()
        with self.gan.autocast():  # Fabric's wrapper lets no gradient be taken but by its own backward
            critic = bare(self.gan.discriminator)
            penalty = gradient_penalty(
                lambda x: critic(torch.cat((photo, x), 1))[-1].float().mean((1, 2, 3)), picture, made.float()
            )
        self.gan.descend_discriminator(fake - real + self.config.penalty * penalty)
        return {"wasserstein": real - fake, "penalty": penalty}

    def _update_generator(self, photo: Tensor, picture: Tensor) -> dict[str, Tensor]:
        made = self.gan.generator(photo, self._maps(photo))  # B, 1, R, C
        with self.gan.fixed_discriminator():
            with torch.no_grad():
                real = self.gan.discriminator(torch.cat((photo, picture), 1))
            judged = self.gan.discriminator(torch.cat((photo, made), 1))
            figures = {"adversarial": -judged[-1].mean(), "matching": feature_matching_loss([judged], [real])}
        loss = figures["adversarial"] + self.config.feature_matching * figures["matching"]
        if self.perceptual:
            figures["perceptual"] = self.perceptual.to(made.device)(made, picture)
            loss = loss + self.config.perceptual * figures["perceptual"]
        self.gan.descend_generator(loss)
        return figures

    @torch.no_grad()
    def _maps(self, photo: Tensor) -> Tensor:
        """Return the classifier's feature maps, shape (batch, feature, row, column); it is not trained any more."""
        network = self.predictor.bare.eval()
        maps: Tensor = network.trunk.maps(photo)
        return maps

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

    def classify_photograph(self, image: Image) -> tuple[str, float]:
        """Return the material that the classifier takes a photograph for, and its probability."""
        probabilities = self.training.named(image)
        place = int(probabilities.argmax())
        return self.materials[place], probabilities[place].item()

    @torch.inference_mode()
    def make(self, photo: Tensor) -> Tensor:
        """Return pictures, shape (batch, 1, row, column), of photographs of that shape."""
        photo = photo.to(self.gan.device)
        made: Tensor = self.gan.bare_generator.eval()(photo, *self.conditioning(photo))
        return made

    def conditioning(self, photo: Tensor) -> tuple[Any, ...]:
        """Return what the generator is given beside photographs: the classifier's maps of them."""
        return (self._maps(photo.to(self.gan.device)),)


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> ResidueFusionLearner:
    """Return an untrained model for signals of ``kind``."""
    return ResidueFusionLearner(config, kind, seed=seed, device=device)

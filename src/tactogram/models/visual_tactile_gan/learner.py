"""Label predictor, then GAN, as in Neshov et al. 2026, Sec. 3; from a photograph to a signal.

References
----------
- De Vries, H. et al. (2017). Modulating early visual processing by language. NeurIPS 30.
- Neshov, N. et al. (2026). Visual-to-tactile cross-modal generation … Sensors 26, 426. Sec. 3.1.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor, nn

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.distances import picture_choice
from tactogram.model import Condition, Example, SignalKind, Stage, check_condition, material_weights
from tactogram.models.visual_tactile_gan.config import Config
from tactogram.nn.adversarial_networks import adversarial_loss, feature_matching_loss
from tactogram.nn.initial_weights import normal_
from tactogram.nn.patch_discriminator import MultiScaleDiscriminator, scores
from tactogram.nn.unet import UNet
from tactogram.signal import Image, Signal
from tactogram.signal.band_levels import BandLevels
from tactogram.training.picture_learner import VARIATION, PictureLearner
from tactogram.training.seeds import child_seed

MATCHED = 12
"""Most recordings of a material that bands are matched to."""


class ConditionalBatchNorm(nn.Module):
    """``gamma(y) (x - mu) / sigma + beta(y)`` with ``gamma(y) = y Wg + bg`` and ``beta(y) = y Wb + bb``.

    mu and sigma are those of each channel over the batch and all places; in use, the running ones of training.
    ``channels`` is the paper's F, ``labels`` its C. Initial weights of the label are from N(0, ``gain``), bg = 1 and
    bb = 0: with a small gain it starts as plain batch normalisation.
    """

    def __init__(self, channels: int, labels: int, *, gain: float = 0.02) -> None:
        super().__init__()
        self.norm = nn.BatchNorm2d(channels, affine=False)
        self.scale = nn.Linear(labels, channels)
        self.shift = nn.Linear(labels, channels)
        nn.init.normal_(self.scale.weight, 0, gain)
        nn.init.ones_(self.scale.bias)
        nn.init.normal_(self.shift.weight, 0, gain)
        nn.init.zeros_(self.shift.bias)

    def forward(self, x: Tensor, label: Tensor) -> Tensor:
        """Return ``x``, (batch, channel, row, column), normalised, scaled and shifted.

        ``label``, (batch, C), is one-hot, or weights of several classes, of which scale and shift are weighted means.
        """
        gamma, beta = self.scale(label), self.shift(label)  # B, F
        normal: Tensor = self.norm(x)
        return torch.addcmul(beta[..., None, None], gamma[..., None, None], normal)


def generator(config: Config, labels: int) -> UNet:
    """Return the U-Net: (batch, 1, 256, 256) down to (batch, 512, 1, 1) and back up; ``labels`` is the paper's C."""
    bottleneck = None
    if config.conditional:
        bottleneck = ConditionalBatchNorm(config.widths[-1], labels, gain=config.label_gain)
    network = UNet(into=1, out=1, widths=config.widths, bottleneck=bottleneck)
    normal_(network, config.gain)
    return network


def discriminator(config: Config) -> nn.Module:
    """Return the PatchGANs, each at half the resolution of the last, of photograph and picture as channels."""
    network = MultiScaleDiscriminator(
        count=config.discriminators, into=2, layers=config.layers, width=config.width
    )
    normal_(network, config.gain)
    return network


class VisualTactileLearner(PictureLearner[Config]):
    """Photograph to spectrogram picture, conditioned on the predicted material of the surface."""

    variation = VARIATION
    saved = (*PictureLearner.saved, "bands")
    choice = staticmethod(picture_choice)

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        predictor = config.predictor if config.conditional else None
        super().__init__(config, kind, seed=seed, device=device, predictor=predictor)
        self.labels: dict[int, Tensor] = {}
        """Predicted label of each crop of the training photographs."""
        self.bands = BandLevels(kind.rate) if config.match_bands else None

    def networks(self) -> tuple[UNet, nn.Module]:
        return generator(self.config, len(self.materials)), discriminator(self.config)

    def update(self, photo: Tensor, picture: Tensor, label: Tensor, crops: Tensor) -> dict[str, float]:
        """Update both networks; as in pix2pixHD, both losses are of the weights before either update."""
        config = self.config
        labels = self._training_labels(photo, label, crops)  # B, classes
        generated = self.gan.generator(photo, labels)  # B, 1, R, C
        real = self.gan.discriminator(torch.cat((photo, picture), 1))
        fake = self.gan.discriminator(torch.cat((photo, generated.detach()), 1))
        loss_d = adversarial_loss(scores(real), real=True) + adversarial_loss(scores(fake), real=False)
        with self.gan.fixed_discriminator():
            outputs = self.gan.discriminator(torch.cat((photo, generated), 1))
            adversarial = adversarial_loss(scores(outputs), real=True)
            matching = feature_matching_loss(outputs, real)
            l1 = F.l1_loss(generated, picture)
        self.gan.descend(0, adversarial + config.l1 * l1 + config.feature_matching * matching)
        self.gan.descend(1, loss_d)
        figures = {"discriminator": loss_d, "adversarial": adversarial, "l1": l1, "matching": matching}
        return {name: value.item() for name, value in figures.items()}

    def _training_labels(self, photo: Tensor, true: Tensor, crops: Tensor) -> Tensor:
        """Return labels, shape (batch, class): true, or predicted once for each crop."""
        if self.predictor is None or self.config.label == "true":
            return F.one_hot(true, len(self.materials)).float().to(photo)
        new = [number for number, crop in enumerate(crops.tolist()) if crop not in self.labels]
        if new:
            for index, label in zip(new, self._predicted(photo[new]), strict=True):
                self.labels[int(crops[index])] = label
        return torch.stack([self.labels[crop] for crop in crops.tolist()])

    def _predicted(self, photo: Tensor) -> Tensor:
        """Return the predicted label of each photograph, one-hot, or the probabilities if configured.

        Shape (batch, class); 0 without a predictor.
        """
        if self.predictor is None:
            return torch.zeros(len(photo), len(self.materials))
        return self._condition_of(self.predictor.probabilities(photo))

    def _condition_of(self, probabilities: Tensor) -> Tensor:
        """Return the generator's condition of predicted probabilities, both of shape (batch, class)."""
        if self.config.label == "probabilities":
            return probabilities
        return F.one_hot(probabilities.argmax(1), len(self.materials)).float()

    def conditioning(self, photo: Tensor) -> tuple[Tensor]:
        """Return the predicted labels of photographs, shape (batch, class)."""
        return (self._predicted(photo),)

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        stages = super().stages(examples)
        return (*stages, Stage("match", 1)) if self.bands else stages

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name == "match":
            return iter([examples])
        return super().batches(stage, examples, seed=seed, start=start)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name != "match" or self.bands is None:
            return super().step(stage, batch)
        materials = enumerate(self.kind.by_material(batch).items())
        self.bands.measure(self._to_match(self.bands, index, *members) for index, members in materials)
        return {"band_correction_db": self.bands.correction_db()}

    def _to_match(
        self, levels: BandLevels, index: int, name: str, examples: Sequence[Example]
    ) -> tuple[list[NDArray[np.float32]], list[NDArray[np.float32]]]:
        """Return recordings of a material, (axis, time), and for each a signal of one of its photographs."""
        shortest = 2 * levels.reach + 1
        some = [e for e in examples if len(e.signal) >= shortest][:MATCHED]
        if not some:
            raise ParameterError(
                f"match_bands needs recordings of {name} of at least {shortest / self.kind.rate:.3g} s"
            )
        generated = []
        for number, example in enumerate(some):
            photographs = example.photographs
            condition = {"image": photographs[number % len(photographs)], "material": name}
            seconds = len(example.signal) / self.kind.rate
            seed = child_seed(0, "match", index, number)
            generated.append(self._unmatched(condition, seconds, seed=seed).samples)
        return [e.signal.samples for e in some], generated

    def load_state(self, state: Mapping[str, Any]) -> None:
        super().load_state(state)
        self.labels = {}

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return the vibration of the photographed surface, at the level of the training data.

        ``seed`` decides the crop of the photograph and the recovered phase. The label is the predicted one (or the
        probabilities, by ``config.label``), unless ``material`` gives another: a name, or weights, which are scaled
        to sum to 1.
        """
        check_condition(condition, needs=("image",), takes=("material",))
        if self.bands is None or not self.bands.measured:
            return self._unmatched(condition, seconds, seed=seed)
        if condition.get("material") is None:
            condition = {**condition, "material": self.classify_photograph(condition["image"])[0]}
        # The band filters shorten a signal by their reach at both ends.
        length = self.translation.seconds if seconds is None else seconds
        longer = self._unmatched(condition, length + 2 * self.bands.reach / self.kind.rate, seed=seed)
        matched = self.bands.apply(longer.samples, material_weights(condition, self.materials))
        return longer.with_samples(matched[:, : round(length * self.kind.rate)].astype(np.float32))

    def _unmatched(self, condition: Condition, seconds: float | None, *, seed: int) -> Signal:
        label = self._label(condition)
        return self.translation.signal(
            lambda photo: self._generated(photo, label), condition, seconds=seconds, seed=seed
        )

    def _label(self, condition: Condition) -> Tensor:
        """Return the generator's label, shape (1, class)."""
        if self.predictor is None:
            if condition.get("material") is not None:
                raise ParameterError("a run without conditional batch norm takes no material: omit it")
            return torch.zeros(1, len(self.materials))
        if condition.get("material") is None:
            return self._condition_of(self.probabilities_of(condition["image"])[None])
        weights = material_weights(condition, self.materials)
        return torch.from_numpy(weights / weights.sum()).float()[None]

    def classify_photograph(self, image: Image) -> tuple[str, float]:
        """Return the predicted material of a photograph and its probability.

        An unknown surface is classified, too, often with a high probability.
        """
        return self._classified(image)


build = VisualTactileLearner

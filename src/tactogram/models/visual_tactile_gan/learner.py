"""The label predictor, then the GAN, as Sec. 3 of Neshov et al. 2026 has it; from a photograph to a signal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.checkpoint_choice import picture_choice
from tactogram.model import Condition, Example, SignalKind, Stage, check_condition, material_weights
from tactogram.models.visual_tactile_gan.config import Config
from tactogram.models.visual_tactile_gan.networks import discriminator, generator
from tactogram.nn.adversarial_loss import adversarial_loss, feature_matching_loss
from tactogram.nn.adversarial_pair import AdversarialPair
from tactogram.nn.label_predictor import PredictorTraining
from tactogram.nn.patch_discriminator import scores
from tactogram.nn.photo_translation import VARIATION, PhotoTranslation
from tactogram.nn.picture_training import PictureTraining
from tactogram.signal import Image, Signal
from tactogram.signal.band_levels import BandLevels
from tactogram.training.seeds import child_seed, torch_seeded

MATCHED = 12
"""Recordings of a material, at most, that bands are matched to."""


class VisualTactileLearner:
    """Photograph in, spectrogram picture out; the label predictor says what surface it is.

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
        with torch_seeded(seed, "weights"):
            self.gan = AdversarialPair(
                generator(config, len(kind.materials)),
                discriminator(config),
                learning_rate=config.learning_rate,
                betas=config.betas,
                device=torch.device(device),
                constant=config.constant,
            )
        self.predictor: PredictorTraining | None = None
        if config.conditional:
            with torch_seeded(seed, "predictor"):
                self.predictor = PredictorTraining(
                    config.predictor, len(kind.materials), device=torch.device(device)
                )
        self.training = PictureTraining(
            self.ends,
            self.gan,
            batch_size=config.batch_size,
            epochs=config.epochs,
            steps=config.steps,
            choose_every=config.choose_every,
            predictor=self.predictor,
        )
        self.labels: dict[int, Tensor] = {}
        self.bands = BandLevels(kind.rate) if config.match_bands else None

    def setup(self, fabric: Any) -> None:
        self.training.setup(fabric)

    def set_validation(self, examples: Sequence[Example]) -> str:
        """Choose weights by ``examples``, which are not trained on; return a note if not by the distance asked for."""
        choice = picture_choice(self.config.choose_by, self.config.lpips_weights)
        self.training.watch(examples, choice.name, choice.distance)
        return choice.note

    # -- training ----------------------------------------------------------------------------------------

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        stages = self.training.stages(examples)
        return (*stages, Stage("match", 1)) if self.bands else stages

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name == "match":
            return iter([examples])
        return self.training.batches(stage, examples, seed=seed, start=start)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "match" and self.bands:
            return self._match(batch, self.bands)
        return self.training.step(stage, batch, self._update, self.make)

    def _update(self, photo: Tensor, picture: Tensor, true: Tensor, crops: Tensor) -> dict[str, float]:
        """Both networks once; as in pix2pixHD, both losses are of the weights before either's update."""
        config = self.config
        label = self._training_label(photo, true, crops)  # B, classes
        made = self.gan.generator(photo, label)  # B, 1, R, C
        real = self.gan.discriminator(torch.cat((photo, picture), 1))
        fake = self.gan.discriminator(torch.cat((photo, made.detach()), 1))
        loss_d = adversarial_loss(scores(real), real=True) + adversarial_loss(scores(fake), real=False)
        with self.gan.fixed_discriminator():
            judged = self.gan.discriminator(torch.cat((photo, made), 1))
            adversarial = adversarial_loss(scores(judged), real=True)
            matching = feature_matching_loss(judged, real)
            l1 = F.l1_loss(made, picture)
        self.gan.descend_generator(adversarial + config.l1 * l1 + config.feature_matching * matching)
        self.gan.descend_discriminator(loss_d)
        figures = {"discriminator": loss_d, "adversarial": adversarial, "l1": l1, "matching": matching}
        return {name: value.item() for name, value in figures.items()}

    def _training_label(self, photo: Tensor, true: Tensor, crops: Tensor) -> Tensor:
        """Return labels, shape (batch, class): what the predictor says of each crop, once for all, or the truth."""
        if self.predictor is None or self.config.label == "true":
            return F.one_hot(true, len(self.materials)).float().to(photo)
        new = [place for place, crop in enumerate(crops.tolist()) if crop not in self.labels]
        if new:
            for place, label in zip(new, self._predicted(photo[new]), strict=True):
                self.labels[int(crops[place])] = label
        return torch.stack([self.labels[crop] for crop in crops.tolist()])

    def _predicted(self, photo: Tensor) -> Tensor:
        """Return the predictor's word on each photograph, one-hot, shape (batch, class)."""
        if self.predictor is None:
            return torch.zeros(len(photo), len(self.materials))
        named = self.predictor.probabilities(photo).argmax(1)
        return F.one_hot(named, len(self.materials)).float()

    def _match(self, examples: Sequence[Example], levels: BandLevels) -> dict[str, float]:
        """Measure the bands of recordings, and of signals of their photographs, by label."""
        materials = self.kind.by_material(examples).items()
        levels.measure(self._beside(levels, place, *held) for place, held in enumerate(materials))
        return {"band_correction_db": levels.correction_db()}

    def _beside(
        self, levels: BandLevels, place: int, name: str, examples: Sequence[Example]
    ) -> tuple[list[NDArray[np.float32]], list[NDArray[np.float32]]]:
        """Return recordings of a material, (axis, time), and a signal beside each of one of its photographs."""
        shortest = 2 * levels.reach + 1
        some = [e for e in examples if len(e.signal) >= shortest][:MATCHED]
        if not some:
            raise ParameterError(
                f"match_bands needs recordings of {name} of at least {shortest / self.kind.rate:.3g} s"
            )
        made = []
        for number, example in enumerate(some):
            photographs = example.photographs
            condition = {"image": photographs[number % len(photographs)], "material": name}
            seconds = len(example.signal) / self.kind.rate
            seed = child_seed(0, "match", place, number)
            made.append(self._unmatched(condition, seconds, seed=seed).samples)
        return [e.signal.samples for e in some], made

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        return self.training.validate(examples, self.make)

    def state(self) -> dict[str, Any]:
        return self.training.state() | {"bands": self.bands.state() if self.bands else None}

    def load_state(self, state: Mapping[str, Any]) -> None:
        self.training.load_state(state)
        if self.bands:
            self.bands.load_state(state["bands"])
        self.labels = {}

    # -- use ---------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return what the photographed surface feels like, at the training data's level.

        The network takes no noise: ``seed`` decides which crop of the photograph it sees, and the phase. The label is
        the predicted one (see `classify_photograph`), unless ``material`` gives it: a name, or weights, which are
        scaled to sum to 1.
        """
        check_condition(condition, needs=("image",), takes=("material",))
        if self.bands is None or not self.bands.measured:
            return self._unmatched(condition, seconds, seed=seed)
        if condition.get("material") is None:
            condition = {**condition, "material": self.classify_photograph(condition["image"])[0]}
        # The filters of the bands eat their reach at both ends.
        length = self.ends.seconds if seconds is None else seconds
        longer = self._unmatched(condition, length + 2 * self.bands.reach / self.kind.rate, seed=seed)
        matched = self.bands.apply(longer.samples, material_weights(condition, self.materials))
        return longer.with_samples(matched[:, : round(length * self.kind.rate)].astype(np.float32))

    def _unmatched(self, condition: Condition, seconds: float | None, *, seed: int) -> Signal:
        label = self._label(condition)
        return self.ends.signal(lambda photo: self._made(photo, label), condition, seconds=seconds, seed=seed)

    def classify_photograph(self, image: Image) -> tuple[str, float]:
        """Return the material that a photograph is taken for, and the probability the predictor gives it.

        Both from the mean over several crops. A surface that was never trained on is named all the same: a low
        probability is the only sign of it.

        Raises
        ------
        ParameterError
            If the run has no label predictor, or the photograph is smaller than a crop.
        """
        probabilities = self.training.named(image)
        place = int(probabilities.argmax())
        return self.materials[place], probabilities[place].item()

    def _label(self, condition: Condition) -> Tensor:
        """Return what conditions the generator, shape (1, class)."""
        if self.predictor is None:
            if condition.get("material") is not None:
                raise ParameterError("a run without conditional batch norm takes no material: leave it out")
            return torch.zeros(1, len(self.materials))
        if condition.get("material") is None:
            condition = {"material": self.classify_photograph(condition["image"])[0]}
        weights = material_weights(condition, self.materials)
        return torch.from_numpy(weights / weights.sum()).float()[None]

    def make(self, photo: Tensor) -> Tensor:
        """Return pictures, shape (batch, 1, row, column), of photographs of that shape, by their predicted labels."""
        return self._made(photo, *self.conditioning(photo))

    def conditioning(self, photo: Tensor) -> tuple[Tensor]:
        """Return what the generator is given beside photographs: their predicted labels, shape (batch, class)."""
        return (self._predicted(photo),)

    @torch.inference_mode()
    def _made(self, photo: Tensor, label: Tensor) -> Tensor:
        device = self.gan.device
        made: Tensor = self.gan.bare_generator.eval()(photo.to(device), label.to(device))
        return made


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> VisualTactileLearner:
    """Return an untrained model for signals of ``kind``."""
    return VisualTactileLearner(config, kind, seed=seed, device=device)

"""Learner of GANs that turn photographs into spectrogram pictures: signal levels, label predictor if any, GAN."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import count
from typing import Annotated, Any, ClassVar, Generic, TypeVar

import torch
from pydantic import Field
from torch import Tensor, nn

from tactogram.errors import ParameterError
from tactogram.features.photo_pairs import WeakPairs, shuffled
from tactogram.model import (
    Condition,
    Example,
    Model,
    ModelConfig,
    SignalKind,
    Stage,
    check_condition,
)
from tactogram.nn.adversarial_networks import AdversarialPair
from tactogram.nn.label_predictor import PredictorConfig, PredictorTraining
from tactogram.nn.photo_translation import DistanceName, PairConfig, PhotoTranslation
from tactogram.signal import Image, Signal
from tactogram.training.seeds import torch_seeded

Beta = Annotated[float, Field(ge=0, lt=1)]

VARIATION = (
    "the crop of the photograph and the phase, or noise, of the signal; the network itself takes no noise"
)
"""`Model.variation` of the models whose generator draws no noise."""
VIEWS = 5
"""Crops of a photograph whose mean probabilities classify it."""


class PictureConfig(ModelConfig):
    """Settings that these models share; numbers with their place in Neshov et al. 2026."""

    pairs: PairConfig = PairConfig()
    """Photographs, pictures and how they are paired: the same for all models compared in Neshov et al., Sec. 4.1."""
    batch_size: int = Field(default=32, gt=1)
    """Neshov et al., Sec. 3.2."""
    learning_rate: float = Field(default=2e-4, gt=0, allow_inf_nan=False)
    """Of Adam. Neshov et al., Sec. 3.2."""
    betas: tuple[Beta, Beta] = (0.5, 0.999)
    """Of Adam. Neshov et al., Sec. 3.2."""
    epochs: int = Field(default=200, gt=0)
    """Over all pairs. Neshov et al., Sec. 3.2."""
    constant: float = Field(default=0.5, ge=0, le=1)
    """Share of the training before the learning rate falls linearly to 0. Neshov et al., Sec. 3.2: the first 100 of
    200 epochs."""
    steps: int | None = Field(default=None, gt=0)
    """Steps, instead of ``epochs``. Ours."""
    choose_every: int | None = Field(default=None, gt=0)
    """Steps between measurements on the validation part; None: once per epoch. Neshov et al., Sec. 3.2, "monitored …
    during training"."""
    choose_by: DistanceName = "lpips"
    """Distance that weights are chosen by. Neshov et al., Sec. 3.2: LPIPS. ``row_statistics``, for short trainings,
    also replaces LPIPS where its weights are missing; the run's state says which was used."""
    lpips_weights: str = ""
    """File of AlexNet's weights; if empty, torch's cache is searched."""

    @property
    def window_protocol(self) -> str:
        """Protocol that splits crops of the training data; empty if recordings are split."""
        return self.pairs.window_protocol


ConfigT = TypeVar("ConfigT", bound=PictureConfig)


class PictureLearner(Model, Generic[ConfigT]):
    """Pairs, stages, validation, state and generated signals; a model adds `networks` and `update`.

    ``seed`` decides initial weights, crops and pairs; ``predictor`` is a label predictor trained before the GAN.
    """

    config: ConfigT
    kind: SignalKind
    divides_batches = True
    saved: ClassVar[tuple[str, ...]] = ("materials", "ends=translation", "gan", "predictor")

    def __init__(
        self,
        config: ConfigT,
        kind: SignalKind,
        *,
        seed: int,
        device: str | torch.device = "cpu",
        predictor: PredictorConfig | None = None,
    ) -> None:
        super().__init__(config, kind, seed=seed, device=device)
        self.translation = PhotoTranslation(config.pairs, kind, seed=seed)
        self.predictor: PredictorTraining | None = None
        if predictor:
            with torch_seeded(seed, "predictor"):
                self.predictor = PredictorTraining(
                    predictor, len(kind.materials), device=torch.device(device)
                )
        with torch_seeded(seed, "weights"):
            self.gan = AdversarialPair(
                *self.networks(),
                learning_rate=config.learning_rate,
                betas=config.betas,
                device=torch.device(device),
                constant=config.constant,
            )
        self.validation_examples: Sequence[Example] = ()
        self.training_examples: Sequence[Example] = ()

    def networks(self) -> tuple[nn.Module, nn.Module]:
        """Return generator and discriminator with initial weights from torch's own generator."""
        raise NotImplementedError

    @staticmethod
    def choice(by: DistanceName, weights: str = "") -> Any:
        """Return a `PictureChoice`: `picture_choice` of evaluation, which this layer does not import."""
        raise NotImplementedError

    def update(self, photo: Tensor, picture: Tensor, label: Tensor, crops: Tensor) -> dict[str, float]:
        """Update both networks and return the losses.

        Photographs and pictures have shape (batch, 1, row, column), -1 to 1; true labels and the numbers of the
        photographs' crops have shape (batch,).
        """
        raise NotImplementedError

    @property
    def pairs_per_step(self) -> int:
        """Pairs that one `update` takes."""
        return self.config.batch_size

    @property
    def omitted(self) -> str:
        """Loss that the training does without for want of weights, one line; none by default."""
        return ""

    def conditioning(self, photo: Tensor) -> tuple[Tensor, ...]:
        """Return the generator's further inputs for photographs, (batch, 1, row, column); none by default."""
        return ()

    def parts(self) -> Sequence[Any]:
        """Return the GAN, and the label predictor if there is one."""
        return [self.gan, self.predictor] if self.predictor else [self.gan]

    def set_validation(self, examples: Sequence[Example]) -> str:
        """Choose the predictor's weights by accuracy on ``examples``, the generator's by `choice`."""
        choice = self.choice(self.config.choose_by, self.config.lpips_weights)
        self.validation_examples = examples
        self.translation.unseen(examples)  # refuses unusable examples now, not after the first epoch
        self.gan.chosen_by, self.gan.distance = choice.name, choice.distance
        return "; ".join(note for note in (choice.note, self.omitted) if note)

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        """Return ``fit``, ``label predictor`` if there is one, and ``gan``; loads the trunk's weights.

        Refuses, before any training, examples and picture sizes that the networks cannot take.
        """
        size = self.config.pairs.size
        self.gan.bare_generator.check_size(size, size)  # type: ignore[operator]
        self.translation.check(examples)
        self.training_examples = examples
        self.unseen(self.validation_examples)
        steps = self.config.steps or self.config.epochs * self._steps_per_epoch(examples)
        stages = [Stage("fit", 1), Stage("gan", steps)]
        if self.predictor:
            self.predictor.bare.trunk.load()
            epoch = self.predictor.steps_per_epoch(self.translation.pairs(examples))
            stages.insert(1, Stage("label predictor", self.predictor.config.epochs * epoch))
        return tuple(stages)

    def unseen(self, examples: Sequence[Example]) -> WeakPairs | None:
        """Return the validation pairs of ``examples``; None if there are none.

        Where the protocol splits crops and there are no validation examples, those are crops of the training examples
        that are not trained on: the paper's validation part.
        """
        within = not len(examples) and self.config.window_protocol
        return self.translation.unseen(self.training_examples if within else examples)

    def _steps_per_epoch(self, examples: Sequence[Example]) -> int:
        return -(-len(self.translation.pairs(examples)) // self.pairs_per_step)

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        """Yield the batches of ``stage``."""
        if stage.name == "fit":
            yield examples
        elif stage.name == "label predictor" and self.predictor:
            pairs = self.translation.pairs(examples)
            yield from self.predictor.batches(pairs, seed=seed, start=start, share=self.share)
        else:
            every = self.config.choose_every or self._steps_per_epoch(examples)
            pairs, size = self.translation.pairs(examples), self.pairs_per_step
            for number in count(start):
                places = shuffled(len(pairs), size, number, seed=seed)
                batch = self.translation.batch(pairs, self.share.places(places, self.config.batch_size))
                yield number, *batch, every

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        """Do one step of ``stage``."""
        if stage.name == "fit":
            return self.translation.fit(batch)
        number, last = batch[0], batch[0] + 1 == stage.steps
        if stage.name == "label predictor" and self.predictor:
            epoch = stage.steps // self.predictor.config.epochs
            unseen = self.unseen(self.validation_examples)
            figures = self.predictor.step(batch, epoch_steps=epoch, unseen=unseen)
            if last:
                self.predictor.settle()
            return figures
        _, photo, picture, label, crops, every = batch
        self.gan.train(number / stage.steps)
        figures = self.update(photo.to(self.gan.device), picture.to(self.gan.device), label, crops)
        if last or (number + 1) % every == 0:
            figures |= self.gan.choose(self.make, self.unseen(self.validation_examples))
        if last:
            self.gan.settle()
        return figures

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return the distance of pictures of unseen photographs, and the accuracy of their labels."""
        pairs = self.unseen(examples)
        if pairs is None:
            return {}
        figures = {f"{self.gan.chosen_by}_unseen": self.gan.validation_distance(self.make, pairs)}
        if self.predictor:
            figures["label_accuracy_unseen"] = self.predictor.accuracy(pairs)
        return figures

    def state(self) -> dict[str, Any]:
        """Return the full state, with the distance that weights were chosen by and the trunk's name."""
        return super().state() | {"trunk": self.predictor.config.trunk if self.predictor else None}

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return the vibration of the photographed surface, at the level of the training data.

        ``seed`` decides the crop of the photograph, the recovered phase and whatever noise the generator draws.
        """
        check_condition(condition, needs=("image",))
        return self.translation.signal(self.make, condition, seconds=seconds, seed=seed)

    @torch.inference_mode()
    def make(self, photo: Tensor) -> Tensor:
        """Return pictures, shape (batch, 1, row, column), of photographs of that shape."""
        return self._generated(photo, *self.conditioning(photo.to(self.gan.device)))

    @torch.inference_mode()
    def _generated(self, *inputs: Tensor) -> Tensor:
        picture: Tensor = self.gan.bare_generator.eval()(*(part.to(self.gan.device) for part in inputs))
        return picture

    def probabilities_of(self, image: Image) -> Tensor:
        """Return the predicted probabilities of a photograph's labels, shape (class,), the mean over `VIEWS` crops.

        Raises `ParameterError` if the run has no label predictor, or the photograph is smaller than a crop.
        """
        if self.predictor is None:
            raise ParameterError("this run has no label predictor and cannot classify photographs")
        crops = [self.translation.photo({"image": image}, number, seed=0) for number in range(VIEWS)]
        return self.predictor.probabilities(torch.cat(crops)).mean(0).cpu()

    def _classified(self, image: Image) -> tuple[str, float]:
        """Return the predicted material of a photograph and its probability; errors of `probabilities_of`."""
        probabilities = self.probabilities_of(image)
        index = int(probabilities.argmax())
        return self.materials[index], probabilities[index].item()

"""The label predictor, then the GAN, as Sec. 3 of Neshov et al. 2026 has it; from a photograph to a signal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import torch
import torch.nn.functional as F
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.model import Condition, Example, SignalKind, Stage, check_condition, material_weights
from tactogram.models.visual_tactile_gan.config import Config
from tactogram.models.visual_tactile_gan.networks import discriminator, generator
from tactogram.nn.adversarial_loss import adversarial_loss, feature_matching_loss
from tactogram.nn.adversarial_pair import AdversarialPair
from tactogram.nn.label_predictor import PredictorTraining
from tactogram.nn.patch_discriminator import scores
from tactogram.nn.photo_translation import PhotoTranslation
from tactogram.signal import Image, Signal
from tactogram.training.seeds import torch_seeded

VIEWS = 5
"""Crops of a photograph whose mean names it."""


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

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        self.config, self.kind, self.materials = config, kind, kind.materials
        self.ends = PhotoTranslation(config.pairs, kind, seed=seed)
        self.device = torch.device(device)
        with torch_seeded(seed, "weights"):
            self.gan = AdversarialPair(
                generator(config, len(kind.materials)),
                discriminator(config),
                learning_rate=config.learning_rate,
                betas=config.betas,
                device=self.device,
                constant=config.constant,
            )
        with torch_seeded(seed, "predictor"):
            self.predictor = (
                PredictorTraining(config.predictor, len(kind.materials), device=self.device)
                if config.conditional
                else None
            )
        self.labels: dict[int, Tensor] = {}
        self.watched: Sequence[Example] = ()

    def setup(self, fabric: Any) -> None:
        self.gan.setup(fabric)
        if self.predictor:
            self.predictor.setup(fabric)
        self.device = fabric.device

    def watch(self, examples: Sequence[Example]) -> None:
        """Choose weights by ``examples``, which are not trained on: by accuracy, then by distance of pictures."""
        self.watched = examples

    # -- training ----------------------------------------------------------------------------------------

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        self.ends.check(examples)
        pairs = self.ends.pairs(examples)
        steps = self.config.steps or self.config.epochs * self._epoch(examples)
        if self.predictor is None:
            return Stage("fit", 1), Stage("gan", steps)
        self.predictor.bare.trunk.load()
        labels = self.config.predictor.epochs * self.predictor.steps_per_epoch(pairs)
        return Stage("fit", 1), Stage("label predictor", labels), Stage("gan", steps)

    def _epoch(self, examples: Sequence[Example]) -> int:
        return -(-len(self.ends.pairs(examples)) // self.config.batch_size)

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if stage.name == "fit":
            yield examples
        elif stage.name == "label predictor" and self.predictor:
            yield from self.predictor.batches(self.ends.pairs(examples), seed=seed, start=start)
        else:
            every = self.config.choose_every or self._epoch(examples)
            for batch in self.ends.batches(examples, size=self.config.batch_size, seed=seed, start=start):
                yield *batch, every

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "fit":
            return self.ends.fit(batch)
        number, last = batch[0], batch[0] + 1 == stage.steps
        if stage.name == "label predictor" and self.predictor:
            figures = self.predictor.step(
                batch,
                epoch_steps=stage.steps // self.config.predictor.epochs,
                unseen=self.ends.unseen(self.watched),
            )
            if last:
                self.predictor.settle()
            return figures
        _, photo, picture, true, crops, every = batch
        self.gan.train(number / stage.steps)
        label = self._training_label(photo, true, crops)
        figures = self._update(photo.to(self.device), picture.to(self.device), label)
        if last or (number + 1) % every == 0:
            figures |= self.gan.choose(self._make_by_photo, self.ends.unseen(self.watched))
        if last:
            self.gan.settle()
        return figures

    def _update(self, photo: Tensor, picture: Tensor, label: Tensor) -> dict[str, float]:
        """Both networks once; as in pix2pixHD, both losses are of the weights before either's update."""
        config = self.config
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
            return F.one_hot(true, len(self.materials)).float().to(self.device)
        new = [place for place, crop in enumerate(crops.tolist()) if crop not in self.labels]
        if new:
            for place, label in zip(new, self._predicted(photo[new]), strict=True):
                self.labels[int(crops[place])] = label
        return torch.stack([self.labels[crop] for crop in crops.tolist()]).to(self.device)

    def _predicted(self, photo: Tensor) -> Tensor:
        """Return the predictor's word on each photograph, one-hot, shape (batch, class)."""
        if self.predictor is None:
            return torch.zeros(len(photo), len(self.materials))
        named = self.predictor.probabilities(photo).argmax(1)
        return F.one_hot(named, len(self.materials)).float()

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return how often unseen photographs are named rightly, and how far their pictures are from real ones."""
        pairs = self.ends.unseen(examples)
        if pairs is None:
            return {}
        figures = {f"{self.gan.chosen_by}_unseen": self.gan.judge(self._make_by_photo, pairs)}
        if self.predictor:
            figures["label_accuracy_unseen"] = self.predictor.accuracy(pairs)
        return figures

    def state(self) -> dict[str, Any]:
        return {
            "materials": list(self.materials),
            "ends": self.ends.state(),
            "gan": self.gan.state(),
            "trunk": self.config.predictor.trunk if self.predictor else None,
            "predictor": self.predictor.state() if self.predictor else None,
            "optimisers": {
                "gan": self.gan.optimiser_state(),
                "predictor": self.predictor.optimiser.state_dict() if self.predictor else None,
            },
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        if tuple(state["materials"]) != self.materials:
            raise ParameterError(
                f"state is of {', '.join(state['materials'])}; expected {', '.join(self.materials)}"
            )
        optimisers = state.get("optimisers") or {}
        self.ends.load_state(state["ends"])
        self.gan.load_state(state["gan"], optimisers.get("gan"))
        self.labels = {}
        if self.predictor:
            self.predictor.load_state(state["predictor"])
            if optimisers.get("predictor"):
                self.predictor.optimiser.load_state_dict(optimisers["predictor"])

    # -- use ---------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return what the photographed surface feels like, at the training data's level.

        The network takes no noise: ``seed`` decides which crop of the photograph it sees, and the phase. The label is
        the predicted one (`label_of` says which, and how surely), unless ``material`` gives it: a name, or weights,
        which are scaled to sum to 1.
        """
        check_condition(condition, needs=("image",), takes=("material",))
        label = self._label(condition)
        return self.ends.signal(lambda photo: self._make(photo, label), condition, seconds=seconds, seed=seed)

    def label_of(self, image: Image) -> tuple[str, float]:
        """Return the material that a photograph is taken for, and the probability the predictor gives it.

        Both from the mean over several crops. A surface that was never trained on is named all the same: a low
        probability is the only sign of it.

        Raises
        ------
        ParameterError
            If the run has no label predictor, or the photograph is smaller than a crop.
        """
        if self.predictor is None:
            raise ParameterError(
                "a run without conditional batch norm has no label predictor: it names nothing"
            )
        views = torch.cat([self.ends.photo({"image": image}, number, seed=0) for number in range(VIEWS)])
        mean = self.predictor.probabilities(views).mean(0)
        place = int(mean.argmax())
        return self.materials[place], mean[place].item()

    def _label(self, condition: Condition) -> Tensor:
        """Return what conditions the generator, shape (1, class)."""
        if condition.get("material") is None:
            if self.predictor is None:
                return torch.zeros(1, len(self.materials))
            weights = material_weights({"material": self.label_of(condition["image"])[0]}, self.materials)
        elif self.predictor is None:
            raise ParameterError("a run without conditional batch norm takes no material: leave it out")
        else:
            weights = material_weights(condition, self.materials)
        return torch.from_numpy(weights / weights.sum()).float()[None]

    def _make_by_photo(self, photo: Tensor) -> Tensor:
        return self._make(photo, self._predicted(photo))

    @torch.inference_mode()
    def _make(self, photo: Tensor, label: Tensor) -> Tensor:
        """Return pictures, shape (batch, 1, row, column), of photographs of that shape."""
        made: Tensor = self.gan.bare_generator.eval()(photo.to(self.device), label.to(self.device))
        return made


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> VisualTactileLearner:
    """Return an untrained model for signals of ``kind``."""
    return VisualTactileLearner(config, kind, seed=seed, device=device)

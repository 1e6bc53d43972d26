"""The course of a training that turns photographs into pictures: levels, label predictor where there is one, GAN.

What a model adds is its networks, its losses and what conditions it: `PictureTraining` calls ``update`` for a batch and
``make`` for the pictures of photographs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol, cast

import torch
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.photo_pairs import WeakPairs
from tactogram.model import Example, Stage
from tactogram.nn.adversarial_pair import AdversarialPair
from tactogram.nn.label_predictor import PredictorTraining
from tactogram.nn.photo_translation import PhotoTranslation

Make = Callable[[Tensor], Tensor]
"""Photographs (batch, 1, row, column) to pictures of that shape, both in -1 to 1."""

Update = Callable[[Tensor, Tensor, Tensor, Tensor], dict[str, float]]
"""Photographs, pictures, true labels (batch,) and numbers of the photographs' crops (batch,) to losses."""

VIEWS = 5
"""Crops of a photograph whose mean names it."""


class _SizedConfig(Protocol):
    def check_size(self, rows: int, columns: int) -> None: ...


class PictureTraining:
    """Stages, batches, validation and state of such a training.

    Parameters
    ----------
    ends : PhotoTranslation
    gan : AdversarialPair
    batch_size : int
        Pairs of a step.
    epochs : int
        Over all pairs.
    steps : int, optional
        In place of ``epochs``.
    choose_every : int, optional
        Steps between judgements of unseen photographs; by default an epoch.
    predictor : PredictorTraining, optional
        Trained before the GAN.
    """

    def __init__(
        self,
        ends: PhotoTranslation,
        gan: AdversarialPair,
        *,
        batch_size: int,
        epochs: int,
        steps: int | None,
        choose_every: int | None,
        predictor: PredictorTraining | None = None,
    ) -> None:
        self.ends, self.gan, self.predictor = ends, gan, predictor
        self.batch_size, self.epochs, self.steps, self.choose_every = batch_size, epochs, steps, choose_every
        self.materials = ends.kind.materials
        self.watched: Sequence[Example] = ()
        self.seen: Sequence[Example] = ()

    def setup(self, fabric: Any) -> None:
        """Hand networks and optimisers to Lightning Fabric."""
        self.gan.setup(fabric)
        if self.predictor:
            self.predictor.setup(fabric)

    def watch(
        self,
        examples: Sequence[Example],
        chosen_by: str,
        distance: Callable[[Tensor, Tensor], Tensor],
    ) -> None:
        """Choose weights by ``examples``, which are not trained on: by accuracy, then by distance of pictures."""
        self.watched = examples
        self.ends.unseen(examples)  # refuses what it cannot use now, not after the first epoch
        self.gan.chosen_by, self.gan.distance = chosen_by, distance

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        """Return ``fit``, ``label predictor`` where there is one, and ``gan``; loads the trunk's weights.

        Refuses, before anything is trained, examples and sizes of pictures that the networks cannot take.
        """
        size, generator = self.ends.config.size, cast(_SizedConfig, self.gan.bare_generator)
        generator.check_size(size, size)
        self.ends.check(examples)
        self.seen = examples
        self.unseen(self.watched)
        steps = self.steps or self.epochs * self._epoch(examples)
        stages = [Stage("fit", 1), Stage("gan", steps)]
        if self.predictor:
            self.predictor.bare.trunk.load()
            epoch = self.predictor.steps_per_epoch(self.ends.pairs(examples))
            stages.insert(1, Stage("label predictor", self.predictor.config.epochs * epoch))
        return tuple(stages)

    def unseen(self, examples: Sequence[Example]) -> WeakPairs | None:
        """Return the pairs of the validation part of ``examples``, None where there are none to judge by.

        Where the protocol splits crops and no example is kept apart, crops of what is trained on are: the paper's
        validation part.
        """
        return self.ends.unseen(examples if len(examples) or not self.ends.splits_crops else self.seen)

    def _epoch(self, examples: Sequence[Example]) -> int:
        return -(-len(self.ends.pairs(examples)) // self.batch_size)

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        """Yield the batches of ``stage``."""
        if stage.name == "fit":
            yield examples
        elif stage.name == "label predictor" and self.predictor:
            yield from self.predictor.batches(self.ends.pairs(examples), seed=seed, start=start)
        else:
            every = self.choose_every or self._epoch(examples)
            for batch in self.ends.batches(examples, size=self.batch_size, seed=seed, start=start):
                yield *batch, every

    def step(self, stage: Stage, batch: Any, update: Update, make: Make) -> dict[str, float]:
        """Do one step of ``stage``; the GAN's by ``update``."""
        if stage.name == "fit":
            return self.ends.fit(batch)
        number, last = batch[0], batch[0] + 1 == stage.steps
        if stage.name == "label predictor" and self.predictor:
            epoch = stage.steps // self.predictor.config.epochs
            unseen = self.unseen(self.watched)
            figures = self.predictor.step(batch, epoch_steps=epoch, unseen=unseen)
            if last:
                self.predictor.settle()
            return figures
        _, photo, picture, label, crops, every = batch
        self.gan.train(number / stage.steps)
        figures = update(photo.to(self.gan.device), picture.to(self.gan.device), label, crops)
        if last or (number + 1) % every == 0:
            figures |= self.gan.choose(make, self.unseen(self.watched))
        if last:
            self.gan.settle()
        return figures

    def validate(self, examples: Sequence[Example], make: Make) -> dict[str, float]:
        """Return the distance of pictures of unseen photographs, and their classification accuracy."""
        pairs = self.unseen(examples)
        if pairs is None:
            return {}
        figures = {f"{self.gan.chosen_by}_unseen": self.gan.validation_distance(make, pairs)}
        if self.predictor:
            figures["label_accuracy_unseen"] = self.predictor.accuracy(pairs)
        return figures

    def named(self, image: Any) -> Tensor:
        """Return the probability of each material for a photograph, mean over several crops, shape (class,).

        Raises
        ------
        ParameterError
            If there is no label predictor, or the photograph is smaller than a crop.
        """
        if self.predictor is None:
            raise ParameterError("this run has no label predictor: it names nothing")
        views = torch.cat([self.ends.photo({"image": image}, number, seed=0) for number in range(VIEWS)])
        return self.predictor.probabilities(views).mean(0)

    def state(self) -> dict[str, Any]:
        """Return all of it; says what the weights were chosen by and which trunk names the photographs."""
        return {
            "materials": list(self.materials),
            "ends": self.ends.state(),
            "gan": self.gan.state(),
            "trunk": self.predictor.config.trunk if self.predictor else None,
            "predictor": self.predictor.state() if self.predictor else None,
            "optimisers": {
                "gan": self.gan.optimiser_state(),
                "predictor": self.predictor.optimiser.state_dict() if self.predictor else None,
            },
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`."""
        if tuple(state["materials"]) != self.materials:
            raise ParameterError(
                f"state is of {', '.join(state['materials'])}; expected {', '.join(self.materials)}"
            )
        optimisers = state.get("optimisers") or {}
        self.ends.load_state(state["ends"])
        self.gan.load_state(state["gan"], optimisers.get("gan"))
        if self.predictor:
            self.predictor.load_state(state["predictor"])
            if optimisers.get("predictor"):
                self.predictor.optimiser.load_state_dict(optimisers["predictor"])

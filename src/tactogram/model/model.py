"""Base class of all models: training, and what a trained model does. Everything but `Model.step` has a default."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.model.batch_share import WHOLE_BATCH, BatchShare
from tactogram.model.conditions import Condition
from tactogram.model.kinds import Limit, word_limits
from tactogram.model.state import Saved
from tactogram.signal import Image, Signal
from tactogram.validation import DescribedModel

if TYPE_CHECKING:
    import torch
    from matplotlib.figure import Figure
    from torch import Tensor, nn


class ModelConfig(DescribedModel):
    """Configuration of a model, or of a part of it: a frozen pydantic model that refuses unknown keys."""

    def input_samples(self, rate: float) -> int:
        """Return the samples of its input at a sampling rate in Hz: the window of ``live``; 0 if any will do."""
        return 0

    @property
    def window_protocol(self) -> str:
        """Protocol that tests on other windows or crops of the training data; empty if recordings are split.

        Under one, no recording is kept apart unless the training is told to.
        """
        return ""


@dataclass(frozen=True)
class Stage:
    """One stage of a model's training, e.g. a label predictor before its GAN.

    Parameters
    ----------
    name : str
        As progress displays it.
    steps : int
        Calls of `Model.step`, one batch each.
    updates : mapping
        Updates of each network in a step, where they differ between networks.
    skippable : bool
        Whether the training leaves it out where an earlier stage suffices.
    """

    name: str
    steps: int
    updates: Mapping[str, int] = field(default_factory=dict)
    skippable: bool = False

    @property
    def total_updates(self) -> dict[str, int]:
        """Updates of each network in all steps."""
        return {network: self.steps * each for network, each in self.updates.items()}


class Model(Saved, ABC):
    """A model that learns from examples and, by the ``task`` of its ``model.toml``, generates, classifies or predicts.

    A subclass defines `step`, and `generate`, `probabilities` or `predict`. By default it is trained in one step on all
    examples, on the processor: a closed form. It owns its networks *and* their optimisers.

    Parameters
    ----------
    config : ModelConfig
    kind : SignalKind or ImageKind
        What all training signals, or images, have in common.
    seed : int
        Decides the initial weights and whatever is drawn once.
    device : str or torch.device
    """

    divides_batches: ClassVar[bool] = False
    """Whether several processes can train it together, each on its `share` of every batch.

    Fabric averages the gradients of all networks that it was handed. A stage of one step is a closed form: every
    process computes it alone, with the same result.
    """
    embeds: ClassVar[bool] = False
    """Whether it has `embed`; the surfaces that a classifier knows can then be searched."""
    variation: ClassVar[str] = ""
    """Differences between signals of several seeds, in words, of a generator whose network takes no noise."""

    share: BatchShare = WHOLE_BATCH
    """Rows that `batches` draws of each batch."""
    device: Any
    maps: Sequence[Any] = ()
    """A `TextureMap` or `NoiseMap` over speed and force for each of `materials`, which streams synthesise."""

    def __init__(self, config: Any, kind: Any, *, seed: int = 0, device: str | torch.device = "cpu") -> None:
        self.config, self.kind, self.seed, self.device = config, kind, seed, device

    @property
    def materials(self) -> tuple[str, ...]:
        """Materials of the training recordings, sorted."""
        materials: tuple[str, ...] = self.kind.materials
        return materials

    @property
    def words(self) -> tuple[str, ...]:
        """Words of the ratings."""
        words: tuple[str, ...] = self.kind.words
        return words

    # -- training -----------------------------------------------------------------------------------------------

    def parts(self) -> Sequence[Any]:
        """Return what is trained: networks with ``setup``, ``optimiser_state`` and ``load_optimisers``, or none."""
        return ()

    def setup(self, fabric: Any) -> None:
        """Hand networks and optimisers to Lightning Fabric, which knows device, precision and processes."""
        for part in self.parts():
            part.setup(fabric)
            self.device = fabric.device
        if self.divides_batches:
            self.share = BatchShare.of_process(fabric)

    def set_validation(self, examples: Sequence[Any]) -> str:
        """Choose weights by ``examples``, which are not trained on and may be empty; called once, before `stages`.

        Returns a note if the choice departs from the configuration, else an empty string. By default the last weights
        are kept.
        """
        return ""

    def stages(self, examples: Sequence[Any]) -> tuple[Stage, ...]:
        """Return the stages of a training on ``examples``, in order; refuses unsuitable ones before any training."""
        return (Stage("fit", 1),)

    def batches(self, stage: Stage, examples: Sequence[Any], *, seed: int, start: int = 0) -> Iterator[Any]:
        """Yield the batches of ``stage`` from step ``start`` on; batch k depends on seed and k alone.

        By default all examples are the one batch.
        """
        if start == 0:
            yield examples

    @abstractmethod
    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        """Update every network once, as in the paper, and return the losses."""

    def validate(self, examples: Sequence[Any]) -> dict[str, float]:
        """Return figures on examples that were not trained on; none by default."""
        return {}

    def state(self) -> dict[str, Any]:
        """Return the full training state: by default the attributes in `saved`.

        Finished runs omit the key ``optimisers``, which holds the state needed only for training.
        """
        optimisers = self.optimiser_state()
        return super().state() | ({} if optimisers is None else {"optimisers": optimisers})

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Continue from ``state``, which of a finished run lacks ``optimisers``."""
        super().load_state(state)
        if state.get("optimisers") is not None:
            self.load_optimisers(state["optimisers"])

    def optimiser_state(self) -> Any:
        """Return the state of the optimisers of each of `parts`; None if there are none."""
        return [part.optimiser_state() for part in self.parts()] or None

    def load_optimisers(self, states: Any) -> None:
        """Continue from `optimiser_state`."""
        for part, state in zip(self.parts(), states, strict=True):
            part.load_optimisers(state)

    def outcome(self) -> dict[str, Any]:
        """Return facts about the training as JSON values, for the run's ``model.json``; none by default."""
        return {}

    def figures(self) -> Mapping[str, Figure]:
        """Return figures of the training by name, for the run's ``figures/NAME.png``; none by default."""
        return {}

    def exported_networks(self) -> Mapping[str, ExportedNetwork]:
        """Return the networks that run without Python, in another runtime, by name; none by default."""
        return {}

    # -- a generator --------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal | Image:
        """Return a signal or image for ``condition``; the same seed gives the same samples.

        ``seconds`` defaults to a length of the model's choice.
        """
        raise self._refused("generate")

    @property
    def rated_means(self) -> Mapping[str, NDArray[np.float64]]:
        """Mean scores of each rated surface or image, 0 to 1, shape (word,), in the order of `words`; or none."""
        return {}

    def limits(self, condition: Condition) -> list[Limit]:
        """Return the speeds, forces and words that `generate` takes for others, and for which.

        By default words outside of `rated_means`.
        """
        rated = [*self.rated_means.values()] if condition.get("words") else []
        return word_limits(condition["words"], self.kind, np.stack(rated)) if rated else []

    def classify_photograph(self, image: Image) -> tuple[str, float | None]:
        """Return the material of a photograph and its probability, None if the model has no probabilities.

        Raises `ParameterError` if the model, or this run, does not classify photographs, or this one is too small.
        """
        raise self._refused("classify photographs")

    def prediction_facts(self, condition: Condition) -> dict[str, Any]:
        """Return facts about a surface predicted from a photograph, an English text or both, as JSON values.

        ``given`` are the names of the inputs, ``materials`` those learned from, ``mean`` whether the inputs tell
        nothing, so that the mean of all was predicted; ``explained`` is the share of the variance of the spectra of
        materials left out, ``explained_range`` its interval of 95 %, ``error_db`` the standard deviation of what was
        predicted of them; these are missing if the materials are too few. By default nothing is predicted: empty.
        """
        return {}

    def selection_for(self, condition: Condition, seed: int) -> dict[str, Any]:
        """Return what `generate` selects of the training data, such as a cluster or a spectrum, as JSON values."""
        return {}

    def image_spread(self) -> Any:
        """Return a `tactogram.evaluation.pictures.distances.ImageSpread`, or None if it is not measured."""
        return None

    @property
    def predicted_ranges(self) -> Mapping[str, tuple[float, float]]:
        """Lowest and highest speed and force, by name of the condition, at which surfaces can be predicted; or none."""
        return {}

    def evaluate_as_published(self, examples: Sequence[Any]) -> dict[str, Any]:
        """Return ``mean`` and ``per_material`` of the publication's own figures; empty if it has none.

        Under a `ModelConfig.window_protocol` ``examples`` are the training examples, of which other windows are used;
        else unseen ones. Raises `ParameterError` if these recordings allow no such figures.
        """
        return {}

    # -- a classifier -------------------------------------------------------------------------------------------

    def probabilities(self, signal: Signal) -> NDArray[np.float64]:
        """Return the probability of each of `materials`, float64, shape (material,), sum 1."""
        raise self._refused("classify")

    def candidates(self, probabilities: NDArray[np.float64]) -> tuple[str, ...] | None:
        """Return the materials among which a recording's own is with 95 %, likeliest first.

        ``probabilities`` are its `probabilities`, float64, shape (material,). None if the model does not know: by
        default.
        """
        return None

    def window_probabilities(self, signal: Signal) -> NDArray[np.float64]:
        """Return the probability of each of `materials` for each window, float64, shape (window, material).

        By default a signal is one window.
        """
        return self.probabilities(signal)[None]

    def embed(self, signal: Signal) -> NDArray[np.float32]:
        """Return a signal as a vector, float32, shape (feature,)."""
        raise self._refused("turn signals into vectors")

    # -- a predictor --------------------------------------------------------------------------------------------

    def predict(self, content: Signal | Image) -> Mapping[str, float]:
        """Return a score of a signal or an image per name, e.g. a sensory word, on the scale of the ratings."""
        raise self._refused("predict scores")

    def novelty(self, content: Signal | Image) -> float | None:
        """Return the share of features outside the range of the training data, 0 to 1; None if unknown."""
        return None

    @property
    def feature_description(self) -> str | None:
        """The features that scores are predicted from, in words, or None."""
        return None

    def _refused(self, job: str) -> ParameterError:
        return ParameterError(f"{type(self).__name__} does not {job}; `tactogram models` lists those that do")


@dataclass(frozen=True)
class Port:
    """Input or output of a network.

    Parameters
    ----------
    axes : tuple of str
        Names of its axes. An axis of the same name has the same size at every port.
    meaning : str
        One line, e.g. ``"photograph, -1 to 1"``.
    unit : str
    """

    axes: tuple[str, ...]
    meaning: str
    unit: str = "1"


@dataclass(frozen=True, eq=False)
class ExportedNetwork:
    """A network as the model uses it, from physical inputs to physical outputs where that is part of the graph.

    Parameters
    ----------
    network : torch.nn.Module
        In evaluation mode, on the CPU. Draws no random numbers: these are inputs.
    draw : callable
        Returns typical inputs for a seed, one tensor per input; batches have two elements or more.
    inputs, outputs : mapping from str to Port
        In the order of the arguments and results of ``network``.
    free : tuple of str
        Axes of any size; every other axis has the size it is drawn with.
    note : str
        What the network leaves to its caller.
    facts : mapping
        JSON values that a caller needs, e.g. the names behind a label.
    """

    network: nn.Module
    draw: Callable[[int], tuple[Tensor, ...]]
    inputs: Mapping[str, Port]
    outputs: Mapping[str, Port]
    free: tuple[str, ...] = ("batch",)
    note: str = ""
    facts: Mapping[str, Any] = field(default_factory=dict)

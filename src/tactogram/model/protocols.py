"""Protocols that models implement. Those after `Learner` are optional."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tactogram.model.batch_share import BatchShare
from tactogram.model.conditions import Condition
from tactogram.model.examples import Example
from tactogram.model.exported import ExportedNetwork
from tactogram.model.limits import Limit
from tactogram.signal import Image, Signal

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from torch import Tensor

    from tactogram.signal.texture_map import NoiseMap, TextureMap


@runtime_checkable
class Generator(Protocol):
    """A trained model that generates signals or images."""

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal | Image:
        """Return a signal or image for ``condition``; the same seed gives the same samples.

        ``seconds`` defaults to a length of the model's choice.
        """
        ...


@runtime_checkable
class Classifier(Protocol):
    """A trained model that classifies signals by material."""

    materials: tuple[str, ...]

    def probabilities(self, signal: Signal) -> NDArray[np.float64]:
        """Return the probability of each of ``materials``, float64, shape (material,), sum 1."""
        ...


@runtime_checkable
class Predictor(Protocol):
    """A trained model that scores a signal or an image, for example in sensory words."""

    def predict(self, signal: Signal | Image) -> Mapping[str, float]:
        """Return a score per name, on the scale of the training ratings."""
        ...


@dataclass(frozen=True)
class Stage:
    """One stage of a model's training, e.g. a label predictor before its GAN.

    Parameters
    ----------
    name : str
        As progress displays it.
    steps : int
        Calls of `Learner.step`, one batch each.
    updates : mapping
        Updates of each network in a step, where they differ between networks.
    """

    name: str
    steps: int
    updates: Mapping[str, int] = field(default_factory=dict)

    @property
    def total_updates(self) -> dict[str, int]:
        """Updates of each network in all steps."""
        return {network: self.steps * each for network, each in self.updates.items()}


@runtime_checkable
class Learner(Protocol):
    """A model that can be trained. It owns its networks *and* their optimisers."""

    def setup(self, fabric: Any) -> None:
        """Hand networks and optimisers to Lightning Fabric, which knows device, precision and processes."""
        ...

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        """Return the stages of a training on ``examples``, in order; a closed form is one step."""
        ...

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        """Yield the batches of ``stage`` from step ``start`` on; batch k depends on seed and k alone."""
        ...

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        """Update every network once, as in the paper, and return the losses."""
        ...

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return figures on examples that were not trained on."""
        ...

    def state(self) -> dict[str, Any]:
        """Return the full training state: nested dicts and lists of tensors and plain numbers.

        Finished runs omit the key ``optimisers``, which holds the state needed only for training.
        """
        ...

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Continue from ``state``."""
        ...


# -- optional, of a learner -----------------------------------------------------------------------------------


@runtime_checkable
class SharedLearner(Protocol):
    """A learner that several processes can train together, each on its share of every batch.

    Fabric averages the gradients of all modules that it was handed. A stage of one step is a closed form: every process
    computes it alone, with the same result.
    """

    share: BatchShare
    """Rows that `Learner.batches` draws of each batch; set by `Learner.setup`."""


@runtime_checkable
class CheckpointSelector(Protocol):
    """A learner that chooses among its weights by examples that it is not trained on."""

    def set_validation(self, examples: Sequence[Example]) -> str:
        """Choose weights by ``examples``, which may be empty; called once, before `Learner.stages`.

        Returns a note if the choice departs from the configuration, else an empty string.
        """
        ...


@runtime_checkable
class OutcomeReporter(Protocol):
    """A learner with facts about its training, which are stored in the run's ``model.json``."""

    def outcome(self) -> dict[str, Any]:
        """Return the facts as JSON values."""
        ...


@runtime_checkable
class FigureReporter(Protocol):
    """A learner that draws its training, for the run's ``figures/NAME.png``."""

    def figures(self) -> Mapping[str, Figure]:
        """Return the figures by name."""
        ...


@runtime_checkable
class NetworkExporter(Protocol):
    """A model whose networks run without Python, in another runtime."""

    def exported_networks(self) -> Mapping[str, ExportedNetwork]:
        """Return the networks that the trained model uses, by name."""
        ...


# -- optional, of a classifier --------------------------------------------------------------------------------


@runtime_checkable
class WindowClassifier(Classifier, Protocol):
    """A classifier of windows; any other classifier counts as having one window per signal."""

    def window_probabilities(self, signal: Signal) -> NDArray[np.float64]:
        """Return the probability of each of ``materials`` for each window, float64, shape (window, material)."""
        ...


@runtime_checkable
class WindowConfig(Protocol):
    """The configuration of a model whose input has one length."""

    @property
    def window(self) -> int:
        """Samples of the input."""
        ...


def window_of(config: object) -> int:
    """Return the samples of a model's input, 0 if its configuration does not fix them."""
    return config.window if isinstance(config, WindowConfig) else 0


@runtime_checkable
class Embedder(Protocol):
    """A model that maps a signal to a vector; runs of classifiers that do so can be searched."""

    def embed(self, signal: Signal) -> NDArray[np.float32]:
        """Return float32, shape (feature,)."""
        ...


# -- optional, of a generator ---------------------------------------------------------------------------------


@runtime_checkable
class RatedGenerator(Generator, Protocol):
    """A generator conditioned on words that stores the ratings of its training data."""

    @property
    def rated_means(self) -> Mapping[str, NDArray[np.float64]]:
        """Mean scores of each rated surface or image, 0 to 1, shape (word,), in the order of its kind's words."""
        ...


@runtime_checkable
class NoiselessGenerator(Protocol):
    """A generator whose network takes no noise."""

    @property
    def variation(self) -> str:
        """Differences between signals of several seeds, in words."""
        ...


@runtime_checkable
class PhotographClassifier(Protocol):
    """A generator that classifies the photograph it is conditioned on."""

    def classify_photograph(self, image: Image) -> tuple[str, float | None]:
        """Return the material and its probability, None if the model has no probabilities.

        Raises
        ------
        ParameterError
            If this run has no classifier, or the photograph is too small.
        """
        ...


@runtime_checkable
class DescriptionPredictor(Protocol):
    """A generator that predicts a surface that it need not know from a photograph, an English text or both."""

    def prediction_facts(self, condition: Condition) -> dict[str, Any]:
        """Return facts about the prediction as JSON values; empty if this run predicts nothing from the condition.

        ``given`` are the names of the inputs, ``materials`` those learned from, ``mean`` whether the inputs tell
        nothing, so that the mean of all was predicted; ``explained`` is the share of the variance of the spectra of
        materials left out, ``explained_range`` its interval of 95 %, ``error_db`` the standard deviation of what was
        predicted of them; these are missing if the materials are too few.
        """
        ...


@runtime_checkable
class PictureGenerator(Generator, Protocol):
    """A generator that turns photographs into spectrogram pictures, which are evaluated as pictures, too."""

    @property
    def translation(self) -> Any:
        """`tactogram.nn.photo_translation.PhotoTranslation`: its pairs, and the inversion of pictures to signals."""
        ...

    @property
    def gan(self) -> Any:
        """`tactogram.nn.adversarial_pair.AdversarialPair`, whose generator draws the pictures."""
        ...

    @property
    def predictor(self) -> Any:
        """`tactogram.nn.label_predictor.PredictorTraining`, which classifies photographs, or None."""
        ...

    def make(self, photo: Tensor) -> Tensor:
        """Return pictures, float32, shape (batch, 1, row, column), of photographs of that shape, both -1 to 1."""
        ...

    def conditioning(self, photo: Tensor) -> tuple[Any, ...]:
        """Return the further inputs of ``gan.generator`` for photographs, shape (batch, 1, row, column)."""
        ...


@runtime_checkable
class PublishedEvaluator(Protocol):
    """A generator that can be evaluated by its publication's own figures."""

    @property
    def window_protocol(self) -> str:
        """Name of the protocol that splits windows within recordings; empty if recordings are split."""
        ...

    def evaluate_as_published(self, examples: Sequence[Example]) -> dict[str, Any]:
        """Return ``mean`` and ``per_material`` of the publication's figures.

        Parameters
        ----------
        examples : sequence of Example
            Under a `window_protocol` the training examples, of which other windows are used; else unseen examples.

        Raises
        ------
        ParameterError
            If these recordings allow no such figures.
        """
        ...


@runtime_checkable
class SelectionReporter(Protocol):
    """A generator that selects part of its training data, such as a cluster or a spectrum, for a condition."""

    def selection_for(self, condition: Condition, seed: int) -> dict[str, Any]:
        """Return the selection that `Generator.generate` makes for ``condition`` and ``seed``, as JSON values."""
        ...


@runtime_checkable
class SpreadReporter(Protocol):
    """A generator of images that measures how much they differ."""

    def image_spread(self) -> Any:
        """Return a `tactogram.evaluation.pictures.image_spread.ImageSpread`."""
        ...


@runtime_checkable
class TextureMapModel(Protocol):
    """A generator whose materials are models over speed and force: streams synthesise them without end."""

    @property
    def maps(self) -> Sequence[TextureMap | NoiseMap]:
        """One for each material of the run, in that order."""
        ...


@runtime_checkable
class LimitReporter(Protocol):
    """A generator that knows which numbers of a condition are outside of what it learned."""

    def limits(self, condition: Condition) -> list[Limit]:
        """Return the speeds, forces and words that `Generator.generate` takes for others, and for which."""
        ...


@runtime_checkable
class MotionPredictor(Protocol):
    """A generator that can predict surfaces at speeds and forces that it has no recording of."""

    @property
    def predicted_ranges(self) -> Mapping[str, tuple[float, float]]:
        """Lowest and highest speed and force, by name of the condition; empty if this run was not trained to."""
        ...


# -- optional, of a predictor ---------------------------------------------------------------------------------


@runtime_checkable
class NoveltyReporter(Protocol):
    """A predictor that measures how far a signal or an image lies outside its training data."""

    def novelty(self, content: Signal | Image) -> float:
        """Return the share of features outside the range of the training data, 0 to 1."""
        ...


@runtime_checkable
class FeatureReporter(Protocol):
    """A predictor that names the features it uses."""

    @property
    def feature_description(self) -> str:
        """The features, in words."""
        ...


def feature_description(model: object) -> str | None:
    """Return the features that a predictor uses, in words; None if it does not name them."""
    return model.feature_description if isinstance(model, FeatureReporter) else None

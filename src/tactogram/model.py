"""Protocols that models keep, and the values that they exchange with the rest of the package.

A model keeps `Learner`, and `Generator`, `Classifier` or `Predictor`. The protocols after these are optional: what a
model offers beyond, it is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.signal import Domain

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from torch import Tensor

    from tactogram.signal.texture_map import TextureMap

CONDITIONS: Mapping[str, str] = {
    "material": "weight per material name, e.g. {'cork': 0.6, 'tile': 0.4}; a lone name is weight 1",
    "image": "photograph of the surface (Image)",
    "words": "score per sensory word, e.g. {'rough': 6.0}",
    "vibration": "a Signal to go by",
    "speed_mm_s": "stroking speed, mm/s",
    "force_n": "normal force, N",
    "latent": "float array, shape (dimension,): the model's own random input, to walk through; else the seed draws it",
}
"""The closed list of condition names. Command line and studio build their forms from it."""

Condition = Mapping[str, Any]


def check_condition(condition: Condition, *, needs: Sequence[str] = (), takes: Sequence[str] = ()) -> None:
    """Refuse a condition that lacks what a model needs or holds what it does not take.

    Raises
    ------
    ParameterError
        Naming the missing or the unknown condition.
    """
    for name in needs:
        if condition.get(name) is None:
            raise ParameterError(f"condition {name!r} is needed: {CONDITIONS[name]}")
    for name, value in condition.items():
        if value is not None and name not in (*needs, *takes):
            known = ", ".join((*needs, *takes)) or "none"
            raise ParameterError(f"condition {name!r} is not one this model takes ({known})")


def material_weights(condition: Condition, materials: Sequence[str]) -> NDArray[np.float64]:
    """Return the weight of each of ``materials`` that ``condition["material"]`` asks for.

    Parameters
    ----------
    condition : mapping
        ``material`` is a name or a mapping from name to weight >= 0.
    materials : sequence of str
        The names a model knows.

    Returns
    -------
    float64 array, shape (material,)
        As given: not scaled to sum to 1.

    Raises
    ------
    ParameterError
        For an unknown material, a weight that is negative or not finite, or weights that are all 0.
    """
    asked = condition.get("material")
    if asked is None:
        raise ParameterError(f"condition 'material' is needed: {CONDITIONS['material']}")
    asked = {asked: 1.0} if isinstance(asked, str) else dict(asked)
    weights = np.zeros(len(materials))
    for name, weight in asked.items():
        if name not in materials:
            raise ParameterError(f"material must be one of {', '.join(materials)}, got {name!r}")
        if not (np.isfinite(weight) and weight >= 0):
            raise ParameterError(f"weight of {name} must be finite and >= 0, got {weight}")
        weights[materials.index(name)] = weight
    if not weights.any():
        raise ParameterError("at least one material needs a weight > 0, got all 0")
    return weights


@dataclass(frozen=True, eq=False)
class ItemRatings:
    """Ratings of one item.

    Parameters
    ----------
    words : tuple of str
        What was asked, in an order that is the same for all items of a data set.
    raters : tuple of str
    scores : float64 array, shape (rater, word)
        0 (lowest on the scale) to 1 (highest); NaN where a rater gave none.
    """

    words: tuple[str, ...]
    raters: tuple[str, ...]
    scores: NDArray[np.float64]

    @property
    def means(self) -> NDArray[np.float64]:
        """Mean over the raters who scored, 0 to 1, shape (word,); NaN where none did."""
        given = ~np.isnan(self.scores)
        with np.errstate(invalid="ignore"):
            means: NDArray[np.float64] = np.where(given, self.scores, 0).sum(0) / given.sum(0)
        return means


@dataclass(frozen=True, eq=False)
class Example:
    """One prepared piece of a recording, as a learner sees it.

    Parameters
    ----------
    id : str
        The recording it was cut from.
    signal : Signal
        Prepared: stream, axes, band and rate are those of the recipe.
    material : str, optional
        Its class.
    condition : mapping
        What else is known of it, under names from `CONDITIONS`.
    photographs : sequence of Image
        Photographs of the same surface that this part of the split may use, cut to the region it may use.
        Decoded when asked for, so holding an example holds no picture.
    item : str, optional
        What ratings call it: a surface, or a vibration that was rated in its own right and has no material.
    rated : Rated, optional
        What people said of ``item``.
    """

    id: str
    signal: Signal
    material: str | None = None
    condition: Condition = field(default_factory=dict)
    photographs: Sequence[Image] = ()
    item: str | None = None
    rated: ItemRatings | None = None


@dataclass(frozen=True, eq=False)
class ImageExample:
    """One rated image, as a learner of images sees it.

    Parameters
    ----------
    id : str
        The photograph's key in its store.
    photographs : sequence of Image
        The one image; decoded when asked for.
    item : str
        What ratings call it.
    rated : Rated
    """

    id: str
    photographs: Sequence[Image]
    item: str
    rated: ItemRatings

    @property
    def image(self) -> Image:
        """The image, decoded now."""
        return self.photographs[0]


@dataclass(frozen=True)
class SignalKind:
    """Properties that all signals of a run share; saved with the weights.

    Parameters
    ----------
    rate : float, Hz
    unit : str
    axes : tuple of str
    materials : tuple of str
        The classes, sorted.
    simulated : bool
        Whether any of the training data was simulated.
    domain : {"time", "displacement"}
        What the signals run over; over displacement ``rate`` is in samples per mm.
    words : tuple of str
        What raters were asked, for models that learn from ratings.
    scale : tuple of (float, float), optional
        Lowest and highest score that they could give.
    """

    rate: float
    unit: str
    axes: tuple[str, ...]
    materials: tuple[str, ...] = ()
    simulated: bool = False
    domain: Domain = "time"
    words: tuple[str, ...] = ()
    scale: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.domain not in ("time", "displacement"):
            raise ParameterError(f"domain must be 'time' or 'displacement', got {self.domain!r}")

    def check(self, signal: Signal) -> None:
        """Refuse a signal of another rate, unit, set of axes or domain.

        Raises
        ------
        ParameterError
            Saying what was expected and what came.
        """
        got = (signal.rate, signal.unit, signal.axes, signal.domain)
        if got != (self.rate, self.unit, self.axes, self.domain):
            alike = (signal.rate, signal.unit, signal.domain) == (self.rate, self.unit, self.domain)
            renamed = alike and len(signal.axes) == len(self.axes)
            hint = f"; read it as {','.join(self.axes)} (--axes) if these are the same" if renamed else ""
            raise ParameterError(f"signal must be {_kind(self)}; got {_kind(signal)}{hint}")

    def by_material(self, examples: Sequence[Example]) -> dict[str, list[Example]]:
        """Return the training examples of each of ``materials``, all of this kind.

        Raises
        ------
        ParameterError
            If one is of another kind or material, or a material has none.
        """
        found: dict[str, list[Example]] = {name: [] for name in self.materials}
        for example in examples:
            if example.material not in found:
                raise ParameterError(
                    f"recording {example.id}: material must be one of {', '.join(self.materials)}, "
                    f"got {example.material!r}"
                )
            self.check(example.signal)
            found[example.material].append(example)
        if missing := [name for name, members in found.items() if not members]:
            raise ParameterError(f"no training recording of {', '.join(missing)}; leave it out of the data")
        return found


@dataclass(frozen=True)
class ImageKind:
    """Properties that all images of a run share; saved with the weights.

    Parameters
    ----------
    words : tuple of str
    scale : tuple of (float, float)
    items : tuple of str
        Of the training part, sorted.
    simulated : bool
    """

    words: tuple[str, ...]
    scale: tuple[float, float]
    items: tuple[str, ...]
    simulated: bool = False

    @property
    def materials(self) -> tuple[str, ...]:
        """None: images are not of classes."""
        return ()


Kind = SignalKind | ImageKind


def unit_scores(words: Mapping[str, float], kind: Kind) -> NDArray[np.float64]:
    """Return scores as 0 to 1 in the order of ``kind.words``, shape (word,): (x - 1) / 6 on the 7-point scale.

    Raises
    ------
    ParameterError
        Naming what is unknown, off the scale or missing.
    """
    low, high = kind.scale or (0.0, 1.0)
    for word, score in words.items():
        if word not in kind.words:
            raise ParameterError(f"words must be of {', '.join(kind.words)}; got {word!r}")
        if not low <= score <= high:
            raise ParameterError(f"{word} must be {low:g} to {high:g}, got {score:g}")
    if missing := [word for word in kind.words if word not in words]:
        raise ParameterError(f"a score is needed of {', '.join(missing)}")
    return np.array([(float(words[word]) - low) / (high - low) for word in kind.words])


def _kind(signal: Signal | SignalKind) -> str:
    per = "Hz" if signal.domain == "time" else "samples per mm"
    return f"{signal.rate:g} {per}, {signal.unit}, axes {','.join(signal.axes)}"


@runtime_checkable
class Generator(Protocol):
    """A trained model that gives signals or images."""

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal | Image:
        """Return what ``condition`` asks for; the same seed gives the same samples.

        ``seconds`` defaults to the model's own length.
        """
        ...


@runtime_checkable
class RatedGenerator(Generator, Protocol):
    """A generator conditioned on words and knows what people said of what it learned from."""

    @property
    def rated_means(self) -> Mapping[str, NDArray[np.float64]]:
        """Mean scores of each rated surface or image, 0 to 1, shape (word,), in the order of its kind's words."""
        ...


@runtime_checkable
class Classifier(Protocol):
    """A trained model that names the material of a signal."""

    materials: tuple[str, ...]

    def probabilities(self, signal: Signal) -> NDArray[np.float64]:
        """Return the probability of each of ``materials``, float64, shape (material,), sum 1."""
        ...


@runtime_checkable
class Predictor(Protocol):
    """A trained model that scores a signal or an image, for example in sensory words."""

    def predict(self, signal: Signal | Image) -> Mapping[str, float]:
        """Return a score per name, on the scale of the ratings it learned from."""
        ...


@dataclass(frozen=True)
class Stage:
    """One stage of a model's training, e.g. a label predictor before its GAN.

    Parameters
    ----------
    name : str
        As progress shows it.
    steps : int
        Calls of `Learner.step`, one batch each.
    """

    name: str
    steps: int


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
        """Update every network once, as the paper does it, and return the losses."""
        ...

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return figures on examples that were not trained on."""
        ...

    def state(self) -> dict[str, Any]:
        """Return all that is needed to go on training: nested dicts and lists of tensors and plain numbers.

        What only training needs stands under the key ``optimisers`` and is left out of finished runs.
        """
        ...

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Go on from ``state``."""
        ...


# -- optional, of a learner -----------------------------------------------------------------------------------


@runtime_checkable
class CheckpointSelector(Protocol):
    """A learner that chooses among its weights by examples that it is not trained on."""

    def set_validation(self, examples: Sequence[Example]) -> str:
        """Choose weights by ``examples``, which may be none; called once, before `Learner.stages`.

        Returns a note if they are not chosen as the configuration says, else an empty string.
        """
        ...


@runtime_checkable
class OutcomeReporter(Protocol):
    """A learner with facts about its training, which are kept in the run's ``model.json``."""

    def outcome(self) -> dict[str, Any]:
        """Return the facts, as JSON knows them."""
        ...


@runtime_checkable
class FigureReporter(Protocol):
    """A learner that draws its training, for the run's ``figures/NAME.png``."""

    def figures(self) -> Mapping[str, Figure]:
        """Return the figures by name."""
        ...


# -- optional, of a classifier --------------------------------------------------------------------------------


@runtime_checkable
class WindowClassifier(Classifier, Protocol):
    """A classifier that judges a signal window by window; any other is counted as having one window per signal."""

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
    """Return the samples of a model's input, 0 if its configuration states none."""
    return config.window if isinstance(config, WindowConfig) else 0


@runtime_checkable
class Embedder(Protocol):
    """A model that turns a signal into a vector: a run of a classifier that is one can be searched."""

    def embed(self, signal: Signal) -> NDArray[np.float32]:
        """Return float32, shape (feature,)."""
        ...


# -- optional, of a generator ---------------------------------------------------------------------------------


@runtime_checkable
class NoiselessGenerator(Protocol):
    """A generator whose network takes no noise."""

    @property
    def variation(self) -> str:
        """What signals of several seeds differ by, in words."""
        ...


@runtime_checkable
class PhotographClassifier(Protocol):
    """A generator that names the material in a photograph that it goes by."""

    def classify_photograph(self, image: Image) -> tuple[str, float | None]:
        """Return the material and its probability, None where the model has no such figure.

        Raises
        ------
        ParameterError
            If this run cannot, or the photograph is too small.
        """
        ...


@runtime_checkable
class PictureGenerator(Generator, Protocol):
    """A generator that turns photographs into spectrogram pictures, which are evaluated as pictures, too."""

    @property
    def ends(self) -> Any:
        """`tactogram.nn.photo_translation.PhotoTranslation`: its pairs, and how a picture becomes a signal."""
        ...

    @property
    def gan(self) -> Any:
        """`tactogram.nn.adversarial_pair.AdversarialPair`, whose generator draws the pictures."""
        ...

    @property
    def predictor(self) -> Any:
        """`tactogram.nn.label_predictor.PredictorTraining`, which names photographs; None without one."""
        ...

    def make(self, photo: Tensor) -> Tensor:
        """Return pictures, float32, shape (batch, 1, row, column), of photographs of that shape, both -1 to 1."""
        ...

    def conditioning(self, photo: Tensor) -> tuple[Any, ...]:
        """Return what ``gan.generator`` takes beside photographs of shape (batch, 1, row, column); may be empty."""
        ...


@runtime_checkable
class PublishedEvaluator(Protocol):
    """A generator whose publication evaluates it by figures of its own."""

    @property
    def window_protocol(self) -> str:
        """Name of the protocol that splits windows within recordings; empty if recordings are split."""
        ...

    def evaluate_as_published(self, examples: Sequence[Example]) -> dict[str, Any]:
        """Return ``mean`` and ``per_material`` of the publication's figures.

        Parameters
        ----------
        examples : sequence of Example
            Under a `window_protocol` what was trained on, of which other windows are used; else what was not.

        Raises
        ------
        ParameterError
            If these recordings allow no such figures.
        """
        ...


@runtime_checkable
class SelectionReporter(Protocol):
    """A generator that picks some of what it learned, such as a cluster or a spectrum, to answer a condition."""

    def selection_for(self, condition: Condition, seed: int) -> dict[str, Any]:
        """Return what `Generator.generate` picks for ``condition`` and ``seed``, as JSON knows it."""
        ...


@runtime_checkable
class SpreadReporter(Protocol):
    """A generator of images that measures by how much they differ."""

    def image_spread(self) -> Any:
        """Return a `tactogram.evaluation.pictures.image_spread.ImageSpread`."""
        ...


@runtime_checkable
class TextureMapModel(Protocol):
    """A generator whose materials are autoregressive textures: streams synthesise them without end."""

    @property
    def maps(self) -> Sequence[TextureMap]:
        """One for each material of the run, in that order."""
        ...


# -- optional, of a predictor ---------------------------------------------------------------------------------


@runtime_checkable
class NoveltyReporter(Protocol):
    """A predictor that measures how far a signal or an image lies beyond what it was trained on."""

    def novelty(self, given: Signal | Image) -> float:
        """Return the share of features beyond all that was trained on, 0 to 1."""
        ...


@runtime_checkable
class FeatureReporter(Protocol):
    """A predictor that names the features it uses."""

    @property
    def feature_description(self) -> str:
        """The features, in words."""
        ...


def feature_description(model: object) -> str | None:
    """Return the features that a predictor uses, in words; None if it does not say."""
    return model.feature_description if isinstance(model, FeatureReporter) else None

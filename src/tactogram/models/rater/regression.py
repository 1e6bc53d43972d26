"""Kernel ridge regression of several words from one set of features; its form is chosen by cross-validation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PositiveFloat
from sklearn.kernel_ridge import KernelRidge
from sklearn.model_selection import GroupKFold

from tactogram.model import ModelConfig

Kernel = Literal["linear", "rbf"]


class Config(ModelConfig):
    """Candidate regressions, and their selection. All of it is ours: no publication describes this model."""

    kernels: tuple[Kernel, ...] = Field(default=("linear", "rbf"), min_length=1)
    """Ridge regression, linear and not. Trees were worse on VibViz (README)."""
    penalties: tuple[PositiveFloat, ...] = Field(
        default=(0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0), min_length=1
    )
    """Ridge penalties, for kernels of about 1 of an item with itself."""
    widths: tuple[PositiveFloat, ...] = Field(default=(0.1, 0.3, 1.0), min_length=1)
    """Of ``rbf``: factors of the mean squared difference of features."""
    folds: int = Field(default=5, ge=2, le=50)
    """Folds of the training items that choose kernel, width and penalty of each word."""
    trunk: Literal["auto", "efficientnet_lite0", "none"] = "auto"
    """For images: pooled features of a pretrained network, besides colour and texture; ``auto`` uses it if the extra
    ``vision`` is installed. The run records which was used, and stores the network's weights."""
    image_size: int = Field(default=128, ge=32, le=512)
    """Pixels of the shorter side of the trunk's input; smaller images are enlarged."""


Floats = NDArray[np.float64]
CONSTANT_FEATURE = 1e-9
"""Features that vary less are ignored."""


@dataclass(frozen=True)
class Candidate:
    """One form of the regression; a linear kernel has no ``width``."""

    kernel: Kernel
    penalty: float
    width: float = 0.0


@dataclass(frozen=True, eq=False)
class Scaling:
    """Scaling of features by their spread in training, limited to the range of the training data.

    Arrays are float64, shape (feature,). ``spread`` is 0 for a constant feature; ``weight`` is a feature's share in the
    kernel, where large blocks count no more than small ones.
    """

    low: Floats
    high: Floats
    mean: Floats
    spread: Floats
    weight: Floats

    @classmethod
    def of(cls, features: Floats, blocks: Sequence[int]) -> Scaling:
        """Return the scaling of training ``features``, shape (example, feature), in ``blocks`` of these sizes."""
        mean, spread = features.mean(0), features.std(0)
        spread[spread < CONSTANT_FEATURE] = 0
        weight = np.concatenate([np.full(size, 1 / (size * len(blocks))) for size in blocks])
        return cls(features.min(0), features.max(0), mean, spread, np.sqrt(weight))

    def apply(self, features: Floats) -> Floats:
        """Return scaled features of the same shape; the mean square of an example is about 1."""
        x = np.clip(features, self.low, self.high) - self.mean
        return np.asarray(
            self.weight * np.divide(x, self.spread, out=np.zeros_like(x), where=self.spread > 0)
        )

    def share_outside(self, features: Floats) -> float:
        """Return the share of features outside the range of the training data by more than their spread."""
        over = np.maximum(features - self.high, self.low - features)
        return float(np.mean(over > self.spread))


@dataclass(frozen=True, eq=False)
class Regression:
    """A fitted regression of each word.

    ``support`` are the scaled features of the training examples, shape (example, feature); ``coefficients`` have shape
    (example, word). ``intercepts``, shape (word,), are means of the training scores and so the constant guess.
    ``error``, shape (word,), is the mean absolute error over the folds; slightly optimistic, since it was minimised.
    """

    scaling: Scaling
    support: Floats
    coefficients: Floats
    intercepts: Floats
    chosen: Sequence[Candidate]
    error: Floats

    def predict(self, features: Floats) -> Floats:
        """Return scores, float64, shape (example, word), from features (example, feature); 0 to 1."""
        return np.clip(self.unbounded(features), 0, 1)

    def unbounded(self, features: Floats) -> Floats:
        """Return scores as `predict` does, not clipped: for ranking, where clipped scores would tie."""
        x = self.scaling.apply(features)
        columns = [
            kernel_of(x, self.support, form) @ self.coefficients[:, word]
            for word, form in enumerate(self.chosen)
        ]
        return np.asarray(np.stack(columns, axis=1) + self.intercepts)

    def state(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def of_state(cls, state: Mapping[str, Any]) -> Regression:
        arrays = {
            name: np.asarray(state[name], np.float64)
            for name in ("support", "coefficients", "intercepts", "error")
        }
        scaling = Scaling(**{k: np.asarray(v, np.float64) for k, v in state["scaling"].items()})
        return cls(scaling=scaling, chosen=[Candidate(**form) for form in state["chosen"]], **arrays)


def fit_regression(
    features: Floats,
    scores: Floats,
    *,
    items: Sequence[str],
    weights: Floats,
    blocks: Sequence[int],
    config: Config,
    rng: np.random.Generator,
) -> Regression:
    """Choose a form for each word by cross-validation over items, then fit it to all.

    Parameters
    ----------
    features : float64 array, shape (example, feature)
    scores : float64 array, shape (example, word)
        0 to 1; NaN where nobody scored: the word ignores that example.
    items : sequence of str, one per example
        Examples of one item are in one fold.
    weights : float64 array, shape (example,)
    blocks : sequence of int
        Sizes of the blocks of features, in order.
    rng : numpy Generator
        Shuffles the items into folds.
    """
    candidates = list(_candidates(config))
    words = scores.shape[1]
    numbers = np.unique(np.asarray(items), return_inverse=True)[1]
    shuffled = rng.permutation(numbers.max() + 1)[numbers]
    folds = min(config.folds, int(numbers.max()) + 1)
    scaling = Scaling.of(features, blocks)
    support = scaling.apply(features)
    coefficients = np.zeros((len(features), words))
    intercepts, error = np.zeros(words), np.zeros(words)
    chosen = [candidates[0]] * words
    patterns, which = np.unique(~np.isnan(scores), axis=1, return_inverse=True)
    for number, rows in enumerate(patterns.T):  # the scored examples, and the words that share them
        columns = np.flatnonzero(which.ravel() == number)
        y, w, group = scores[np.ix_(rows, columns)], weights[rows], shuffled[rows]
        parts = list(GroupKFold(min(folds, len(np.unique(group)))).split(y, groups=group))
        errors = np.array([_error(features[rows], y, w, parts, form, blocks) for form in candidates])
        intercepts[columns] = np.average(y, axis=0, weights=w)
        for column, best in zip(columns, errors.argmin(0), strict=True):
            form = candidates[best]
            gram = kernel_of(support[rows], support[rows], form)
            model = KernelRidge(alpha=form.penalty, kernel="precomputed")
            model.fit(gram, scores[rows, column] - intercepts[column], sample_weight=w)
            coefficients[rows, column] = model.dual_coef_
            chosen[column] = form
        error[columns] = errors.min(0)
    return Regression(scaling, support, coefficients, intercepts, chosen, error)


def kernel_of(x: Floats, support: Floats, form: Candidate) -> Floats:
    """Return the kernel of ``x``, (example, feature), with ``support``, shape (example, support)."""
    inner = x @ support.T
    if form.kernel == "linear":
        return np.asarray(inner)
    squares = (x**2).sum(1)[:, None] + (support**2).sum(1) - 2 * inner
    return np.asarray(np.exp(-form.width * np.maximum(squares, 0)))


def _candidates(config: Config) -> Iterator[Candidate]:
    for kernel in config.kernels:
        for width in config.widths if kernel == "rbf" else (0.0,):
            for penalty in config.penalties:
                yield Candidate(kernel, penalty, width)


def _error(
    features: Floats,
    scores: Floats,
    weights: Floats,
    parts: Sequence[tuple[NDArray[np.int64], NDArray[np.int64]]],
    form: Candidate,
    blocks: Sequence[int],
) -> Floats:
    """Return the weighted mean absolute error over the test parts, shape (word,)."""
    total = np.zeros(scores.shape[1])
    for train, test in parts:
        scaling = Scaling.of(features[train], blocks)
        x, unseen = scaling.apply(features[train]), scaling.apply(features[test])
        mean = np.average(scores[train], axis=0, weights=weights[train])
        model = KernelRidge(alpha=form.penalty, kernel="precomputed")
        model.fit(kernel_of(x, x, form), scores[train] - mean, sample_weight=weights[train])
        predicted = np.clip(model.predict(kernel_of(unseen, x, form)) + mean, 0, 1)
        total += weights[test] @ np.abs(predicted - scores[test])
    return np.asarray(total / weights.sum())

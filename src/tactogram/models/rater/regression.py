"""Kernel ridge regression of several words from one set of features; what fits best is chosen by items kept apart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sklearn.kernel_ridge import KernelRidge
from sklearn.model_selection import GroupKFold

from tactogram.models.rater.config import Config, Kernel

Floats = NDArray[np.float64]
CONSTANT_FEATURE = 1e-9
"""A feature that varies less is left out."""


@dataclass(frozen=True)
class Candidate:
    """One form of the regression: ``width`` is of no use to a linear kernel."""

    kernel: Kernel
    penalty: float
    width: float = 0.0


@dataclass(frozen=True, eq=False)
class Scaling:
    """Features brought to one scale: each by its spread in training, and held within what was met there.

    Parameters
    ----------
    low, high, mean, spread : float64 arrays, shape (feature,)
        ``spread`` is 0 for a feature that does not vary.
    weight : float64 array, shape (feature,)
        Share of a feature in the kernel; blocks of many features are to count no more than others.
    """

    low: Floats
    high: Floats
    mean: Floats
    spread: Floats
    weight: Floats

    @classmethod
    def of(cls, features: Floats, blocks: Sequence[int]) -> Scaling:
        """Return the scaling of training ``features`` (example, feature), in blocks of so many features."""
        mean, spread = features.mean(0), features.std(0)
        spread[spread < CONSTANT_FEATURE] = 0
        weight = np.concatenate([np.full(size, 1 / (size * len(blocks))) for size in blocks])
        return cls(features.min(0), features.max(0), mean, spread, np.sqrt(weight))

    def apply(self, features: Floats) -> Floats:
        """Return scaled features, shape as given; the mean square of an example is about 1."""
        held = np.clip(features, self.low, self.high) - self.mean
        return np.asarray(
            self.weight * np.divide(held, self.spread, out=np.zeros_like(held), where=self.spread > 0)
        )

    def beyond(self, features: Floats) -> float:
        """Return the share of features that lie outside of what was met in training, by more than a spread."""
        over = np.maximum(features - self.high, self.low - features)
        return float(np.mean(over > self.spread))


@dataclass(frozen=True, eq=False)
class Regression:
    """A fitted regression of each word.

    Parameters
    ----------
    scaling : Scaling
    support : float64 array, shape (example, feature)
        Scaled features of the training examples.
    coefficients : float64 array, shape (example, word)
    intercepts : float64 array, shape (word,)
        Mean of the training scores: also the constant guess.
    chosen : sequence of Candidate, one per word
    error : float64 array, shape (word,)
        Mean absolute error over items kept apart in choosing; a little optimistic, since it was chosen by.
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
        """Return scores as `predict`, but where they are: for putting in order, in which what is clipped is tied."""
        x = self.scaling.apply(features)
        columns = [
            kernel_of(x, self.support, form) @ self.coefficients[:, word]
            for word, form in enumerate(self.chosen)
        ]
        return np.asarray(np.stack(columns, axis=1) + self.intercepts)

    def state(self) -> dict[str, Any]:
        """Return all of it as arrays and numbers."""
        names = ("low", "high", "mean", "spread", "weight")
        return {
            "scaling": {name: getattr(self.scaling, name) for name in names},
            "support": self.support,
            "coefficients": self.coefficients,
            "intercepts": self.intercepts,
            "error": self.error,
            "chosen": [
                {"kernel": form.kernel, "penalty": form.penalty, "width": form.width} for form in self.chosen
            ],
        }

    @classmethod
    def of_state(cls, state: Mapping[str, Any]) -> Regression:
        """Return what `state` was taken of."""
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
    """Choose for each word by items kept apart, then fit to all.

    Parameters
    ----------
    features : float64 array, shape (example, feature)
    scores : float64 array, shape (example, word)
        0 to 1; NaN where nobody scored: that example is left out of that word.
    items : sequence of str, one per example
        Examples of one item are never on both sides.
    weights : float64 array, shape (example,)
    blocks : sequence of int
        How many features belong together, in order.
    config : Config
    rng : numpy Generator
        Shuffles the items into parts.
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
    for held, columns in _patterns(scores):
        y, w, group = scores[np.ix_(held, columns)], weights[held], shuffled[held]
        parts = list(GroupKFold(min(folds, len(np.unique(group)))).split(y, groups=group))
        errors = np.array([_error(features[held], y, w, parts, form, blocks) for form in candidates])
        intercepts[columns] = np.average(y, axis=0, weights=w)
        for column, best in zip(columns, errors.argmin(0), strict=True):
            form = candidates[best]
            gram = kernel_of(support[held], support[held], form)
            model = KernelRidge(alpha=form.penalty, kernel="precomputed")
            model.fit(gram, scores[held, column] - intercepts[column], sample_weight=w)
            coefficients[held, column] = model.dual_coef_
            chosen[column] = form
        error[columns] = errors.min(0)
    return Regression(scaling, support, coefficients, intercepts, chosen, error)


def kernel_of(x: Floats, support: Floats, form: Candidate) -> Floats:
    """Return how alike each of ``x`` (example, feature) is to each of ``support``, shape (example, support)."""
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


def _patterns(scores: Floats) -> Iterator[tuple[NDArray[np.bool_], NDArray[np.int64]]]:
    """Yield the examples that have a score, and the words of which it is just these."""
    given, which = np.unique(~np.isnan(scores), axis=1, return_inverse=True)
    for number in range(given.shape[1]):
        yield given[:, number], np.flatnonzero(which.ravel() == number)


def _error(
    features: Floats,
    scores: Floats,
    weights: Floats,
    parts: Sequence[tuple[NDArray[np.int64], NDArray[np.int64]]],
    form: Candidate,
    blocks: Sequence[int],
) -> Floats:
    """Return the weighted mean absolute error over parts that were not fitted to, shape (word,)."""
    total = np.zeros(scores.shape[1])
    for train, test in parts:
        scaling = Scaling.of(features[train], blocks)
        x, unseen = scaling.apply(features[train]), scaling.apply(features[test])
        mean = np.average(scores[train], axis=0, weights=weights[train])
        model = KernelRidge(alpha=form.penalty, kernel="precomputed")
        model.fit(kernel_of(x, x, form), scores[train] - mean, sample_weight=weights[train])
        said = np.clip(model.predict(kernel_of(unseen, x, form)) + mean, 0, 1)
        total += weights[test] @ np.abs(said - scores[test])
    return np.asarray(total / weights.sum())

"""Fit of a regression of ratings in one step; scores of a signal or an image on the raters' scale."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.model import Example, ImageExample, Kind, Model, SignalKind, Stage
from tactogram.models.rater.image_features import ImageFeatures
from tactogram.models.rater.regression import Config, Regression, fit_regression
from tactogram.models.rater.signal_features import signal_features
from tactogram.signal import Image, Signal
from tactogram.training.seeds import child_rng

Rateable = Example | ImageExample
FEWEST_ITEMS = 3


class RaterLearner(Model):
    """Predicted mean scores of a signal or an image; ``seed`` shuffles the items that choose the regression's form."""

    config: Config
    kind: Kind
    saved = ("words", "noise", "images")

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        if not self.kind.words or self.kind.scale is None:
            raise ParameterError("rater needs ratings in words and on a scale; got signals without ratings")
        self.low, self.high = self.kind.scale
        self.images = ImageFeatures(self.config.trunk, self.config.image_size)
        self.regression: Regression | None = None
        self.noise = np.full(len(self.words), np.nan)
        """Standard deviation between raters of one item, in points of the scale; NaN where no item has two raters."""

    def stages(self, examples: Sequence[Rateable]) -> tuple[Stage, ...]:
        rated = {e.item: ~np.isnan(e.rated.scores).all(0) for e in examples if e.rated is not None}
        if len(rated) < FEWEST_ITEMS:
            raise ParameterError(
                f"a rater needs at least {FEWEST_ITEMS} rated items to learn from, got {len(rated)}"
            )
        for word, items in zip(self.words, np.sum(list(rated.values()), axis=0), strict=True):
            if items < FEWEST_ITEMS:
                raise ParameterError(
                    f"a rater needs at least {FEWEST_ITEMS} items with a score in {word}, got {items}; omit the "
                    "word from the ratings"
                )
        return super().stages(examples)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        examples: Sequence[Rateable] = [example for example in batch if example.rated is not None]
        if not isinstance(self.kind, SignalKind):
            self.images.prepare()
        features, blocks = self._features(examples)
        means, noise, weights = _rating_statistics(examples)
        self.regression = fit_regression(
            features,
            means,
            items=[str(example.item) for example in examples],
            weights=weights,
            blocks=blocks,
            config=self.config,
            rng=child_rng(self.seed, "items"),
        )
        points = self.high - self.low
        self.noise = noise * points
        guess = np.nanmean(np.abs(means - self.regression.intercepts))
        return {
            "mae_in_choosing": float(self.regression.error.mean() * points),
            "mae_of_training_mean": float(guess * points),
        }

    def validate(self, examples: Sequence[Rateable]) -> dict[str, float]:
        """Return the mean absolute errors of the predictions and of the training mean, in points of the scale."""
        rated = [example for example in examples if example.rated is not None]
        if not rated:
            return {}
        predicted = np.array([list(self.predict(content_of(example)).values()) for example in rated])
        truth = self._on_scale(np.array([example.rated.means for example in rated if example.rated]))
        guess = self._on_scale(self._fitted.intercepts)
        return {
            "mae": float(np.nanmean(np.abs(predicted - truth))),
            "mae_of_training_mean": float(np.nanmean(np.abs(guess - truth))),
        }

    def state(self) -> dict[str, Any]:
        return super().state() | {"regression": {} if self.regression is None else self.regression.state()}

    def load_state(self, state: Mapping[str, Any]) -> None:
        super().load_state(state)
        self.regression = Regression.of_state(state["regression"]) if state["regression"] else None

    def predict(self, content: Signal | Image) -> Mapping[str, float]:
        scores = self._on_scale(self._fitted.predict(self._row(content))[0])
        return dict(zip(self.words, scores.tolist(), strict=True))

    def novelty(self, content: Signal | Image) -> float:
        """Return the share of features outside the range of the training data: near 0 for similar content.

        Features are limited to that range, so that a novel signal gets the scores of the nearest known ones; the larger
        this share, the less reliable they are.
        """
        return self._fitted.scaling.share_outside(self._row(content)[0])

    @property
    def feature_description(self) -> str:
        if isinstance(self.kind, SignalKind):
            return "third-octave levels, spectral shape, envelope and length"
        trunk = "" if self.images.used == "none" else f", pooled features of {self.images.used}"
        return f"colour and texture statistics{trunk}"

    @property
    def _fitted(self) -> Regression:
        if self.regression is None:
            raise ParameterError("rater has not been trained")
        return self.regression

    def _on_scale(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.low + shares * (self.high - self.low)

    def _features(self, examples: Sequence[Rateable]) -> tuple[NDArray[np.float64], tuple[int, ...]]:
        """Return the features, shape (example, feature), and the sizes of their blocks."""
        rows = np.array([self._row(content_of(example))[0] for example in examples])
        return rows, self.images.blocks or (rows.shape[1],)

    def _row(self, content: Signal | Image) -> NDArray[np.float64]:
        if isinstance(self.kind, SignalKind):
            if not isinstance(content, Signal):
                raise ParameterError(f"this rater is of signals, got {type(content).__name__}")
            self.kind.check(content)
            return signal_features(content)[None]
        if not isinstance(content, Image):
            raise ParameterError(f"this rater is of images, got {type(content).__name__}")
        return self.images([content])


def content_of(example: Rateable) -> Signal | Image:
    """Return the rated signal or image of an example."""
    return example.image if isinstance(example, ImageExample) else example.signal


def _rating_statistics(
    examples: Sequence[Rateable],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the target means, the noise of a rater, and the weight of each example.

    An item's weight is the reliability of its mean, ``t² / (t² + s² / n)`` with variance t² between items and s²
    between the n raters of one item (classical test theory), divided among the item's examples.

    Returns
    -------
    means : float64 array, shape (example, word)
    noise : float64 array, shape (word,)
        s; NaN where no item has two raters.
    weights : float64 array, shape (example,)
        1 in the mean.
    """
    rated = {str(e.item): e.rated for e in examples if e.rated is not None}
    means = {item: ratings.means for item, ratings in rated.items()}
    counts = {item: (~np.isnan(ratings.scores)).sum(0) for item, ratings in rated.items()}
    several = [ratings for ratings in rated.values() if len(ratings.raters) > 1]
    squares = sum((np.nansum((g.scores - g.means) ** 2, axis=0) for g in several), np.zeros(1))
    freedom = sum((np.maximum((~np.isnan(g.scores)).sum(0) - 1, 0) for g in several), np.zeros(1))
    with np.errstate(invalid="ignore", divide="ignore"):
        within = np.where(freedom > 0, squares / freedom, np.nan) + np.zeros(len(next(iter(means.values()))))
        between = np.nanvar(np.array(list(means.values())), axis=0) + 1e-6
        reliability = {
            item: float(np.nanmean(between / (between + np.nan_to_num(within) / np.maximum(n, 1))))
            for item, n in counts.items()
        }
    share = Counter(str(e.item) for e in examples)
    weights = np.array([reliability[str(e.item)] / share[str(e.item)] for e in examples])
    return (
        np.array([means[str(e.item)] for e in examples]),
        np.sqrt(within),
        weights / weights.mean(),
    )


build = RaterLearner

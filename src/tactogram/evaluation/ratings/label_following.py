"""Label fidelity of generated signals and images, scored by a rater model or by people.

The error alone says little, since scores near the middle have a small error for any label. So it is complemented by the
error of the same scores against other labels, and by correlation and slope of single scores over labels, without each
word's mean. Means over noises would hide that a generator almost ignores its label: a tiny shift in every image, which
nobody would see, gives a high correlation of means.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LabelFidelity:
    """Agreement of scores of generated items with the requested ones."""

    error: float
    """Mean absolute error, in units of the scores."""
    error_of_others: float
    """Mean absolute error against every other label; larger than ``error`` if labels are followed."""
    correlation: float
    """Correlation with the label over labels, draws and words, without each word's mean; 0 for constant scores."""
    slope: float
    """Change of the scores per change of the label: 1 follows it fully, 0 not at all."""
    by_word: tuple[float, ...]
    """Correlation of each word."""

    def as_dict(self) -> dict[str, float | list[float]]:
        """Return plain values for JSON."""
        return {**asdict(self), "by_word": list(self.by_word)}


def label_fidelity(asked: Array, said: Array) -> LabelFidelity:
    """Return how closely ``said`` follows ``asked``.

    Raises `ParameterError` if the shapes do not fit.

    Parameters
    ----------
    asked : float array, shape (label, word)
        At least 3 labels.
    said : float array, shape (label, draw, word)
        Scores of items generated for each label from several noises.
    """
    if said.ndim != 3 or asked.shape != (len(said), said.shape[2]) or len(asked) < 3:
        raise ParameterError(
            "asked must be (label, word) of at least 3 labels and said (label, draw, word), "
            f"got {asked.shape} and {said.shape}"
        )
    errors = np.abs(said[:, None] - asked[None, :, None]).mean((2, 3))  # of each score against each label
    own = np.eye(len(asked), dtype=bool)
    wanted = np.broadcast_to((asked - asked.mean(0))[:, None], said.shape)
    heard = said - said.mean((0, 1))
    by_word = tuple(_correlation(wanted[..., word], heard[..., word]) for word in range(asked.shape[1]))
    power = float(np.sum(wanted**2))
    return LabelFidelity(
        float(errors[own].mean()),
        float(errors[~own].mean()),
        _correlation(wanted, heard),
        float(np.sum(wanted * heard)) / power if power > 0 else 0.0,
        by_word,
    )


def _correlation(a: Array, b: Array) -> float:
    """Return the correlation of two deviations from a mean; 0 where one does not vary."""
    power = float(np.sqrt(np.sum(a**2) * np.sum(b**2)))
    return float(np.sum(a * b) / power) if power > 1e-12 else 0.0

"""Label fidelity of generated signals and images, scored by a rater model or by people.

The error alone says little: scores near the middle have a small one whatever was asked. So beside it stand the error of
the same scores against other labels, and how single scores go with what was asked, each word's own mean taken away: as
a correlation, and as a slope. Single ones, not means over noises: a generator that hardly looks at its label may still
turn every image a hair the right way, which means show and nobody would see.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LabelFidelity:
    """Agreement of scores of generated items with the requested ones.

    Parameters
    ----------
    error : float
        Mean absolute error, in what the scores are in.
    error_of_others : float
        Of the same scores against every other label: what following is worth is the difference.
    correlation : float
        Of each score with the label, over labels, draws and words, each word's mean taken away; 0 where the scores do
        not vary.
    slope : float
        By how much scores change per change of the label: 1 follows it fully, 0 not at all.
    by_word : tuple of float
        The correlation of each word by itself.
    """

    error: float
    error_of_others: float
    correlation: float
    slope: float
    by_word: tuple[float, ...]

    def as_dict(self) -> dict[str, float | list[float]]:
        """Return it as plain values, for JSON."""
        return {**asdict(self), "by_word": list(self.by_word)}


def label_fidelity(asked: Array, said: Array) -> LabelFidelity:
    """Return how far ``said`` follows ``asked``.

    Parameters
    ----------
    asked : float array, shape (label, word)
        At least 3 labels.
    said : float array, shape (label, draw, word)
        Scores of what was generated for each label from several noises.

    Raises
    ------
    ParameterError
        If the shapes do not fit.
    """
    if said.ndim != 3 or asked.shape != (len(said), said.shape[2]) or len(asked) < 3:
        raise ParameterError(
            "asked must be (label, word) of at least 3 labels and said (label, draw, word), "
            f"got {asked.shape} and {said.shape}"
        )
    errors = np.abs(said[:, None] - asked[None, :, None]).mean((2, 3))  # of what was said, against each label
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

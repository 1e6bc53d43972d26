"""Examples that models are trained and evaluated on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tactogram.model.conditions import Condition
from tactogram.signal import Image, Signal


@dataclass(frozen=True, eq=False)
class ItemRatings:
    """Ratings of one item.

    Parameters
    ----------
    words : tuple of str
        In the same order for all items of a data set.
    raters : tuple of str
    scores : float64 array, shape (rater, word)
        0 (lowest on the scale) to 1 (highest); NaN where a rater gave none.
    """

    words: tuple[str, ...]
    raters: tuple[str, ...]
    scores: NDArray[np.float64]

    @property
    def means(self) -> NDArray[np.float64]:
        """Mean over the raters who gave a score, 0 to 1, shape (word,); NaN if none did."""
        scored = ~np.isnan(self.scores)
        with np.errstate(invalid="ignore"):
            means: NDArray[np.float64] = np.where(scored, self.scores, 0).sum(0) / scored.sum(0)
        return means


@dataclass(frozen=True, eq=False)
class Example:
    """One prepared segment of a recording.

    Parameters
    ----------
    id : str
        The recording it was cut from.
    signal : Signal
        Prepared: stream, axes, band and rate are those of the recipe.
    material : str, optional
        Its class.
    condition : mapping
        Other conditions of the recording, by names of `condition_types`.
    photographs : sequence of Image
        Photographs of the same surface that this part of the split may use, cut to the region it may use. Decoded on
        access, so that an example holds no pixels in memory.
    item : str, optional
        Name in the ratings: a surface, or a vibration that was rated itself and has no material.
    rated : ItemRatings, optional
        Ratings of ``item``.
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
    """One rated image.

    Parameters
    ----------
    id : str
        The photograph's key in its store.
    photographs : sequence of Image
        The one image; decoded on access.
    item : str
        Name in the ratings.
    rated : ItemRatings
    """

    id: str
    photographs: Sequence[Image]
    item: str
    rated: ItemRatings

    @property
    def image(self) -> Image:
        """The image, decoded now."""
        return self.photographs[0]

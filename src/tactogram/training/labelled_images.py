"""Rated images as network input, all in memory: squares of one size in -1 to 1, with labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from tactogram.errors import ParameterError
from tactogram.model import WHOLE_BATCH, BatchShare, ImageExample
from tactogram.signal import Image
from tactogram.training.seeds import child_rng

Pixels = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class LabelledImages:
    """Images and their labels.

    Parameters
    ----------
    pixels : uint8 array, shape (image, 3, size, size)
    labels : float32 array, shape (image, word), 0 to 1
        Means over the raters of an image: of yes/no ratings the share that affirmed a word (Hatori et al. 2025, Sec.
        II-B, which calls a label "one-hot": that would be a single word and cannot be meant). NaN where nobody scored
        a word, if these are allowed.
    """

    pixels: Pixels
    labels: NDArray[np.float32]

    @classmethod
    def of(
        cls, examples: Sequence[ImageExample], words: Sequence[str], size: int, *, partial: bool = False
    ) -> LabelledImages:
        """Return examples decoded, cut and scaled; refuses fewer than 2, and other words.

        Missing words are NaN if ``partial``, else refused.
        """
        if len(examples) < 2:
            raise ParameterError(f"at least 2 rated images are needed to learn from, got {len(examples)}")
        labels = np.stack([_label(example, words, partial=partial) for example in examples])
        return cls(np.stack([square(example.image, size) for example in examples]), labels)

    def batch(
        self, number: int, size: int, *, seed: int, share: BatchShare = WHOLE_BATCH
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return images, (batch, 3, row, column) in -1 to 1, and labels: the share of batch ``number`` from 0 on.

        Batches are cut from consecutive random orders of the images, so that all occur equally often.
        """
        count = len(self.pixels)
        places = share.places(np.arange(number * size, (number + 1) * size), size)
        orders = {
            turn: child_rng(seed, "order", int(turn)).permutation(count) for turn in set(places // count)
        }
        chosen = np.array([orders[place // count][place % count] for place in places])
        return as_floats(self.pixels[chosen]), self.labels[chosen]


def as_floats(pixels: Pixels) -> NDArray[np.float32]:
    """Return 0 to 255 as -1 to 1, the range of tanh (Hatori et al. 2025, Sec. II-C)."""
    return pixels.astype(np.float32) / 127.5 - 1


def as_pixels(values: NDArray[np.float32]) -> Pixels:
    """Return -1 to 1 as 0 to 255, rounded: the inverse of `as_floats`."""
    pixels: Pixels = np.clip(np.rint((values + 1) * 127.5), 0, 255).astype(np.uint8)
    return pixels


def square(image: Image, size: int) -> Pixels:
    """Return the middle square of an image, scaled to ``size``: uint8, (3, size, size).

    Assumed: Hatori et al. 2025 do not state how they cut images to 64 x 64.
    """
    rows, columns = image.size
    side = min(rows, columns)
    top, left = (rows - side) // 2, (columns - side) // 2
    cut = image.cut(top, left, top + side, left + side).pixels
    if side != size:
        scaled = Pillow.fromarray(np.ascontiguousarray(cut)).resize((size, size), Pillow.Resampling.BICUBIC)
        cut = np.asarray(scaled)
    return np.ascontiguousarray(cut.transpose(2, 0, 1))


def _label(example: ImageExample, words: Sequence[str], *, partial: bool) -> NDArray[np.float32]:
    if example.rated.words != tuple(words):
        raise ParameterError(
            f"{example.item}: must be rated in {', '.join(words)}, got {', '.join(example.rated.words)}"
        )
    means = example.rated.means
    if np.isnan(means).any() and not partial:
        missing = ", ".join(word for word, mean in zip(words, means, strict=True) if np.isnan(mean))
        raise ParameterError(f"{example.item}: nobody scored it in {missing}; rate it or omit it")
    return means.astype(np.float32)

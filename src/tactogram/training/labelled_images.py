"""Rated images as network input, and the learner of generators of such images from scores."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from tactogram.errors import ParameterError
from tactogram.model import (
    WHOLE_BATCH,
    BatchShare,
    Condition,
    ImageExample,
    ImageKind,
    Model,
    check_condition,
    unit_scores,
)
from tactogram.signal import Image
from tactogram.training.seeds import child_rng

Pixels = NDArray[np.uint8]

EVALUATED = 64
"""Most images whose distances measure the spread of real ones."""
LABELS, NOISES = 12, 8
"""Pairings that measure the spread of generated images: as many labels as Hatori et al. 2025 have plates."""


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
        chosen = np.array([orders[position // count][position % count] for position in places])
        return as_floats(self.pixels[chosen]), self.labels[chosen]


class RatedImageLearner(Model):
    """Mean ratings of the training images, and the images that scores of words describe.

    ``partial`` allows that words are missing; a model adds its network, as `make`, and the size of its noise.
    """

    kind: ImageKind
    divides_batches = True
    saved: ClassVar[tuple[str, ...]] = ("words", "means", "real_spread")
    partial = False

    def __init__(self, config: Any, kind: ImageKind, *, seed: int, device: Any = "cpu") -> None:
        super().__init__(config, kind, seed=seed, device=device)
        self.means = np.full((len(kind.items), len(kind.words)), np.nan)
        self.real_spread = 0.0
        """Mean distance of real images, of which at most `EVALUATED` are compared."""

    @property
    def noise_size(self) -> int:
        """Standard normal numbers that one image is made of."""
        raise NotImplementedError

    def make(self, noise: NDArray[np.float32], scores: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return images, (image, 3, row, column), about -1 to 1.

        ``noise`` is (image, noise), standard normal; ``scores`` are (image, word), 0 to 1, NaN if missing.
        """
        raise NotImplementedError

    @property
    def rated_means(self) -> dict[str, NDArray[np.float64]]:
        """Mean scores of each training image, 0 to 1, shape (word,); NaN where nobody gave one."""
        return dict(zip(self.kind.items, self.means, strict=True))

    def compared(self, examples: Sequence[ImageExample], images: LabelledImages) -> NDArray[np.float32]:
        """Store the labels of training images, and return some of them, whose distances are `real_spread`."""
        index_of = {item: number for number, item in enumerate(self.kind.items)}
        for example, label in zip(examples, images.labels, strict=True):
            if example.item in index_of:
                self.means[index_of[example.item]] = label
        count = len(images.pixels)
        return as_floats(images.pixels[np.linspace(0, count - 1, min(count, EVALUATED)).round().astype(int)])

    def pairings(self, labels: NDArray[np.floating]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return some of ``labels``, (label, word), and noises, whose pairings measure the spread of `make`."""
        rng = child_rng(0, "spread")
        some = rng.permutation(len(labels))[:LABELS]
        noises = rng.standard_normal((NOISES, self.noise_size)).astype(np.float32)
        return labels[some].astype(np.float32), noises

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Image:
        """Return an image that evokes ``words``, each on the scale of the training ratings."""
        check_condition(condition, needs=() if self.partial else ("words",), takes=("words",))
        if seconds is not None:
            raise ParameterError.must("seconds", f"be omitted, an image has no length; got {seconds:g}")
        scores = unit_scores(condition.get("words") or {}, self.kind, partial=self.partial)
        noise = child_rng(seed, "noise").standard_normal((1, self.noise_size)).astype(np.float32)
        generated = self.make(noise, scores[None].astype(np.float32))
        return Image(as_pixels(generated[0]).transpose(1, 2, 0))


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

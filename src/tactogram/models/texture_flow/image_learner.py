"""Images: training on rated images; images that scores of words describe, of which any may be missing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.image_spread import ImageSpread, image_spread, mean_distance
from tactogram.model import (
    WHOLE_BATCH,
    BatchShare,
    Condition,
    ImageExample,
    ImageKind,
    Stage,
    check_condition,
    check_state,
    unit_scores,
)
from tactogram.models.texture_flow.config import Config
from tactogram.models.texture_flow.flow_model import FlowModel
from tactogram.models.texture_flow.networks import VelocityUNet
from tactogram.signal import Image
from tactogram.training.labelled_images import LabelledImages, as_floats, as_pixels
from tactogram.training.seeds import child_rng, torch_seeded

COLOURS = 3
"""Red, green, blue."""
LARGEST_SCORE = 4.0
"""Scores count as at most so many standard deviations of the word's from its mean."""
LEAST_DEVIATION = 1e-3
"""Of the colours, and of the scores of a word."""
SPREAD_OF = 64
"""Most images whose distances measure the spread of real ones."""
LABELS, NOISES = 12, 8
"""Pairings that measure the spread of generated images, as in `tactile_image_cgan`."""


class ImageFlowLearner:
    """Mean and deviation of the pixels, mean ratings of the training images, and the flow that generates images."""

    def __init__(
        self, config: Config, kind: ImageKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        if config.size % config.multiple:
            raise ParameterError(
                f"config.size must be a multiple of {config.multiple} for these widths, got {config.size}"
            )
        self.config, self.kind, self.seed, self.items = config, kind, seed, kind.items
        self.share = WHOLE_BATCH
        self.means = np.full((len(kind.items), len(kind.words)), np.nan)
        self.pixels = torch.tensor([*[0.0] * COLOURS, 1.0])
        """Mean of each colour, and the standard deviation of all, -1 to 1."""
        self.real_spread = 0.0
        with torch_seeded(seed, "weights"):
            network = VelocityUNet(config, channels=COLOURS, labels=2 * len(kind.words), cosines=0)
        self.flow = FlowModel(network, config, device=torch.device(device))

    def setup(self, fabric: Any) -> None:
        self.flow.setup(fabric)
        self.share = BatchShare.of_process(fabric)

    # -- training ----------------------------------------------------------------------------------------

    def stages(self, examples: Sequence[ImageExample]) -> tuple[Stage, ...]:
        self._images(examples[:2])
        return Stage("fit", 1), *self.flow.stages

    def batches(
        self, stage: Stage, examples: Sequence[ImageExample], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        images = self._images(examples)
        if stage.name == "fit":
            yield examples, images
            return
        for number in range(start, stage.steps):
            pixels, scores = images.batch(number, self.config.batch_size, seed=seed, share=self.share)
            yield number, self._whitened(pixels), torch.from_numpy(scores)

    def _images(self, examples: Sequence[ImageExample]) -> LabelledImages:
        return LabelledImages.of(examples, self.kind.words, self.config.size, partial=True)

    def _whitened(self, pixels: NDArray[np.float32]) -> Tensor:
        """Return images, (image, 3, row, column), with mean 0 and deviation 1 over those of training."""
        return (torch.from_numpy(pixels) - self.pixels[:COLOURS, None, None]) / self.pixels[-1]

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        if stage.name == "fit":
            return self._fit(*batch)
        number, images, scores = batch
        label = self._label(self._with_some_missing(scores))
        return {"loss": self.flow.step(stage, number, images, label)}

    def _fit(self, examples: Sequence[ImageExample], images: LabelledImages) -> dict[str, float]:
        place = {item: number for number, item in enumerate(self.items)}
        for example, scores in zip(examples, images.labels, strict=True):
            if example.item in place:
                self.means[place[example.item]] = scores
        pixels = as_floats(images.pixels)
        colours = pixels.mean((0, 2, 3))
        deviation = max(float((pixels - colours[:, None, None]).std()), LEAST_DEVIATION)
        self.pixels = torch.tensor([*colours.tolist(), deviation])
        some = np.linspace(0, len(pixels) - 1, min(len(pixels), SPREAD_OF)).round().astype(int)
        self.real_spread = mean_distance(pixels[some])
        return {"real_spread": self.real_spread}

    def _with_some_missing(self, scores: Tensor) -> Tensor:
        """Return scores, (image, word), of which those of some images, and some words of others, are NaN."""
        count, words = scores.shape
        hidden = torch.rand(count, words) < torch.rand(count, 1)
        incomplete = torch.rand(count, 1) < self.config.incomplete
        dropped = torch.rand(count, 1) < self.config.dropped
        return scores.masked_fill((hidden & incomplete) | dropped, torch.nan)

    def _label(self, scores: Tensor) -> Tensor:
        """Return scores, (image, word), in standard deviations of the word's; then a 1 for each that is known."""
        known = torch.from_numpy(self.means).float()
        mean = known.nanmean(0)
        deviation = (known - mean).square().nanmean(0).sqrt().clamp_min(LEAST_DEVIATION)
        standard = ((scores - mean) / deviation).clamp(-LARGEST_SCORE, LARGEST_SCORE)
        return torch.cat((standard.nan_to_num(0.0), (~standard.isnan()).float()), 1)

    def validate(self, examples: Sequence[ImageExample]) -> dict[str, float]:
        """Return the loss on unseen images; well above that of the training images if these were memorised."""
        if len(examples) < 2:
            return {}
        images = self._images(examples)
        label = self._label(torch.from_numpy(images.labels))
        return {"loss_unseen": self.flow.loss(self._whitened(as_floats(images.pixels)), label)}

    def image_spread(self) -> ImageSpread:
        """Return the spread of images by noise and by label, for labels of training images."""
        labels = self.means[~np.isnan(self.means).any(1)].astype(np.float32)
        rng = child_rng(0, "spread")
        some = rng.permutation(len(labels))[:LABELS]
        noises = rng.standard_normal((NOISES, COLOURS * self.config.size**2)).astype(np.float32)
        return image_spread(self.make, labels[some], noises, real=self.real_spread)

    def state(self) -> dict[str, Any]:
        return {
            "words": list(self.kind.words),
            "means": self.means,
            "pixels": self.pixels,
            "real_spread": self.real_spread,
            **self.flow.state(),
            "optimisers": [self.flow.optimiser.state_dict()],
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        check_state(state["words"], self.kind.words)
        self.means, self.pixels = np.asarray(state["means"], np.float64), state["pixels"]
        self.real_spread = float(state["real_spread"])
        self.flow.load_state(state)
        for saved in state.get("optimisers", ()):
            self.flow.optimiser.load_state_dict(saved)

    # -- use ---------------------------------------------------------------------------------------------

    @property
    def rated_means(self) -> dict[str, NDArray[np.float64]]:
        """Mean scores of each training image, 0 to 1, shape (word,); NaN where nobody gave one."""
        return dict(zip(self.items, self.means, strict=True))

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Image:
        """Return an image that evokes ``words``, each on the scale of the training ratings; any may be missing."""
        check_condition(condition, takes=("words",))
        if seconds is not None:
            raise ParameterError(f"seconds must be omitted, an image has no length; got {seconds:g}")
        scores = unit_scores(condition.get("words") or {}, self.kind, partial=True)
        noise = child_rng(seed, "noise").standard_normal((1, COLOURS * self.config.size**2))
        made = self.make(noise.astype(np.float32), scores[None].astype(np.float32))
        return Image(as_pixels(made[0]).transpose(1, 2, 0))

    def make(self, noise: NDArray[np.float32], scores: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return images, (image, 3, row, column), about -1 to 1.

        ``noise`` is (image, pixel and colour), standard normal; ``scores`` are (image, word), 0 to 1, NaN if missing.
        """
        side = self.config.size
        shaped = torch.from_numpy(noise).view(-1, COLOURS, side, side)
        made = self.flow.sample(shaped, self._label(torch.from_numpy(scores))).cpu()
        return np.asarray((made * self.pixels[-1] + self.pixels[:COLOURS, None, None]).numpy())

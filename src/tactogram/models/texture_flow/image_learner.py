"""Images: training on rated images; images that scores of words describe, of which any may be missing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.distances import ImageSpread, image_spread, mean_distance
from tactogram.model import ImageExample, ImageKind, Stage
from tactogram.models.texture_flow.config import Config
from tactogram.models.texture_flow.flow_model import FlowLearner, FlowModel
from tactogram.models.texture_flow.networks import VelocityUNet
from tactogram.training.labelled_images import LabelledImages, RatedImageLearner, as_floats
from tactogram.training.seeds import torch_seeded

COLOURS = 3
"""Red, green, blue."""
LARGEST_SCORE = 4.0
"""Scores count as at most so many standard deviations of the word's from its mean."""
LEAST_DEVIATION = 1e-3
"""Of the colours, and of the scores of a word."""


class ImageFlowLearner(FlowLearner, RatedImageLearner):
    """Mean and deviation of the pixels, mean ratings of the training images, and the flow that generates images."""

    config: Config
    partial = True
    saved = (*RatedImageLearner.saved, "pixels")

    def __init__(
        self, config: Config, kind: ImageKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        if config.size % config.multiple:
            raise ParameterError(
                f"config.size must be a multiple of {config.multiple} for these widths, got {config.size}"
            )
        super().__init__(config, kind, seed=seed, device=device)
        self.pixels = torch.tensor([*[0.0] * COLOURS, 1.0])
        """Mean of each colour, and the standard deviation of all, -1 to 1."""
        with torch_seeded(seed, "weights"):
            network = VelocityUNet(config, channels=COLOURS, labels=2 * len(kind.words), cosines=0)
        self.flow = FlowModel(network, config, device=torch.device(device))

    @property
    def noise_size(self) -> int:
        return COLOURS * self.config.size**2

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
        pixels = as_floats(images.pixels)
        colours = pixels.mean((0, 2, 3))
        deviation = max(float((pixels - colours[:, None, None]).std()), LEAST_DEVIATION)
        self.pixels = torch.tensor([*colours.tolist(), deviation])
        self.real_spread = mean_distance(self.compared(examples, images))
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
        labels = self.means[~np.isnan(self.means).any(1)]
        return image_spread(self.make, *self.pairings(labels), real=self.real_spread)

    def make(self, noise: NDArray[np.float32], scores: NDArray[np.float32]) -> NDArray[np.float32]:
        side = self.config.size
        shaped = torch.from_numpy(noise).view(-1, COLOURS, side, side)
        sampled = self.flow.sample(shaped, self._label(torch.from_numpy(scores))).cpu()
        return np.asarray((sampled * self.pixels[-1] + self.pixels[:COLOURS, None, None]).numpy())

"""The conditional GAN of Sec. II-C: from ten scores and noise to an image.

Letters in shapes: B batch, Z noise, W words, S rows and columns.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor, nn

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.distances import ImageSpread, image_spread, mean_distance
from tactogram.model import ImageExample, ImageKind, Kind, Stage
from tactogram.models.tactile_image_cgan.config import Config
from tactogram.models.tactile_image_cgan.seen_features import seen_features
from tactogram.nn.adversarial_networks import AdversarialPair
from tactogram.nn.initial_weights import normal_
from tactogram.nn.score_regression import ScoreRegression
from tactogram.training.labelled_images import LabelledImages, RatedImageLearner, as_floats
from tactogram.training.seeds import torch_seeded

KERNEL = 4
"""Rows and columns of every kernel. Tables 2 and 3."""
COLOURS = 3
"""Red, green, blue."""


class Generator(nn.Module):
    """Table 2: noise and scores to an image in -1 to 1."""

    def __init__(self, config: Config, words: int) -> None:
        super().__init__()
        first, *_, last = config.widths
        layers: list[nn.Module] = [nn.ConvTranspose2d(config.noise + words, first, KERNEL, 1, 0)]
        for into, out in pairwise(config.widths):
            layers += [nn.BatchNorm2d(into), nn.LeakyReLU(config.leak)]
            layers += [nn.ConvTranspose2d(into, out, KERNEL, 2, 1)]
        layers += [nn.BatchNorm2d(last), nn.LeakyReLU(config.leak)]
        layers += [nn.ConvTranspose2d(last, COLOURS, KERNEL, 2, 1), nn.Tanh()]
        self.layers = nn.Sequential(*layers)
        normal_(self, config.gain)

    def forward(self, noise: Tensor, scores: Tensor) -> Tensor:
        """Return images, -1 to 1: (batch, noise) and scores (batch, word), 0 to 1 -> (batch, 3, size, size)."""
        inputs = torch.cat((noise, scores), 1)[:, :, None, None]  # B, Z + W, 1, 1
        images: Tensor = self.layers(inputs)  # B, 3, S, S
        return images


class Discriminator(nn.Module):
    """Table 3: an image with its scores, each score as a plane, to one number.

    The final sigmoid of Table 3 is computed with the loss, where it loses no digits: `forward` returns its input.
    """

    def __init__(self, config: Config, words: int) -> None:
        super().__init__()
        first, *_, last = widths = config.widths[::-1]
        self.image_weight = config.image_weight
        layers: list[nn.Module] = [nn.Conv2d(COLOURS + words, first, KERNEL, 2, 1), nn.LeakyReLU(config.leak)]
        for into, out in pairwise(widths):
            layers += [nn.Conv2d(into, out, KERNEL, 2, 1), nn.BatchNorm2d(out), nn.LeakyReLU(config.leak)]
        layers.append(nn.Conv2d(last, 1, KERNEL, 1, 0))
        self.layers = nn.Sequential(*layers)
        normal_(self, config.gain)

    def forward(self, images: Tensor, scores: Tensor) -> Tensor:
        """Return the logit of being real, (batch,), of images (batch, 3, size, size) with scores (batch, word).

        Real and generated images alike are weighted here (Sec. II-C).
        """
        planes = scores[:, :, None, None].expand(-1, -1, *images.shape[2:])  # B, W, S, S
        logits: Tensor = self.layers(torch.cat((self.image_weight * images, planes), 1))  # B, 1, 1, 1
        return logits.flatten()  # B


class TactileImageLearner(RatedImageLearner):
    """Generator and discriminator, and the mean ratings of the training images."""

    config: Config
    saved = (*RatedImageLearner.saved, "gan")

    def __init__(self, config: Config, kind: Kind, *, seed: int, device: str | torch.device = "cpu") -> None:
        if not isinstance(kind, ImageKind):
            raise ParameterError("tactile_image_cgan learns from rated images, got signals")
        super().__init__(config, kind, seed=seed, device=device)
        self.regression: ScoreRegression | None = None  # of real images, with `Config.words_weight`
        self._cached: tuple[Any, LabelledImages] | None = None
        with torch_seeded(seed, "weights"):
            self.gan = AdversarialPair(
                Generator(config, len(kind.words)),
                Discriminator(config, len(kind.words)),
                learning_rate=config.learning_rate,
                betas=config.betas,
                epsilon=config.epsilon,
                device=torch.device(device),
            )

    def parts(self) -> Sequence[Any]:
        return (self.gan,)

    @property
    def noise_size(self) -> int:
        return self.config.noise

    def stages(self, examples: Sequence[ImageExample]) -> tuple[Stage, ...]:
        self._images(examples)
        return (Stage("gan", self.config.updates),)

    def _images(self, examples: Sequence[ImageExample]) -> LabelledImages:
        """Return the examples, decoded once, and store their labels and spread."""
        if self._cached is None or self._cached[0] is not examples:
            images = LabelledImages.of(examples, self.kind.words, self.config.size)
            self._cached = (examples, images)
            self.real_spread = mean_distance(self.compared(examples, images))
        return self._cached[1]

    def batches(
        self, stage: Stage, examples: Sequence[ImageExample], *, seed: int, start: int = 0
    ) -> Iterator[tuple[Tensor, Tensor]]:
        images = self._images(examples)
        if self.config.words_weight:
            real = torch.from_numpy(as_floats(images.pixels)), torch.from_numpy(images.labels)
            shown, known = (part.to(self.gan.device) for part in real)
            self.regression = ScoreRegression(seen_features(shown), known)
        for number in range(start, stage.steps):
            pixels, labels = images.batch(number, self.config.batch_size, seed=seed, share=self.share)
            yield torch.from_numpy(pixels), torch.from_numpy(labels)

    def step(self, stage: Stage, batch: tuple[Tensor, Tensor]) -> dict[str, float]:
        """Update the discriminator, then the generator against it, on one draw of noise and of random scores.

        Fakes have uniform random scores, real images their own (Sec. II-C). The order of the networks, and that both
        see one draw, is assumed. Both losses are Eq. 2; the generator's has the label of real images. With
        `Config.words_weight` it has the error of the scores predicted of its images, too.
        """
        gan = self.gan
        gan.train(0.0)
        images, labels = (part.to(gan.device) for part in batch)  # B, 3, S, S; B, W
        noise = torch.randn(len(images), self.config.noise, device=gan.device)
        scores = torch.rand_like(labels)
        generated = gan.generator(noise, scores)  # B, 3, S, S
        real, fake = gan.discriminator(images, labels), gan.discriminator(generated.detach(), scores)  # B
        loss_d = _cross_entropy(real, 1.0) + _cross_entropy(fake, 0.0)
        gan.descend(1, loss_d)
        with gan.fixed_discriminator():
            loss_g = _cross_entropy(gan.discriminator(generated, scores), 1.0)
        right = ((real > 0).float().mean() + (fake < 0).float().mean()) / 2
        losses = {"generator": loss_g.item(), "discriminator": loss_d.item(), "correct": right.item()}
        if self.regression is not None:
            words = self.config.words_weight * self.regression.loss(seen_features(generated.float()), scores)
            loss_g, losses["words"] = loss_g + words, words.item()
        gan.descend(0, loss_g)
        return losses

    def validate(self, examples: Sequence[ImageExample]) -> dict[str, float]:
        """Return the spread of images for labels of ``examples`` or, if there are too few, of training."""
        return self.image_spread(examples).as_dict()

    def image_spread(self, examples: Sequence[ImageExample] = ()) -> ImageSpread:
        """Return the spread of images by noise and by label; its ``collapse`` names a collapse.

        Examples without a score in some word have no label and are ignored.
        """
        rated = [means for e in examples if np.isfinite(means := e.rated.means).all()]
        labels = np.stack(rated) if len(rated) > 1 else self.means[~np.isnan(self.means).any(1)]
        return image_spread(self.make, *self.pairings(labels), real=self.real_spread)

    @torch.inference_mode()
    def make(self, noise: NDArray[np.float32], scores: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return images of noise (image, noise) and scores (image, word) in 0 to 1: (image, 3, row, column).

        Batch normalisation uses the statistics of training, so that an image is the same in any batch. Assumed.
        """
        inputs = (torch.from_numpy(part).to(self.gan.device) for part in (noise, scores))
        images: NDArray[np.float32] = self.gan.bare_generator.eval()(*inputs).float().cpu().numpy()
        return images


def _cross_entropy(scores: Tensor, label: float) -> Tensor:
    """Return Eq. 2 of the sigmoid of ``scores``, mean over the batch."""
    return F.binary_cross_entropy_with_logits(scores.float(), torch.full_like(scores, label).float())


build = TactileImageLearner

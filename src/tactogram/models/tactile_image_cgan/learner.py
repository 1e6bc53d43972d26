"""The conditional GAN of Sec. II-C: from ten scores and noise to an image.

Letters in shapes: B batch, Z noise, W words, S rows and columns, C and D channels of the discriminator's first and last
hidden layer.
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
from tactogram.nn.adversarial_networks import AdversarialPair
from tactogram.nn.initial_weights import normal_
from tactogram.nn.patch_discriminator import LabelProjection
from tactogram.training.labelled_images import LabelledImages, RatedImageLearner
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
        layers: list[nn.Module] = [
            nn.ConvTranspose2d(config.noise + words, first, KERNEL, 1, 0, bias=config.biases)
        ]
        for into, out in pairwise(config.widths):
            layers += [
                nn.BatchNorm2d(into),
                nn.LeakyReLU(config.leak),
                nn.ConvTranspose2d(into, out, KERNEL, 2, 1, bias=config.biases),
            ]
        layers += [
            nn.BatchNorm2d(last),
            nn.LeakyReLU(config.leak),
            nn.ConvTranspose2d(last, COLOURS, KERNEL, 2, 1, bias=config.biases),
            nn.Tanh(),
        ]
        self.layers = nn.Sequential(*layers)
        normal_(self, config.gain)

    def forward(self, noise: Tensor, scores: Tensor) -> Tensor:
        """Return images, -1 to 1: (batch, noise) and scores (batch, word), 0 to 1 -> (batch, 3, size, size)."""
        inputs = torch.cat((noise, scores), 1)[:, :, None, None]  # B, Z + W, 1, 1
        images: Tensor = self.layers(inputs)  # B, 3, S, S
        return images


class Discriminator(nn.Module):
    """Table 3: an image with its scores, each score as a plane, to one number; our variants by `label_input`.

    The final sigmoid of Table 3 is computed with the loss, where it loses no digits: `forward` returns its input.
    """

    def __init__(self, config: Config, words: int) -> None:
        super().__init__()
        first, *_, last = widths = config.widths[::-1]
        self.label_input, self.image_weight = config.label_input, config.image_weight
        inputs = [COLOURS, *widths[:-1]]  # channels
        if self.label_input == "planes":
            inputs[0] += words
        elif self.label_input == "normalised":
            inputs[1] += first
        layers: list[nn.Module] = [
            nn.Conv2d(inputs[0], first, KERNEL, 2, 1, bias=config.biases),
            nn.LeakyReLU(config.leak),
        ]
        for into, out in zip(inputs[1:], widths[1:], strict=True):
            layers += [
                nn.Conv2d(into, out, KERNEL, 2, 1, bias=config.biases),
                nn.BatchNorm2d(out),
                nn.LeakyReLU(config.leak),
            ]
        layers.append(nn.Conv2d(last, 1, KERNEL, 1, 0, bias=config.biases))
        self.layers = nn.Sequential(*layers)
        self.branch = nn.Linear(words, first) if self.label_input == "normalised" else None
        self.projection = LabelProjection(last, words) if self.label_input == "projection" else None
        self.regression = nn.Linear(last, words) if config.regression_weight else None
        normal_(self, config.gain)

    def forward(self, images: Tensor, scores: Tensor) -> tuple[Tensor, Tensor | None]:
        """Return the logit of being real, shape (batch,), and those of the predicted scores (batch, word), if any.

        ``images`` are (batch, 3, size, size), ``scores`` (batch, word). Real and generated images alike are weighted
        here (Sec. II-C).
        """
        x = self.image_weight * images  # B, 3, S, S
        if self.label_input == "planes":
            x = torch.cat((x, scores[:, :, None, None].expand(-1, -1, *x.shape[2:])), 1)  # B, 3 + W, S, S
        x = self.layers[:2](x)  # B, C, S/2, S/2
        if self.branch is not None:
            label = F.layer_norm(self.branch(scores), x.shape[1:2])[:, :, None, None]  # B, C, 1, 1
            x = torch.cat((F.group_norm(x, 1), label.expand_as(x)), 1)  # B, 2 C, S/2, S/2
        x = self.layers[2:-1](x)  # B, D, 4, 4
        logits = self.layers[-1](x).flatten()  # B
        features = x.mean((2, 3))  # B, D
        if self.projection is not None:
            logits = logits + self.projection(features, scores)
        return logits, None if self.regression is None else self.regression(features)


class TactileImageLearner(RatedImageLearner):
    """Generator and discriminator, and the mean ratings of the training images."""

    config: Config
    saved = (*RatedImageLearner.saved, "gan")

    def __init__(self, config: Config, kind: Kind, *, seed: int, device: str | torch.device = "cpu") -> None:
        if not isinstance(kind, ImageKind):
            raise ParameterError("tactile_image_cgan learns from rated images, got signals")
        super().__init__(config, kind, seed=seed, device=device)
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
        for number in range(start, stage.steps):
            pixels, labels = images.batch(number, self.config.batch_size, seed=seed, share=self.share)
            yield torch.from_numpy(pixels), torch.from_numpy(labels)

    def step(self, stage: Stage, batch: tuple[Tensor, Tensor]) -> dict[str, float]:
        """Update the discriminator, then the generator against it, on one draw of noise and of random scores.

        Fakes have uniform random scores, real images their own (Sec. II-C). The order of the networks, and that both
        see one draw, is assumed. Both losses are Eq. 2; the generator's has the label of real images. With
        `Config.regression_weight`, each network's sum has the cross-entropy of the predicted scores, too.
        """
        gan = self.gan
        gan.train(0.0)
        images, labels = (part.to(gan.device) for part in batch)  # B, 3, S, S; B, W
        noise = torch.randn(len(images), self.config.noise, device=gan.device)
        scores = torch.rand_like(labels) if self.config.fake_scores == "uniform" else labels
        generated = gan.generator(noise, scores)  # B, 3, S, S
        real, predicted = gan.discriminator(images, labels)  # B; B, W
        fake, _ = gan.discriminator(generated.detach(), scores)  # B
        loss_d = _cross_entropy(real, 1.0) + _cross_entropy(fake, 0.0)
        words_d = self._regression(predicted, labels)
        gan.descend(1, loss_d + words_d)
        with gan.fixed_discriminator():
            outputs, predicted = gan.discriminator(generated, scores)  # B; B, W
            loss_g = _cross_entropy(outputs, 1.0)
            words_g = self._regression(predicted, scores)
        gan.descend(0, loss_g + words_g)
        right = ((real > 0).float().mean() + (fake < 0).float().mean()) / 2
        losses = {"generator": loss_g.item(), "discriminator": loss_d.item(), "correct": right.item()}
        if self.config.regression_weight:
            losses |= {"words_generator": words_g.item(), "words_discriminator": words_d.item()}
        return losses

    def _regression(self, predicted: Tensor | None, scores: Tensor) -> Tensor:
        """Return the weighted cross-entropy of predicted scores, given as logits; 0 without them."""
        if predicted is None:
            return scores.new_zeros(())
        return self.config.regression_weight * F.binary_cross_entropy_with_logits(predicted.float(), scores)

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

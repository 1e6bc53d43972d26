"""Label predictor: a classifier of photographs that conditions a generator, its training and its augmentation.

References
----------
- Neshov, N. et al. (2026). Visual-to-tactile cross-modal generation … Sensors 26, 426. Sec. 3.1 ("Label
  Predictor") and 3.2.
- Zhong, Z. et al. (2020). Random erasing data augmentation. AAAI.
- Zhang, H. et al. (2018). mixup: beyond empirical risk minimization. ICLR.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from functools import cached_property
from itertools import count
from typing import Annotated, Any

import numpy as np
import torch
import torch.nn.functional as F
from pydantic import Field
from torch import Tensor, nn

from tactogram.features.photo_pairs import WeakPairs, rng_of, shuffled
from tactogram.model import WHOLE_BATCH, BatchShare, ModelConfig, Saved
from tactogram.nn.initial_weights import bare
from tactogram.nn.photo_translation import photo_crops, photos_of
from tactogram.nn.trunks import Trunk, TrunkName

Beta = Annotated[float, Field(ge=0, lt=1)]
ERASED_SHARE, ERASED_RATIO = (0.02, 0.33), (0.3, 3.3)
"""Area, and height by width, of erased rectangles: as in torchvision's RandomErasing, after Zhong et al."""


class PredictorConfig(ModelConfig):
    """Settings of the label predictor, with their place in the paper."""

    trunk: TrunkName = "densenet201"
    """Sec. 3.1, "DenseNet-201 backbone", frozen. The weights of ``efficientnet_lite0`` come in a package; ``own`` is a
    small network that is trained, too."""
    trunk_weights: str = ""
    """File of the trunk's weights; if empty, those of the package or in torch's cache."""
    hidden: int = Field(default=256, gt=0)
    """Sec. 3.1, "from 1920 to 256"."""
    leak: float = Field(default=0.01, ge=0, lt=1)
    """Sec. 3.1, "default negative slope of 0.01"."""
    batch_size: int = Field(default=64, gt=1)
    """Sec. 3.2."""
    epochs: int = Field(default=30, gt=0)
    """Sec. 3.2."""
    halve_every: int = Field(default=5, gt=0)
    """Epochs after which the learning rate is halved. Sec. 3.2."""
    learning_rate: float = Field(default=2e-4, gt=0, allow_inf_nan=False)
    """Sec. 3.2, "the same parameters as … for the cGAN training"."""
    betas: tuple[Beta, Beta] = (0.5, 0.999)
    """Sec. 3.2, likewise."""
    scale: float = Field(default=1.5, ge=1, allow_inf_nan=False)
    """Photographs are scaled by 1 to this factor, then cropped. Sec. 3.1, "[1, 1.5]"."""
    rotation_deg: float = Field(default=30.0, ge=0, le=180)
    """Sec. 3.1 names a random rotation; the angle is assumed."""
    erasing: float = Field(default=0.5, ge=0, le=1)
    """Share of photographs with a part erased. Sec. 3.1 names it; torchvision's default is assumed."""
    mixup: float = Field(default=0.2, ge=0, allow_inf_nan=False)
    """alpha of Beta(alpha, alpha). Sec. 3.1 names it; within Zhang et al.'s 0.1 to 0.4, assumed."""


class LabelPredictor(nn.Module):
    """Trunk, mean over places, dense layer, batch normalisation, LeakyReLU, dense layer to the classes."""

    def __init__(self, config: PredictorConfig, classes: int) -> None:
        super().__init__()
        self.trunk = Trunk(config.trunk, config.trunk_weights)
        self.head = nn.Sequential(
            nn.Linear(self.trunk.features, config.hidden),
            nn.BatchNorm1d(config.hidden),
            nn.LeakyReLU(config.leak),
            nn.Linear(config.hidden, classes),
        )

    def forward(self, photo: Tensor) -> Tensor:
        """Return logits, shape (batch, class), of photographs (batch, channel, row, column) in -1 to 1."""
        features = self.trunk(photo)  # B, F
        logits: Tensor = self.head(features)  # B, C
        return logits


class PredictorTraining(Saved):
    """The predictor with its optimiser: cross-entropy, Adam, a learning rate that is halved every few epochs.

    Weights are chosen by their accuracy on unseen photographs, if there are any; of equally good ones the later.
    """

    saved = ("network=bare", "best", "best_weights")

    def __init__(self, config: PredictorConfig, classes: int, *, device: torch.device) -> None:
        self.config, self.classes, self.device = config, classes, device
        network = LabelPredictor(config, classes)
        self.network: Any = network.to(device)
        self.backward: Callable[[Tensor], None] = Tensor.backward
        self.best, self.best_weights = -1.0, dict[str, Tensor]()

    @cached_property
    def optimiser(self) -> Any:
        """Adam. Made for training only: a process's first optimiser imports torch's compiler."""
        trained = [p for p in self.network.parameters() if p.requires_grad]
        return torch.optim.Adam(trained, lr=self.config.learning_rate, betas=self.config.betas)

    @property
    def bare(self) -> LabelPredictor:
        """The network without Fabric's wrapper."""
        network: LabelPredictor = bare(self.network)
        return network

    def setup(self, fabric: Any) -> None:
        """Hand network and optimiser to Lightning Fabric."""
        self.network, self.optimiser = fabric.setup(self.network, self.optimiser)
        self.backward, self.device = fabric.backward, fabric.device

    def optimiser_state(self) -> Any:
        """Return the state of the optimiser."""
        return self.optimiser.state_dict()

    def load_optimisers(self, state: Any) -> None:
        """Continue from `optimiser_state`."""
        self.optimiser.load_state_dict(state)

    def steps_per_epoch(self, pairs: WeakPairs) -> int:
        """Return the batches that contain each crop of a photograph about once."""
        return math.ceil(len(photo_crops(pairs)) / self.config.batch_size)

    def batches(
        self, pairs: WeakPairs, *, seed: int, start: int = 0, share: BatchShare = WHOLE_BATCH
    ) -> Iterator[tuple[int, Tensor, Tensor]]:
        """Yield number, photographs (batch, channel, row, column) and labels (batch, class), augmented."""
        config, crops = self.config, photo_crops(pairs)
        for step in count(start):
            rng = rng_of(seed, "augmentation", step, *share.purpose)
            batch = shuffled(len(crops), config.batch_size, step, seed=seed)
            drawn = crops[share.places(batch, config.batch_size)]
            photo, places = photos_of(pairs, drawn)
            photo = moved(photo, scale=config.scale, rotation_deg=config.rotation_deg, rng=rng)
            photo = erased(photo, share=config.erasing, rng=rng)
            label = F.one_hot(places, self.classes).float()
            photo, label = mixed(photo, label, alpha=config.mixup, rng=rng)
            yield step, photo, label

    def step(
        self, batch: tuple[int, Tensor, Tensor], *, epoch_steps: int, unseen: WeakPairs | None
    ) -> dict[str, float]:
        """Update the head (and the trunk ``own``) once; at the end of an epoch store weights that are better."""
        number, photo, label = batch
        halved = number // epoch_steps // self.config.halve_every
        for group in self.optimiser.param_groups:
            group["lr"] = self.config.learning_rate * 0.5**halved
        self.network.train()
        loss = F.cross_entropy(self.network(photo.to(self.device)), label.to(self.device))
        self.optimiser.zero_grad()
        self.backward(loss)
        self.optimiser.step()
        figures = {"label_loss": loss.item()}
        if unseen is not None and (number + 1) % epoch_steps == 0:
            figures["label_accuracy_unseen"] = accuracy = self.accuracy(unseen)
            if accuracy >= self.best:
                learned = self.bare.state_dict()
                if self.bare.trunk.frozen:
                    learned = {name: value for name, value in learned.items() if name.startswith("head.")}
                self.best, self.best_weights = accuracy, deepcopy(learned)
        return figures

    def settle(self) -> None:
        """Continue with the best weights, if any were stored."""
        if self.best_weights:
            self.bare.load_state_dict(self.best_weights, strict=False)
            self.best_weights = {}

    @torch.inference_mode()
    def probabilities(self, photo: Tensor, *, at_once: int = 32) -> Tensor:
        """Return the probability of each class for each photograph, shape (batch, class)."""
        network = self.bare.eval()
        parts = [network(part.to(self.device)).float().softmax(1) for part in torch.split(photo, at_once)]
        return torch.cat(parts).clone()

    def accuracy(self, pairs: WeakPairs) -> float:
        """Return the share of correctly classified crops, of known materials only."""
        right = []
        for part in np.array_split(photo_crops(pairs), max(1, len(photo_crops(pairs)) // 64)):
            photo, places = photos_of(pairs, part)
            predicted = self.probabilities(photo).argmax(1).cpu()
            right.append((predicted == places)[places >= 0])
        joined = torch.cat(right).float()
        return joined.mean().item() if len(joined) else 0.0

    def state(self) -> dict[str, Any]:
        """Return the weights, and the best so far."""
        return super().state() | {"loaded": self.bare.trunk.loaded}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Continue from `state`."""
        super().load_state(state)
        self.bare.trunk.loaded = state["loaded"]


def moved(photo: Tensor, *, scale: float, rotation_deg: float, rng: np.random.Generator) -> Tensor:
    """Return photographs, (item, channel, row, column), scaled up, cropped to their size, flipped and rotated.

    Each has its own draw: factors are uniform in 1 to ``scale``, angles in plus or minus ``rotation_deg``, the crop is
    anywhere. One bilinear look-up does all; areas from outside the photograph are reflected.
    """
    count = len(photo)
    factor = rng.uniform(1, scale, count)
    angle = np.deg2rad(rng.uniform(-rotation_deg, rotation_deg, count))
    flip = rng.choice([-1.0, 1.0], (count, 2))
    shift = rng.uniform(-1, 1, (count, 2)) * (1 - 1 / factor)[:, None]
    theta = np.empty((count, 2, 3))  # from places of the result to places of the photograph
    theta[:, 0] = np.stack((flip[:, 0] * np.cos(angle), -flip[:, 0] * np.sin(angle), shift[:, 0] * factor), 1)
    theta[:, 1] = np.stack((flip[:, 1] * np.sin(angle), flip[:, 1] * np.cos(angle), shift[:, 1] * factor), 1)
    places = torch.from_numpy(theta / factor[:, None, None]).to(photo)
    grid = F.affine_grid(places, list(photo.shape), align_corners=False)  # item, row, column, 2
    return F.grid_sample(photo, grid, mode="bilinear", padding_mode="reflection", align_corners=False)


def erased(photo: Tensor, *, share: float, rng: np.random.Generator) -> Tensor:
    """Return photographs, (item, channel, row, column), -1 to 1, a ``share`` with a rectangle of mean gray (0)."""
    photo = photo.clone()
    rows, columns = photo.shape[-2:]
    for item in photo:
        area = rng.uniform(*ERASED_SHARE) * rows * columns
        ratio = math.exp(rng.uniform(*np.log(ERASED_RATIO)))
        height, width = (
            min(max(1, round(side)), most)
            for side, most in ((math.sqrt(area * ratio), rows), (math.sqrt(area / ratio), columns))
        )
        top, left = int(rng.integers(rows - height + 1)), int(rng.integers(columns - width + 1))
        if rng.random() < share:
            item[:, top : top + height, left : left + width] = 0
    return photo


def mixed(photo: Tensor, label: Tensor, *, alpha: float, rng: np.random.Generator) -> tuple[Tensor, Tensor]:
    """Return ``l x + (1 - l) x'`` of photographs, (item, …), and of labels, (item, class), l from Beta(alpha, alpha).

    x' is another item. ``alpha`` 0 changes nothing.
    """
    if not alpha:
        return photo, label
    share = float(rng.beta(alpha, alpha))
    other = torch.from_numpy(rng.permutation(len(photo)))
    return share * photo + (1 - share) * photo[other], share * label + (1 - share) * label[other]

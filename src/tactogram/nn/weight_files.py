"""Published weights from local files: nothing is downloaded, and no file can run code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import file_digest
from pathlib import Path
from typing import Literal

import torch
from torch import Tensor

from tactogram.errors import DataError


@dataclass(frozen=True)
class PretrainedWeights:
    """A published file of weights; its name ends with the first digits of its SHA-256 (torch's convention)."""

    network: str
    used_for: str
    url: str

    @property
    def file_name(self) -> str:
        """Name of the file."""
        return self.url.rpartition("/")[2]

    @property
    def sha256_start(self) -> str:
        """First eight digits of the file's SHA-256."""
        return Path(self.file_name).stem.rpartition("-")[2]

    @property
    def cached(self) -> Path:
        """Place of the file in torch's cache, whether it is there or not."""
        return Path(torch.hub.get_dir()) / "checkpoints" / self.file_name

    def state(self) -> Literal["found", "missing", "another checksum"]:
        """Return whether torch's cache has the file, with its checksum."""
        if not self.cached.is_file():
            return "missing"
        with self.cached.open("rb") as opened:
            digest = file_digest(opened, "sha256").hexdigest()
        return "found" if digest.startswith(self.sha256_start) else "another checksum"


_TORCHVISION = "https://download.pytorch.org/models/"
ALEXNET = PretrainedWeights("AlexNet", "LPIPS", f"{_TORCHVISION}alexnet-owt-7be5be79.pth")
INCEPTION = PretrainedWeights(
    "Inception",
    "FID",
    "https://github.com/toshas/torch-fidelity/releases/download/v0.2.0/"
    "weights-inception-2015-12-05-6726825d.pth",
)
VGG19 = PretrainedWeights(
    "VGG-19",
    "perceptual loss of pix2pixhd and residue_fusion_gan",
    f"{_TORCHVISION}vgg19-dcbb9e9d.pth",
)
DENSENET201 = PretrainedWeights(
    "DenseNet-201",
    "label predictor of visual_tactile_gan and residue_fusion_gan, recipe paper",
    f"{_TORCHVISION}densenet201-c1103571.pth",
)
EFFICIENTNET_LITE0 = PretrainedWeights(
    "EfficientNet-Lite0", "in the extra vision", "efficientnet-lite0-57934424.pth"
)
PRETRAINED = (ALEXNET, INCEPTION, VGG19, DENSENET201)
"""Files that a published figure or loss needs and that no package contains."""


def weight_file(path: Path | str, weights: PretrainedWeights, *, option: str) -> Path:
    """Return the file of ``weights``: ``path``, or if empty the one in torch's cache.

    ``option`` is the name of ``path`` in errors.
    """
    if path:
        file = Path(path).expanduser()
        if not file.is_file():
            raise DataError(
                file, f"no weights of {weights.network} there; set {option} to {weights.file_name}"
            )
        return file
    file = weights.cached
    if not file.is_file():
        folder, home = file.parent, Path.home()  # a result that quotes this names no one's home
        place = f"~/{folder.relative_to(home)}" if folder.is_relative_to(home) else folder
        raise DataError(
            f"weights of {weights.network} ({weights.used_for}) are missing: put {file.name} into {place}, from "
            f"{weights.url}, or set {option} to the file"
        )
    return file


def read_weights(file: Path) -> Mapping[str, Tensor]:
    """Return the tensors in a ``.pth`` or ``.safetensors`` file by name; a file of anything else is refused."""
    try:
        if file.suffix == ".safetensors":
            from safetensors.torch import load_file

            return load_file(file)
        state: Mapping[str, Tensor] = torch.load(file, map_location="cpu", weights_only=True)
    except Exception as error:  # of many kinds
        line = str(error).partition("\n")[0]
        raise DataError(file, f"not a readable file of weights: {line[:120]}") from error
    if not (isinstance(state, Mapping) and all(isinstance(value, Tensor) for value in state.values())):
        raise DataError(file, "not a file of weights: expected tensors by name")
    return state

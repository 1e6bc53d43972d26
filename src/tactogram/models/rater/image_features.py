"""Image features for rating: colour, texture, and features of a pretrained network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn.functional import interpolate

from tactogram.errors import MissingExtraError, ParameterError
from tactogram.features.photo_descriptor import SMALLEST, descriptor
from tactogram.nn.trunks import Trunk
from tactogram.signal import Image

TrunkUsed = Literal["efficientnet_lite0", "none"]


class ImageFeatures:
    """Colour and texture statistics, then pooled features of a frozen trunk if one is used.

    ``auto`` uses the trunk if the extra ``vision`` is installed; see `used`. ``size`` is the shorter side of the
    trunk's input, pixels.
    """

    def __init__(self, trunk: Literal["auto", "efficientnet_lite0", "none"], size: int) -> None:
        self._requested, self._size = trunk, size
        self._trunk: Trunk | None = None
        self.used: TrunkUsed = "none"
        self.blocks: tuple[int, ...] = ()

    def prepare(self) -> None:
        """Load the trunk's weights, before a training."""
        if self._requested == "none" or self._trunk is not None:
            return
        try:
            trunk = Trunk("efficientnet_lite0")
            trunk.load()
        except MissingExtraError:
            if self._requested == "efficientnet_lite0":
                raise
            return
        self._trunk, self.used = trunk, "efficientnet_lite0"

    def state(self) -> dict[str, Any]:
        weights = {} if self._trunk is None else dict(self._trunk.network.state_dict())
        return {"used": self.used, "weights": weights}

    def load_state(self, state: Mapping[str, Any]) -> None:
        self.used, self._trunk = state["used"], None
        if self.used != "none":
            self._trunk = Trunk(self.used)
            self._trunk.network.load_state_dict(state["weights"])

    def __call__(self, images: Sequence[Image]) -> NDArray[np.float64]:
        """Return the features of each image, float64, shape (image, feature), and set `blocks`, their sizes by kind.

        Refuses images below `SMALLEST` pixels.
        """
        for image in images:
            if min(image.size) < SMALLEST:
                raise ParameterError(
                    f"an image must be at least {SMALLEST} x {SMALLEST} pixels, "
                    f"got {image.size[1]} x {image.size[0]}"
                )
        statistics = np.array([descriptor(image) for image in images])
        self.blocks = (statistics.shape[1],)
        if self._trunk is None:
            return statistics
        # One at a time: images differ in size, and must not affect each other's features.
        pooled = np.array([self._pooled(image, self._trunk) for image in images])
        self.blocks = (statistics.shape[1], pooled.shape[1])
        return np.concatenate([statistics, pooled], axis=1)

    def _pooled(self, image: Image, trunk: Trunk) -> NDArray[np.float64]:
        pixels = torch.from_numpy(np.array(image.pixels)).permute(2, 0, 1)[None].float()  # 1, 3, row, column
        scale = self._size / min(image.size)
        pixels = interpolate(pixels / 127.5 - 1, scale_factor=scale, mode="bilinear", antialias=True)
        with torch.no_grad():
            return np.asarray(trunk(pixels)[0].double().numpy())

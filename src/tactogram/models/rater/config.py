"""Configuration of the rater model. All of it is ours: no publication describes this model."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0)]
Kernel = Literal["linear", "rbf"]


class Config(BaseModel):
    """Candidate regressions, and their selection."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    kernels: tuple[Kernel, ...] = Field(default=("linear", "rbf"), min_length=1)
    """Plain ridge regression, and one that can bend. Trees were tried on VibViz and are worse there (README)."""
    penalties: tuple[Positive, ...] = Field(
        default=(0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0), min_length=1
    )
    """Ridge penalties; kernels are scaled to about 1 for an item with itself."""
    widths: tuple[Positive, ...] = Field(default=(0.1, 0.3, 1.0), min_length=1)
    """Of ``rbf``: what the mean squared difference of features is multiplied with."""
    folds: int = Field(default=5, ge=2, le=50)
    """Parts of the training items by which kernel, width and penalty are chosen, for each word by itself."""
    trunk: Literal["auto", "efficientnet_lite0", "none"] = "auto"
    """Of images: pooled features of a pretrained network beside colour and texture; ``auto`` takes it where the extra
    ``vision`` is installed. The run says which was used, and keeps the network's weights."""
    image_size: int = Field(default=128, ge=32, le=512)
    """Pixels of the shorter side that the trunk is shown; smaller images are enlarged."""

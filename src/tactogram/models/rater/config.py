"""Configuration of the rater model. All of it is ours: no publication describes this model."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0)]
Kernel = Literal["linear", "rbf"]


class Config(BaseModel):
    """Candidate regressions, and their selection."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    kernels: tuple[Kernel, ...] = Field(default=("linear", "rbf"), min_length=1)
    """Ridge regression, linear and not. Trees were worse on VibViz (README)."""
    penalties: tuple[Positive, ...] = Field(
        default=(0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0), min_length=1
    )
    """Ridge penalties, for kernels of about 1 of an item with itself."""
    widths: tuple[Positive, ...] = Field(default=(0.1, 0.3, 1.0), min_length=1)
    """Of ``rbf``: factors of the mean squared difference of features."""
    folds: int = Field(default=5, ge=2, le=50)
    """Folds of the training items that choose kernel, width and penalty of each word."""
    trunk: Literal["auto", "efficientnet_lite0", "none"] = "auto"
    """For images: pooled features of a pretrained network, besides colour and texture; ``auto`` uses it if the extra
    ``vision`` is installed. The run records which was used, and stores the network's weights."""
    image_size: int = Field(default=128, ge=32, le=512)
    """Pixels of the shorter side of the trunk's input; smaller images are enlarged."""

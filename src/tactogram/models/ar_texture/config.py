"""Configuration of an autoregressive texture: the publications' choices, and ours where they state none."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class Config(BaseModel):
    """Fit and mixing of the models."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    order: int | None = Field(default=None, ge=0, le=200)
    """Order of every model; None takes each model's least AIC. The toolkit has one order per surface."""
    max_order: int = Field(default=60, ge=0, le=200)
    """Highest order AIC may take. Ours: higher ones do not lower the log-spectral distance to unseen recordings."""
    method: Literal["burg", "yule-walker"] = "burg"
    """Burg's recursion over all recordings of a condition (de Waele & Broersen 2000). Ours, since it is less biased
    on short recordings; the publications solve the Yule-Walker equations of one segment."""
    by_condition: bool = True
    """One model per speed and force if all recordings of a material have them (Culbertson et al. 2012)."""
    level: Literal["log", "linear"] = "log"
    """Interpolation of power between models. Ours: in dB, which feels even; the toolkit interpolates the variance of
    the innovations, so that the level between two models is not between their levels."""

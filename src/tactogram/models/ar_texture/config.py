"""Configuration of an autoregressive texture; the publications' choices, and ours where they name none."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field


class Config(BaseModel):
    """Fit and mixing of the models."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    order: int | None = Field(default=None, ge=0, le=200)
    """Order of every model; None takes each one's least AIC. The toolkit has one order per surface."""
    max_order: int = Field(default=60, ge=0, le=200)
    """Highest order AIC may take. Ours: beyond it the log-spectral distance to unseen recordings stays."""
    method: Literal["burg", "yule-walker"] = "burg"
    """Burg's recursion over all recordings of a condition (de Waele & Broersen 2000); the publications solve
    the Yule-Walker equations of one segment. Ours, since it is less biased on short recordings."""
    by_condition: bool = True
    """One model per speed and force where all recordings of a material say them (Culbertson et al. 2012)."""
    level: Literal["log", "linear"] = "log"
    """How power goes between models. Ours: in dB, even to the hand; the toolkit interpolates the variance of
    the innovations, so that the level between two models is not between their levels."""

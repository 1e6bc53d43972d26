"""Configuration of a modulated-noise texture."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from tactogram.signal.modulated_noise_fit import LAGS


class Config(BaseModel):
    """Fit of the models."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    lags: int = Field(default=LAGS, ge=1, le=50)
    """Order of the vector autoregression, frames of 10 ms."""
    by_condition: bool = True
    """One model per speed and force if all recordings of a material have them."""

"""Configuration of a replayed texture. All of it is ours: the method has no single publication."""

from __future__ import annotations

from typing import Self

from pydantic import BaseModel, ConfigDict, Field, model_validator


class Config(BaseModel):
    """Stored part of the recordings, and joins of segments."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    seconds_per_material: float = Field(default=60.0, gt=0, allow_inf_nan=False)
    """Most of each material's recordings that is stored, s, divided evenly among them; bounds the run's size."""
    segment_s: float = Field(default=0.5, gt=0, allow_inf_nan=False)
    """Length of the segments that are joined, s, crossfades included; a shorter recording is one segment."""
    overlap_s: float = Field(default=0.1, ge=0, allow_inf_nan=False)
    """Length of the crossfades, s."""
    search_s: float = Field(default=0.02, ge=0, allow_inf_nan=False)
    """How far a segment may move for the smoothest join, s (Verhelst & Roelands 1993)."""

    @model_validator(mode="after")
    def _segments_outlast_crossfades(self) -> Self:
        if self.segment_s <= 2 * self.overlap_s + self.search_s:
            raise ValueError(
                f"segment_s must be above 2 overlap_s + search_s, {2 * self.overlap_s + self.search_s:g} s"
            )
        return self

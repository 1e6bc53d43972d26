"""Configuration of the nearest-photograph baseline. All of it is ours."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class Config(BaseModel):
    """Amount kept, and comparison of photographs."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    photographs: int = Field(default=50, gt=0)
    """Most photographs kept of each material."""
    neighbours: int = Field(default=1, gt=0)
    """Photographs that vote, nearest first; ties go to the nearer."""
    seconds_per_material: float = Field(default=60.0, gt=0, allow_inf_nan=False)
    """Longest stretch of recordings kept of each material, s (mm over displacement)."""
    segment_s: float = Field(default=0.5, gt=0, allow_inf_nan=False)
    """Length of the segments that are joined, s (mm over displacement)."""
    overlap_s: float = Field(default=0.1, ge=0, allow_inf_nan=False)
    """Length of the crossfades, s (mm over displacement)."""
    search_s: float = Field(default=0.02, ge=0, allow_inf_nan=False)
    """How far a segment may slide to where it goes on best, s (mm over displacement)."""

"""Configuration of the nearest-photograph baseline. All of it is ours."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field


class Config(BaseModel):
    """Stored photographs and recordings, and comparison of photographs."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    photographs: int = Field(default=50, gt=0)
    """Most photographs stored of each material."""
    neighbours: int = Field(default=1, gt=0)
    """Photographs that vote, nearest first; ties go to the nearer."""
    seconds_per_material: float = Field(default=60.0, gt=0, allow_inf_nan=False)
    """Most of each material's recordings that is stored, s (mm over displacement)."""
    segment_s: float = Field(default=0.5, gt=0, allow_inf_nan=False)
    """Length of the segments that are joined, s (mm over displacement)."""
    overlap_s: float = Field(default=0.1, ge=0, allow_inf_nan=False)
    """Length of the crossfades, s (mm over displacement)."""
    search_s: float = Field(default=0.02, ge=0, allow_inf_nan=False)
    """How far a segment may move for the smoothest join, s (mm over displacement)."""

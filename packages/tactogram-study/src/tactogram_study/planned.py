"""Planned analysis: margins of equivalence and alpha, decided before anybody answers, and part of the study's hash."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tactogram_study.analysis.findings import ALPHA


class EquivalenceMargin(BaseModel):
    """Half the width of what counts as equal; a plain number is a margin without a reason."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    value: float = Field(gt=0, allow_inf_nan=False)
    because: str = ""
    """Reason for the width, for the report."""

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, value: Any) -> Any:
        return {"value": value} if isinstance(value, int | float) else value


class PlannedAnalysis(BaseModel):
    """Analysis planned in the study's file before any answer."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    margins: dict[str, EquivalenceMargin] = Field(default_factory=dict)
    """By question or measure, as the design names them. Without a margin nothing can be shown to be equivalent."""
    alpha: float = Field(default=ALPHA, gt=0, le=0.2)
    """A difference is shown if p is below."""

    @property
    def values(self) -> dict[str, float]:
        """The margins alone."""
        return {name: margin.value for name, margin in self.margins.items()}


def changed_margins(margins: Mapping[str, float], planned: Mapping[str, float]) -> dict[str, float]:
    """Return the margins that differ from the planned ones."""
    return {
        name: value
        for name, value in margins.items()
        if name not in planned or not math.isclose(planned[name], value, rel_tol=1e-9)
    }

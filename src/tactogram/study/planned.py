"""What is decided before anybody answers: margins of equivalence, and alpha. Part of the study, and of its hash."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

ALPHA = 0.05
MARGINS: Mapping[str, tuple[str, ...]] = {
    "two_area": ("which", "realism"),
    "rating": ("rating",),
    "abx": ("abx",),
    "staircase": ("staircase",),
    "magnitude": ("magnitude",),
    "evoked": ("evoked",),
    "pairwise": ("preference",),
}
"""What a margin can be given for, by design."""
UNITS: Mapping[str, str] = {
    "which": "of the share correct",
    "realism": "mm",
    "rating": "points",
    "abx": "of the share correct",
    "staircase": "dB",
    "magnitude": "of the exponent",
    "evoked": "of the share of words",
    "preference": "of log strengths",
}
SHARES = ("which", "abx")
"""Margins around one half."""


class EquivalenceMargin(BaseModel):
    """Half the width of what counts as equal; a plain number stands for one without a reason."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    value: float = Field(gt=0, allow_inf_nan=False)
    because: str = ""
    """Why this wide: it stands in the report."""

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, value: Any) -> Any:
        return {"value": value} if isinstance(value, int | float) else value


class PlannedAnalysis(BaseModel):
    """How answers will be analysed, as the study's file says it beforehand."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    margins: dict[str, EquivalenceMargin] = Field(default_factory=dict)
    """By question or measure; see `MARGINS`. Without one nothing can be shown to be equivalent."""
    alpha: float = Field(default=ALPHA, gt=0, le=0.2)
    """A difference is shown where p is below."""

    @model_validator(mode="after")
    def _shares(self) -> Self:
        for name in SHARES:
            if name in self.margins and not self.margins[name].value < 0.5:
                raise ValueError(f"margin of {name} is a share around one half: it must be below 0.5")
        return self

    def check(self, design: str) -> None:
        """Refuse margins that a design does not take.

        Raises
        ------
        ValueError
        """
        known = MARGINS.get(design, ())
        for name in self.margins:
            if name not in known:
                raise ValueError(
                    f"analysis.margins: a study of design {design} takes margins for {', '.join(known)}, got {name!r}"
                )

    @property
    def values(self) -> dict[str, float]:
        """The margins alone."""
        return {name: margin.value for name, margin in self.margins.items()}


def margin_name(design: str, question: str) -> str:
    """Return the name of the margin that answers to a question are held against, "" if there is none."""
    names = MARGINS.get(design, ())
    return question if question in names else names[0] if len(names) == 1 else ""


def margin_text(name: str, value: float) -> str:
    """Return a margin as people read it."""
    unit = UNITS.get(name, "")
    return f"{name} ±{value:g}{' ' + unit if unit else ''}"


def differing(given: Mapping[str, float], planned: Mapping[str, float]) -> dict[str, float]:
    """Return the margins that are not those that were planned."""
    return {
        name: value
        for name, value in given.items()
        if name not in planned or not math.isclose(planned[name], value, rel_tol=1e-9)
    }

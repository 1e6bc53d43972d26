"""Plans of a study: its margins of equivalence and alpha, the analysis of its answers, and what its power assumes.

Margins and alpha are decided before anybody answers, and part of the study's hash.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from pydantic import Field, model_validator

from tactogram.errors import ParameterError
from tactogram.validation import DescribedModel

if TYPE_CHECKING:
    from tactogram_study.answers import Targets

ALPHA = 0.05
"""A difference is shown if p is below, unless the study has another."""


class EquivalenceMargin(DescribedModel):
    """Half the width of what counts as equal; a plain number is a margin without a reason."""

    value: float = Field(gt=0, allow_inf_nan=False)
    because: str = ""
    """Reason for the width, for the report."""

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, value: Any) -> Any:
        return {"value": value} if isinstance(value, int | float) else value


class PlannedAnalysis(DescribedModel):
    """Analysis planned in the study's file before any answer."""

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


@dataclass(frozen=True)
class AnalysisPlan:
    """Decisions made before the answers are seen.

    Parameters
    ----------
    margins : mapping from str to float
        Half the width of what counts as equal, by name of a design's ``margins``.
    targets : mapping, optional
        Target scores of words by stimulus.
    reference : str, optional
        Condition whose mean scores are the targets instead.
    draws : int
        Of a bootstrap.
    alpha : float
        A difference is shown if p is below. Intervals are always of 95 %.
    planned : PlannedAnalysis, optional
        Analysis in the study's file. Deviations are reported; without it, nobody can see when margins were set.
    """

    margins: Mapping[str, float]
    targets: Targets | None = None
    reference: str | None = None
    seed: int = 0
    draws: int = 2000
    alpha: float = ALPHA
    planned: PlannedAnalysis | None = None

    @classmethod
    def of(
        cls,
        planned: PlannedAnalysis | None,
        margins: Mapping[str, float] | None = None,
        *,
        alpha: float | None = None,
        **options: Any,
    ) -> Self:
        """Return the plan of a study's file, if there is one, with ``margins`` and ``alpha`` that replace its own."""
        own = planned or PlannedAnalysis()
        alpha = own.alpha if alpha is None else alpha
        return cls({**own.values, **(margins or {})}, alpha=alpha, planned=planned, **options)

    @property
    def deviations(self) -> dict[str, float]:
        """Margins and alpha that differ from the study's file; {} without it."""
        if self.planned is None:
            return {}
        changed = {} if self.alpha == self.planned.alpha else {"alpha": self.alpha}
        return changed_margins(self.margins, self.planned.values) | changed

    def generator(self) -> np.random.Generator:
        """Return the generator of a section's bootstraps, the same for each section."""
        return np.random.default_rng(self.seed)

    def __post_init__(self) -> None:
        for name, margin in self.margins.items():
            if not (margin > 0 and math.isfinite(margin)):
                raise ParameterError(f"margin of {name} must be > 0, got {margin:g}")
        if self.targets is not None and self.reference is not None:
            raise ParameterError("targets and reference exclude each other, got both")
        if not 0 < self.alpha <= 0.2:
            raise ParameterError.must("alpha", "be > 0 and at most 0.2", self.alpha)
        if self.draws < 100:
            raise ParameterError.must("draws", "be at least 100 for an interval of 95 %", self.draws)


@dataclass(frozen=True)
class PowerAssumptions:
    """Default assumptions of a power table: typical sizes, to be replaced by those of a pilot.

    Parameters
    ----------
    kind : str
        Name of one of `tactogram_study.power.METHODS`, or of the design's own ``simulation``.
    effect : float
        True effect, described with its unit by ``effect_text``.
    person_sd, trial_sd : float
        Spread of effects between people, and of single answers.
    margin : float
        Margin of equivalence of the table; a study has its own.
    trials_text : str
        Description of a trial.
    test : str
        Confirmatory test.
    items : int
        Number of items compared with each other, or 0.
    """

    kind: str
    effect: float
    effect_text: str
    person_sd: float
    trial_sd: float
    margin: float
    participants: tuple[int, ...]
    trials: tuple[int, ...]
    trials_text: str
    test: str
    items: int = 0


GEE = "GEE by participant"

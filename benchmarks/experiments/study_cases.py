"""Shipped studies with simulated effects, one declaration each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from scipy.special import expit

from benchmarks.experiments.study_recovery import ExpectedFinding
from benchmarks.experiments.study_truths import (
    evoked,
    half,
    level,
    share_abx,
    share_two_area,
    shifted,
    steps,
)
from tactogram_study.analysis.paired import REST, WHOLE
from tactogram_study.analysis.threshold import SETTLED_3_DOWN


@dataclass(frozen=True)
class AtMargin:
    """Effect as large as a margin.

    Parameters
    ----------
    place : int
        Number of the expected finding.
    most : float
        An amount of the effect that exceeds the margin.
    """

    place: int
    margin: str
    most: float
    sign: float = 1.0


@dataclass(frozen=True)
class StudyCase:
    """One shipped study.

    Parameters
    ----------
    effect : mapping
        Fields of `SimulatedEffect`.
    findings : tuple of ExpectedFinding
        Confirmatory ones first, if the study has any of the effect.
    at_margin : mapping from str to AtMargin
        By the name of the effect. Each is alone in its kind, except in two-area, which has two.
    changes : mapping
        Changes of the study that shorten it for two cores, by dotted key; reported with the result.
    people : mapping
        Fields of `SimulatedEffect` for participants with and without the effect.
    seeds : int
        Default number of simulated studies of each kind.
    """

    effect: Mapping[str, Any]
    findings: tuple[ExpectedFinding, ...]
    at_margin: Mapping[str, AtMargin]
    changes: Mapping[str, Any] = field(default_factory=dict)
    people: Mapping[str, Any] = field(default_factory=dict)
    seeds: int = 200


def _without(*names: str) -> Callable[[str], bool]:
    return lambda of: not any(name in of.replace(",", " ").split() for name in names)


def _other_items(item: str) -> Callable[[str], bool]:
    return lambda of: of.endswith(WHOLE) and not of.startswith(f"{item} ")


def _every(of: str) -> bool:
    return True


GAP, WILCOXON = "paired t by participant", "Wilcoxon signed ranks"
EXACT = "exact binomial"
ALIKE: Mapping[str, Any] = {"typical_sd": 0.0}
"""Items do not differ for anybody: where items are compared rather than conditions, only the effect may differ."""
TWO_WORDS = {"design.words": ["rough", "dry"]}
"""For two cores: an analysis of all words takes seconds."""
DIFFERING = {"d_prime_sd": 0.4}
"""With an effect, d' differs between people; without one it is 0 for everybody."""

STUDIES: Mapping[str, StudyCase] = {
    "plate-words": StudyCase(
        {"shift": {"plate01": 1.5}},
        (
            ExpectedFinding(
                "Words", f"plate01 {REST}, {WHOLE}", GAP, steps("plate01"), "steps",
                others=_other_items("plate01"), tied=True,
            ),
            ExpectedFinding("Words", f"plate01 {REST}, rough", GAP, steps("plate01"), "steps"),
        ),
        {"shift.plate01": AtMargin(0, "rating", 3.0)},
        changes={**TWO_WORDS, "grid.count": 6},
        people=ALIKE,
    ),
    "evoked-words": StudyCase(
        {"shift": {"image001": 2.0}},
        (
            ExpectedFinding(
                "Evoked", f"image001 {REST}, {WHOLE}", GAP, evoked("image001"), "share of words",
                others=_other_items("image001"), tied=True,
            ),
            ExpectedFinding("Evoked", "image002, rough", EXACT, half, "share", 0.5, others=_every, tied=True),
        ),
        {"shift.image001": AtMargin(0, "evoked", 5.0)},
        changes={**TWO_WORDS, "design.set_size": 8, "grid.count": 8},
        people=ALIKE,
    ),
    "abx": StudyCase(
        {"d_prime": 2.0, **DIFFERING},
        (
            ExpectedFinding("ABX", "all", "GEE", share_abx, "share correct", 0.5),
            ExpectedFinding(
                "ABX", "cloth", "GEE", share_abx, "share", 0.5, others=_without("all", "side"), tied=True
            ),
            ExpectedFinding("ABX", "cloth", EXACT, share_abx, "share", 0.5, others=_every, tied=True),
        ),
        {"d_prime": AtMargin(0, "abx", 5.0)},
        changes={"design.repeats": 4},
    ),
    "display-words": StudyCase(
        {"shift": {"A": 1.0}},
        tuple(
            ExpectedFinding("Words", "A minus sensor", test, steps("A", "sensor"), "steps", others=_without("A"))
            for test in (WILCOXON, GAP)
        ),
        {"shift.A": AtMargin(0, "rating", 3.0)},
        changes={**TWO_WORDS, "grid.count": 2},
        seeds=100,
    ),
    "image-words": StudyCase(
        {"shift": {"1000": 1.0}},
        tuple(
            ExpectedFinding("Words", "1 minus 1000", test, steps("1", "1000"), "steps", others=_without("1000"))
            for test in (WILCOXON, GAP)
        ),
        {"shift.1000": AtMargin(0, "rating", 3.0)},
        changes={**TWO_WORDS, "grid.count": 2},
        seeds=100,
    ),
    "magnitude": StudyCase(
        {"exponent": 0.8},
        (
            ExpectedFinding("Magnitude", "all", "log-log", lambda e, *_: e.exponent, "exponent"),
            ExpectedFinding("Magnitude", "all", GAP, lambda e, *_: e.exponent - 1, "exponent", math.nan),
        ),
        {"exponent": AtMargin(0, "magnitude", 3.0)},
    ),
    "two-area": StudyCase(
        {"d_prime": 1.5, "shift": {"generated": -10.0}, **DIFFERING},
        (
            ExpectedFinding("Which", "all", "GEE", share_two_area, "share correct", 0.5),
            ExpectedFinding("Realism", "all", GAP, shifted("generated"), "mm"),
            ExpectedFinding(
                "Which", "cloth", "GEE", share_two_area, "share", 0.5,
                others=_without("all", "side"), tied=True,
            ),
            ExpectedFinding("Which", "cloth", EXACT, share_two_area, "share", 0.5, others=_every, tied=True),
            ExpectedFinding("Realism", "all", "linear mixed model", shifted("generated"), "mm"),
            ExpectedFinding("Realism", "cloth", GAP, shifted("generated"), "mm", others=_without("all"), tied=True),
        ),
        {"d_prime": AtMargin(0, "which", 5.0), "shift.generated": AtMargin(1, "realism", 50.0)},
        changes={"grid.items": ["cloth", "tile", "carpet", "cork-sheet"], "design.repeats": 2},
    ),
    "preference": StudyCase(
        {"shift": {"carpet": 1.5}},
        (
            ExpectedFinding(
                "Preference", "carpet over cloth", "Bradley-Terry", shifted("carpet"), "log strength",
                others=_without("carpet"),
            ),
            ExpectedFinding("Preference", "carpet over cloth", EXACT, shifted("carpet", expit), "share", 0.5),
        ),
        {"shift.carpet": AtMargin(0, "preference", 3.0)},
        changes={"design.comparisons": 30},
    ),
    "threshold": StudyCase(
        {"threshold_db": -25.0, "shift": {"tile": 8.0}},
        (  # of a threshold there is no absence
            ExpectedFinding("Staircases", "all", GAP, shifted("tile"), "dB", pair="tile minus carpet"),
            *(
                ExpectedFinding("Staircases", item, test, level(item, SETTLED_3_DOWN), "dB", math.nan)
                for test in ("logistic fits", "mean of reversals")
                for item in ("carpet", "tile")
            ),
            ExpectedFinding(
                "Staircases", "all", WILCOXON, shifted("tile"), "dB", pair="pseudomedian of tile minus carpet"
            ),
        ),
        {"shift.tile": AtMargin(0, "staircase", 50.0)},
        changes={"design.reversals": 12, "design.most_trials": 120},  # as shipped
        seeds=100,
    ),
}  # fmt: skip
"""By name of the study."""

"""Cases of `studies_coverage`: effects put into simulated studies, and where their analyses show them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from scipy.special import expit

from benchmarks.experiments.studies_in_browser import STUDIES
from benchmarks.experiments.study_recovery import (
    GAP,
    LOOKED,
    Looked,
    Truth,
    level,
    share_abx,
    share_two_area,
    steps,
    two_alternatives,
    without,
)
from tactogram.statistics.shares import abx_share
from tactogram.study.analysis.threshold import SETTLED_3_DOWN
from tactogram.study.simulated_participants import SimulatedEffect
from tactogram.study.study_file import Study


@dataclass(frozen=True)
class AtMargin:
    """Where an effect is to be as large as a margin.

    Parameters
    ----------
    place : int
        Of the case's ``looked``.
    margin : str
        Its name.
    most : float
        An amount of the effect that is larger than that.
    sign : float
    """

    place: int
    margin: str
    most: float
    sign: float = 1.0


@dataclass(frozen=True)
class Case:
    """One shipped study.

    Parameters
    ----------
    effect, people : mapping
        Of `SimulatedEffect`: what is put in, and what is true of people with an effect and without.
    changes : mapping
        Of the study, for two cores, by dotted key.
    at_margin : mapping from str to AtMargin
        By the effect that is put in.
    looked : tuple of Looked
    seeds : int
        Studies of each kind, unless asked otherwise.
    """

    effect: Mapping[str, Any]
    changes: Mapping[str, Any]
    at_margin: Mapping[str, AtMargin]
    looked: tuple[Looked, ...]
    seeds: int = 200
    people: Mapping[str, Any] = field(default_factory=dict)


def _case(
    name: str, at_margin: Mapping[str, AtMargin], *also: Looked, changes: Mapping[str, Any] = {}, **more: Any
) -> Case:
    taken = STUDIES[name]
    return Case(
        more.pop("effect", taken.effect),
        {**taken.bench, **changes},
        at_margin,
        (*LOOKED[name], *also),
        **{"people": taken.people, **more},
    )


def _every(of: str) -> bool:
    return True


def _half(effect: SimulatedEffect, study: Study, seed: int) -> float:
    return 0.5


def _where_none(effect: SimulatedEffect, study: Study, seed: int) -> float:
    """Return 0 where nothing was put in; what an effect is on this scale is not worked out."""
    return math.nan if effect.shift else 0.0


def _shift(name: str, of: Any = float) -> Truth:
    return lambda effect, study, seed: float(of(effect.shift.get(name, 0.0)))


def _typical(share: Any) -> Truth:
    return lambda effect, study, seed: float(share(effect.d_prime))


TWO_WORDS = {"design.words": ["rough", "dry"]}
"""Two cores: an analysis of all words takes seconds."""
DIFFERING = {"d_prime_sd": 0.4}
"""Of people with an effect: their d' differ; without one nobody's does."""
WILCOXON, MIXED, EXACT = "Wilcoxon signed ranks", "binomial mixed model", "exact binomial"
CASES: Mapping[str, Case] = {
    "plate-words": _case(
        "plate-words", {"shift.plate01": AtMargin(0, "rating", 3.0)}, changes={**TWO_WORDS, "grid.count": 6}
    ),
    "evoked-words": _case(
        "evoked-words",
        {"shift.image001": AtMargin(0, "evoked", 5.0)},
        Looked("Evoked", "image002, rough", EXACT, _half, "share", 0.5, others=_every, tied=True),
        changes={**TWO_WORDS, "design.set_size": 8, "grid.count": 8},
    ),
    "abx": _case(
        "abx",
        {"d_prime": AtMargin(0, "abx", 5.0)},
        Looked("ABX", "all", MIXED, _typical(abx_share), "share", 0.5),
        Looked("ABX", "cloth", "GEE", share_abx, "share", 0.5, others=without("all", "side"), tied=True),
        Looked("ABX", "cloth", EXACT, share_abx, "share", 0.5, others=_every, tied=True),
        effect={"d_prime": 2.0, **DIFFERING},
    ),
    "display-words": _case(
        "display-words",
        {"shift.A": AtMargin(0, "rating", 3.0)},
        Looked("Words", "A minus sensor", GAP, steps("A", "sensor"), "steps", others=without("A")),
        Looked(
            "Words",
            "rough, sensor against A",
            "proportional odds",
            _where_none,
            "log odds",
            others=_every,
            tied=True,
        ),
        changes={**TWO_WORDS, "grid.count": 2},
        seeds=100,
    ),
    "image-words": _case(
        "image-words",
        {"shift.1000": AtMargin(0, "rating", 3.0)},
        Looked("Words", "1 minus 1000", GAP, steps("1", "1000"), "steps", others=without("1000")),
        changes={**TWO_WORDS, "grid.count": 2},
        seeds=100,
    ),
    "magnitude": _case(
        "magnitude",
        {"exponent": AtMargin(0, "magnitude", 3.0)},
        Looked("Magnitude", "all", GAP, lambda e, *_: e.exponent - 1, "exponent", math.nan),
    ),
    "two-area": _case(
        "two-area",
        {"d_prime": AtMargin(0, "which", 5.0), "shift.generated": AtMargin(1, "realism", 50.0)},
        Looked("Which", "all", MIXED, _typical(two_alternatives), "share", 0.5),
        Looked(
            "Which", "cloth", "GEE", share_two_area, "share", 0.5, others=without("all", "side"), tied=True
        ),
        Looked("Which", "cloth", EXACT, share_two_area, "share", 0.5, others=_every, tied=True),
        Looked("Realism", "all", "linear mixed model", _shift("generated"), "mm"),
        Looked("Realism", "cloth", GAP, _shift("generated"), "mm", others=without("all"), tied=True),
        effect={"d_prime": 1.5, "shift": {"generated": -10.0}, **DIFFERING},
        changes={"grid.items": ["cloth", "tile", "carpet", "cork-sheet"], "design.repeats": 2},
    ),
    "preference": _case(
        "preference",
        {"shift.carpet": AtMargin(0, "preference", 3.0)},
        Looked("Preference", "carpet over cloth", EXACT, _shift("carpet", expit), "share", 0.5),
    ),
    "threshold": _case(
        "threshold",
        {"shift.tile": AtMargin(0, "staircase", 50.0)},
        Looked("Staircases", "carpet", "mean of reversals", level("carpet", SETTLED_3_DOWN), "dB", math.nan),
        Looked("Staircases", "tile", "mean of reversals", level("tile", SETTLED_3_DOWN), "dB", math.nan),
        Looked("Staircases", "all", WILCOXON, _shift("tile"), "dB", pair="pseudomedian of tile minus carpet"),
        changes={"design.reversals": 12, "design.most_trials": 120},  # as shipped
        seeds=100,
    ),
}
"""By name of the study; each effect that is at the margin is alone in its kind but for two areas, which has two."""

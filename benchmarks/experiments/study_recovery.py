"""Recovery of simulated effects: per study, the finding that shows the effect, beside its true value.

The truth is computed from the simulated participants' rules alone, in the analysis' own unit: never from their answers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.special import expit, ndtr, ndtri

from tactogram.statistics.shares import abx_share
from tactogram.study.analysis.findings import EQUIVALENT, SHOWN
from tactogram.study.analysis.item_contrasts import REST, WHOLE
from tactogram.study.analysis.threshold import SETTLED_3_DOWN
from tactogram.study.simulated_participants import UNIT, SimulatedEffect, typical
from tactogram.study.study_file import Study

Truth = Callable[[SimulatedEffect, Study, int], float]
"""Of an effect, the study as it was taken, and the seed of the answers."""
RECOVERED, MISSED, NOT_FOUND = "recovered", "shown, outside the interval", "not shown"
ABSENT, FALSE_ALARM = "equivalent within the margin", "false alarm"
UNDECIDED, NO_MARGIN = "undecided", "not shown; the study gives no margin, so nothing can be equivalent"
WILCOXON = "Wilcoxon signed ranks"


@dataclass(frozen=True)
class Looked:
    """Where in an analysis an effect is to be found.

    Parameters
    ----------
    section : str
        Beginning of its title.
    of, test : str
        As a finding has them; ``test`` is its beginning.
    truth : callable
        What the estimate should be.
    unit : str
    nothing : float
        What the estimate should be with no effect.
    others : callable, optional
        Which findings of the same test and role are of things that nothing was put into, by their ``of``.
    tied : bool
        Whether these are held against what was put in, so that they hold of nothing without an effect only.
    pair : str
        "FIRST minus SECOND", where the measure names them in the order in which they came.
    """

    section: str
    of: str
    test: str
    truth: Truth
    unit: str
    nothing: float = 0.0
    others: Callable[[str], bool] | None = None
    tied: bool = False
    pair: str = ""


def recoveries(
    name: str, analysis: Mapping[str, Any], study: Study, effect: Mapping[str, Any], *, seed: int, kind: str
) -> list[dict[str, Any]]:
    """Return for each place where a study's effect shows: put in, estimate, interval, and whether it was recovered.

    Parameters
    ----------
    name : str
        Of `LOOKED`.
    analysis : mapping
        As ``study analyse`` writes it.
    study : Study
        As it was taken.
    effect : mapping
        Of `SimulatedEffect`, what was put in, or what is true without an effect.
    seed : int
    kind : {"effect", "none"}
    """
    return [recovery(one, analysis, study, SimulatedEffect(**effect), seed, kind) for one in LOOKED[name]]


def recovery(
    one: Looked, analysis: Mapping[str, Any], study: Study, effect: SimulatedEffect, seed: int, kind: str
) -> dict[str, Any]:
    """Return what `recoveries` does, of one place."""
    findings = next(s["findings"] for s in analysis["sections"] if s["title"].startswith(one.section))
    same = [finding for finding in findings if finding["test"].startswith(one.test)]
    found = _in_order(_found(same, one.of), one.pair)
    truth = one.truth(effect, study, seed)
    counted = one.others if kind == "none" or not one.tied else None
    alike = [finding for finding in same if finding["role"] == found["role"]]
    rest = [finding for finding in alike if counted is not None and counted(finding["of"])]
    return {
        "of": f"{found['of']}: {found['measure']}",
        "test": found["test"],
        "unit": one.unit,
        "put_in": truth,
        "nothing": None if math.isnan(one.nothing) else one.nothing,
        **{key: found[key] for key in ("estimate", "low", "high", "p", "correction", "verdict")},
        **{key: found[key] for key in ("margin", "equivalence_p", "participants", "n")},
        "covers": None if math.isnan(truth) else found["low"] <= truth <= found["high"],
        "outcome": outcome_of(found, truth, one.nothing, kind),
        "others": len(rest),
        "others_covered": sum(_covers(f, one.nothing) for f in rest),
        "others_shown": sum(f["verdict"] == SHOWN for f in rest),
        "others_equivalent": sum(f["verdict"] == EQUIVALENT for f in rest),
    }


def _covers(found: Mapping[str, Any], truth: float) -> bool:
    return found["low"] is not None and bool(found["low"] <= truth <= found["high"])


def _found(findings: Sequence[Mapping[str, Any]], of: str) -> Mapping[str, Any]:
    """Return the first finding of something; of a pair that stands the other way round, its negative."""
    for found in findings:
        if found["of"] == of:
            return found
    turned = " over ".join(reversed(of.split(" over ")))
    found = next(finding for finding in findings if finding["of"] == turned)
    return {**_negative(found), "of": of}


def _in_order(found: Mapping[str, Any], pair: str) -> Mapping[str, Any]:
    """Return a finding whose measure is that of a pair in its order; without a pair as it is."""
    if found["measure"].startswith(pair):
        return found
    turned = " minus ".join(reversed(pair.split(" minus ")))
    return {**_negative(found), "measure": found["measure"].replace(turned, pair)}


def _negative(found: Mapping[str, Any]) -> dict[str, Any]:
    return {**found, "estimate": -found["estimate"], "low": -found["high"], "high": -found["low"]}


def outcome_of(found: Mapping[str, Any], truth: float, nothing: float, kind: str) -> str:
    """Return whether an effect was recovered, or its absence; never that from a large p alone.

    Parameters
    ----------
    found : mapping
        A finding.
    truth, nothing : float
        What the estimate should be, and what it should be where there is no effect.
    kind : {"effect", "none"}
        With ``none`` the truth is ``nothing``.
    """
    covers = found["low"] <= truth <= found["high"]
    if kind == "effect":
        if not found["verdict"]:
            return RECOVERED if covers and not found["low"] <= nothing <= found["high"] else NOT_FOUND
        if found["verdict"] != SHOWN or (found["estimate"] - nothing) * (truth - nothing) <= 0:
            return NOT_FOUND
        return RECOVERED if covers else MISSED
    if not found["verdict"]:
        return "the interval covers what is true" if covers else MISSED
    if found["verdict"] == SHOWN:
        return FALSE_ALARM
    if found["margin"] is None:
        return NO_MARGIN
    return ABSENT if found["verdict"] == EQUIVALENT else UNDECIDED


def expected_steps(mean: float, sd: float, low: float, high: float) -> float:
    """Return the mean of normal answers that are rounded to steps and held at the scale's ends."""
    steps = np.arange(low, high + 1)
    edges = np.concatenate(([-np.inf], steps[:-1] + 0.5, [np.inf]))
    shares = np.diff(ndtr((edges - mean) / sd))
    return float(shares @ steps)


def two_alternatives(d: float) -> float:
    """Return the share correct of two alternatives."""
    return float(ndtr(d / math.sqrt(2)))


def share_two_area(effect: SimulatedEffect, study: Study, seed: int) -> float:
    """Return the share correct of "which is generated?" over people."""
    return over_people(effect, two_alternatives)


def share_abx(effect: SimulatedEffect, study: Study, seed: int) -> float:
    """Return the share correct of ABX over people."""
    return over_people(effect, abx_share)


def over_people(effect: SimulatedEffect, share: Callable[[float], float]) -> float:
    """Return the mean of a share over people, whose d' is normal and at least 0."""
    return _over(effect.d_prime, effect.d_prime_sd, share)


@lru_cache(maxsize=64)
def _over(d_prime: float, sd: float, share: Callable[[float], float]) -> float:
    if not sd:
        return share(d_prime)
    equally_likely = ndtri((np.arange(200) + 0.5) / 200)
    return float(np.mean([share(d) for d in np.maximum(0.0, d_prime + sd * equally_likely).tolist()]))


def evoked(item: str) -> Truth:
    """Return the difference of shares of evoked words; people's own normal logits are integrated out."""

    def truth(effect: SimulatedEffect, study: Study, seed: int) -> float:
        nodes, weights = np.polynomial.hermite_e.hermegauss(60)
        own = effect.between_sd / 2 * nodes
        gap = expit(effect.shift.get(item, 0.0) + own) - expit(own)
        return float(weights @ gap / weights.sum())

    return truth


def steps(first: str, second: str = "") -> Truth:
    """Return the difference of mean scores of two conditions, or of an item and the others; scores are steps."""

    def truth(effect: SimulatedEffect, study: Study, seed: int) -> float:
        low, high, words = (getattr(study.design, name) for name in ("low", "high", "words"))
        sd = UNIT["steps"] * math.hypot(effect.between_sd, effect.within_sd)
        means: dict[str, list[float]] = {}
        for stimulus in study.setting.stimuli:
            # A condition that is named as its item is the item.
            names = {stimulus.item, stimulus.condition}
            shift = sum(effect.shift.get(name, 0.0) for name in names)
            for word in words:
                said = 0.15 * typical(effect, seed, stimulus.item, word)
                mean = low + (high - low) * (0.5 + said) + shift
                key = stimulus.condition if second else stimulus.item
                means.setdefault(key, []).append(expected_steps(mean, sd, low, high))
        whole = {key: float(np.mean(values)) for key, values in means.items()}
        others = [whole[second]] if second else [value for key, value in whole.items() if key != first]
        return whole[first] - float(np.mean(others))

    return truth


def level(item: str, correct: float) -> Truth:
    """Return at which level an item's answers are right in a share."""

    def truth(effect: SimulatedEffect, study: Study, seed: int) -> float:
        above = effect.spread_db * float(ndtri((correct - 0.5) / (0.5 - effect.lapse)))
        return effect.threshold_db + effect.shift.get(item, 0.0) + above

    return truth


def without(*names: str) -> Callable[[str], bool]:
    """Return whether a finding is of none of these."""
    return lambda of: not any(name in of.replace(",", " ").split() for name in names)


def _items(item: str) -> Callable[[str], bool]:
    return lambda of: of.endswith(WHOLE) and not of.startswith(f"{item} ")


GAP = "paired t by participant"
LOOKED: Mapping[str, Sequence[Looked]] = {
    "plate-words": (
        Looked(
            "Words",
            f"plate01 {REST}, {WHOLE}",
            GAP,
            steps("plate01"),
            "steps",
            others=_items("plate01"),
            tied=True,
        ),
        Looked("Words", f"plate01 {REST}, rough", GAP, steps("plate01"), "steps"),
    ),
    "evoked-words": (
        Looked(
            "Evoked",
            f"image001 {REST}, {WHOLE}",
            GAP,
            evoked("image001"),
            "share of words",
            others=_items("image001"),
            tied=True,
        ),
    ),
    "abx": (Looked("ABX", "all", "GEE", share_abx, "share correct", 0.5),),
    "display-words": (
        Looked("Words", "A minus sensor", WILCOXON, steps("A", "sensor"), "steps", others=without("A")),
    ),
    "image-words": (
        Looked("Words", "1 minus 1000", WILCOXON, steps("1", "1000"), "steps", others=without("1000")),
    ),
    "magnitude": (Looked("Magnitude", "all", "log-log", lambda e, *_: e.exponent, "exponent"),),
    "two-area": (
        Looked("Which", "all", "GEE", share_two_area, "share correct", 0.5),
        Looked("Realism", "all", GAP, lambda e, *_: e.shift.get("generated", 0.0), "mm"),
    ),
    "preference": (
        Looked(
            "Preference",
            "carpet over cloth",
            "Bradley-Terry",
            lambda e, *_: e.shift.get("carpet", 0.0),
            "log strength",
            others=without("carpet"),
        ),
    ),
    "threshold": (
        Looked(
            "Staircases", "all", GAP, lambda e, *_: e.shift.get("tile", 0.0), "dB", pair="tile minus carpet"
        ),
        Looked("Staircases", "carpet", "logistic fits", level("carpet", SETTLED_3_DOWN), "dB", math.nan),
        Looked("Staircases", "tile", "logistic fits", level("tile", SETTLED_3_DOWN), "dB", math.nan),
    ),
}
"""By study. Confirmatory findings where the study has one of the effect; of a threshold there is no absence."""

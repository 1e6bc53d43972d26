"""Recovery of simulated effects: findings of an analysis compared with their true values."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.experiments.study_truths import Truth
from tactogram_study.analysis.findings import EQUIVALENT, SHOWN
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.study_file import Study

RECOVERED, MISSED, NOT_FOUND = "recovered", "shown, outside the interval", "not shown"
ABSENT, FALSE_ALARM = "equivalent within the margin", "false alarm"
UNDECIDED, NO_MARGIN = "undecided", "not shown; the study gives no margin, so nothing can be equivalent"


@dataclass(frozen=True)
class ExpectedFinding:
    """Finding of an analysis with a known true value.

    Parameters
    ----------
    section : str
        Start of its title.
    of, test : str
        As in the finding; ``test`` is its start.
    truth : Truth
        True value of the estimate.
    unit : str
    nothing : float
        Value of the estimate without an effect.
    others : callable, optional
        Whether a finding of the same test and role, given its ``of``, is about something without an effect.
    tied : bool
        Whether those are compared with the effect, so that they are without one only if there is none at all.
    pair : str
        "FIRST minus SECOND", where the measure names them in order of appearance.
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


def recovery(
    one: ExpectedFinding,
    analysis: Mapping[str, Any],
    study: Study,
    effect: SimulatedEffect,
    *,
    seed: int,
    kind: str,
) -> dict[str, Any]:
    """Return truth, estimate, interval and outcome of one expected finding.

    Parameters
    ----------
    analysis : mapping
        Written by ``study analyse``.
    study : Study
        As taken.
    effect : SimulatedEffect
        Of the participants.
    seed : int
        Of their answers.
    kind : {"effect", "none"}
    """
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
    """Return the first finding with this ``of``, or the negative of the reversed pair."""
    for found in findings:
        if found["of"] == of:
            return found
    reversed_pair = " over ".join(reversed(of.split(" over ")))
    found = next(finding for finding in findings if finding["of"] == reversed_pair)
    return {**_negative(found), "of": of}


def _in_order(found: Mapping[str, Any], pair: str) -> Mapping[str, Any]:
    """Return a finding with its measure in the order of ``pair``, if one is given."""
    if found["measure"].startswith(pair):
        return found
    reversed_pair = " minus ".join(reversed(pair.split(" minus ")))
    return {**_negative(found), "measure": found["measure"].replace(reversed_pair, pair)}


def _negative(found: Mapping[str, Any]) -> dict[str, Any]:
    return {**found, "estimate": -found["estimate"], "low": -found["high"], "high": -found["low"]}


def outcome_of(found: Mapping[str, Any], truth: float, nothing: float, kind: str) -> str:
    """Return whether an effect, or its absence, was recovered; a large p alone is never an absence.

    ``truth`` and ``nothing`` are the true values with the effect and without one.
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

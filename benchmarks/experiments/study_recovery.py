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
    absent: bool,
) -> dict[str, Any]:
    """Return truth, estimate, interval and verdict of one expected finding, and counts of the others of its test.

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
    absent : bool
        Whether nothing was put in.
    """
    findings = next(s["findings"] for s in analysis["sections"] if s["title"].startswith(one.section))
    same = [finding for finding in findings if finding["test"].startswith(one.test)]
    found = _in_order(_found(same, one.of), one.pair)
    truth = one.truth(effect, study, seed)
    counted = one.others if absent or not one.tied else None
    alike = [finding for finding in same if finding["role"] == found["role"]]
    rest = [finding for finding in alike if counted is not None and counted(finding["of"])]
    return {
        "put_in": truth,
        **{key: found[key] for key in ("estimate", "low", "high", "verdict")},
        "covers": None if math.isnan(truth) else found["low"] <= truth <= found["high"],
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

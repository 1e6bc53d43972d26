"""Coverage of each shipped study's analysis, over hundreds of simulated studies, without a browser.

For each design with an effect, with none, and with an effect as large as the margin: how often the 95 % interval
covers the truth, and how often each verdict is given. Participants, stimuli and answers are simulated.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import optimize

from benchmarks.experiments.study_cases import STUDIES, StudyCase
from benchmarks.experiments.study_recovery import ExpectedFinding, recovery
from tactogram.errors import ParameterError
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.progress import ProgressCallback
from tactogram_study.analysis.findings import EQUIVALENT, SHOWN
from tactogram_study.planned import AnalysisPlan
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.simulated_participants import simulated_answers
from tactogram_study.statistics import share_of
from tactogram_study.study_analysis import analyse
from tactogram_study.study_file import Study

KINDS = {"effect": 100_000, "none": 200_000, "margin": 300_000}
"""Kinds of effect, and offsets of their seeds, so that no two kinds share participants."""
SHARE_OF_SEEDS = {"effect": 1.0, "none": 1.0, "margin": 0.5}
"""At the margin only the verdict is of interest: the interval behaves as with an effect."""
OTHERS = ("others", "others_covered", "others_shown", "others_equivalent")
COLUMNS = (
    *("study", "with", "looked at", "studies", "truth", "bias", "covers (95 %)", "shown", "equivalent"),
    *("others: covers", "others: shown", "any of them shown"),
)
NOTES = (
    "covers: share of studies whose interval of 95 % holds the truth (Wilson's interval); * where that lies off .95.",
    "shown, equivalent: share of studies with that verdict; with `none` shown is the false alarms, with `margin`",
    "(the effect is as large as the margin) equivalent is. others: findings of the same test of what nothing was put",
    "into, each with p by Holm where the analysis corrects; any of them shown: false alarms of the family.",
    "bias: mean of the estimates minus the truth, ± its standard error.",
)


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    studies: str = "",
    seeds: int = 0,
    participants: int = 20,
    draws: int = 100,
) -> dict[str, Any]:
    """Return coverage and verdicts of each study, kind by kind.

    Parameters
    ----------
    folder, progress
        As in every experiment. Studies already in ``folder`` are reused.
    paper : bool
        Every trial and word of each study; else with the changes of `STUDIES`, for two cores.
    studies : str
        Names, separated by commas; by default all shipped studies.
    seeds : int
        Simulated studies of each kind; by default as in `STUDIES`, fewer where an analysis is slow.
    participants, draws : int
        Of each study, and of its bootstraps.
    """
    chosen = [name.strip() for name in studies.split(",") if name.strip()] or list(STUDIES)
    if unknown := set(chosen) - set(STUDIES):
        raise ParameterError(f"studies must be of {', '.join(STUDIES)}, got {', '.join(sorted(unknown))}")
    wanted = {
        (name, kind): math.ceil((seeds or STUDIES[name].seeds) * share)
        for name in chosen
        for kind, share in SHARE_OF_SEEDS.items()
    }
    prepared = {name: _Prepared(name, STUDIES[name], paper) for name in chosen}
    # In turn, so that an interrupted run has equally many of each.
    for seed in range(1, max(wanted.values()) + 1):
        for (name, kind), most in wanted.items():
            path = folder / f"{name}-{kind}.jsonl"
            if len(_lines(path)) < seed <= most:
                one = prepared[name].one(kind, seed, participants=participants, draws=draws)
                with path.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(one) + "\n")
    found: dict[str, Any] = {name: {} for name in chosen}
    for (name, kind), most in wanted.items():
        lines = _lines(folder / f"{name}-{kind}.jsonl")[:most]
        found[name][kind] = prepared[name].summary(kind, lines)
    table = table_of(found)
    write_text(folder / "studies_coverage.md", table + "\n")
    return {"simulated": True, "participants": participants, "draws": draws, "studies": found, "text": table}


class _Prepared:
    """One shipped study, with its effect of each kind."""

    def __init__(self, name: str, case: StudyCase, paper: bool) -> None:
        self.changes = {} if paper else dict(case.changes)
        self.study = Study.load(name, changes=self.changes)
        self.findings = case.findings
        self.effects = {
            "effect": {**case.effect, **case.people},
            "none": dict(case.people),
            "margin": {**at_margin(case, self.study), **case.people},
        }

    def one(self, kind: str, seed: int, *, participants: int, draws: int) -> dict[str, Any]:
        """Return the expected findings in the analysis of one simulated study."""
        effect = SimulatedEffect(**self.effects[kind])
        seed += KINDS[kind]
        answers = simulated_answers(self.study, participants, effect=effect, seed=seed)
        analysis = analyse(
            answers, plan=AnalysisPlan.of(self.study.planned, draws=draws, seed=seed)
        ).as_dict()
        looked = [
            recovery(one, analysis, self.study, effect, seed=seed, absent=kind == "none")
            for one in self.findings
        ]
        return {"seed": seed, "looked": looked}

    def summary(self, kind: str, lines: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """Return each expected finding over all simulated studies."""
        places = [
            {
                "of": one.of,
                "test": one.test,
                "unit": one.unit,
                **summary_of([line["looked"][k] for line in lines]),
            }
            for k, one in enumerate(self.findings)
        ]
        return {"changes": self.changes, "put_in": self.effects[kind], "looked": places if lines else []}


def at_margin(case: StudyCase, study: Study) -> dict[str, Any]:
    """Return the effect whose true values differ from those without an effect by the margins.

    Raises
    ------
    ParameterError
        If the study gives no margin for one.
    """
    effect: dict[str, Any] = {}
    for key, place in case.at_margin.items():
        one = case.findings[place.place]
        margin = study.planned.values.get(place.margin)
        if margin is None:
            raise ParameterError(f"{study.name}: margin {place.margin} must be given, got none")
        found = optimize.brentq(_beyond(case, study, one, key, margin), 0.0, place.most)
        table, _, name = key.partition(".")
        if name:
            effect.setdefault(table, {})[name] = place.sign * found
        else:
            effect[table] = found
    return effect


def _beyond(
    case: StudyCase, study: Study, one: ExpectedFinding, key: str, margin: float
) -> Callable[[float], float]:
    table, _, name = key.partition(".")

    def beyond(amount: float) -> float:
        effect = SimulatedEffect(**{**case.people, table: {name: amount} if name else amount})
        return abs(one.truth(effect, study, 0) - one.nothing) - margin

    return beyond


def summary_of(said: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return counts and means of one expected finding over many studies, each as of `recovery`."""
    if not said:
        return {"studies": 0}
    n = len(said)
    known = [one for one in said if one["covers"] is not None]
    errors = np.array([one["estimate"] - one["put_in"] for one in known])
    others, judged = sum(one["others"] for one in said), sum(bool(one["verdict"]) for one in said)
    return {
        "studies": n,
        "put_in": float(np.mean([one["put_in"] for one in known])) if known else None,
        "bias": float(errors.mean()) if known else None,
        "bias_se": float(errors.std(ddof=1) / np.sqrt(n)) if len(known) > 1 else None,
        "sd": float(errors.std(ddof=1)) if len(known) > 1 else None,
        "covered": _counted(sum(one["covers"] for one in known), len(known)),
        "shown": _counted(sum(one["verdict"] == SHOWN for one in said), judged),
        "equivalent": _counted(sum(one["verdict"] == EQUIVALENT for one in said), judged),
        "others": others,
        **{key: _counted(sum(one[key] for one in said), others) for key in OTHERS[1:]},
        "any_other_shown": _counted(
            sum(one["others_shown"] > 0 for one in said if one["others"]), n if others else 0
        ),
    }


def _counted(count: int, n: int) -> dict[str, Any] | None:
    """Return a count with its share and Wilson's interval; None if ``n`` is 0."""
    if not n:
        return None
    low, high = share_of(int(count), n).wilson
    return {"count": int(count), "n": n, "share": count / n, "low": low, "high": high}


def table_of(found: Mapping[str, Any]) -> str:
    """Return the table in Markdown."""
    lines = [
        "Simulated studies, simulated participants, without a browser. No measure of touch.",
        *("", *_row(COLUMNS), *_row(["---"] * len(COLUMNS))),
    ]
    for name, kinds in found.items():
        for kind, facts in kinds.items():
            for one in facts["looked"]:
                lines += _row(_cells(name, kind, one)) if one["studies"] else []
    lines += ["", *NOTES, "", "What was put in, and what was changed for two cores:", ""]
    for name, kinds in found.items():
        put_in = ", ".join(f"{kind} {json.dumps(facts['put_in'])}" for kind, facts in kinds.items())
        changes = json.dumps(next(iter(kinds.values()))["changes"])
        lines.append(f"- {name}: {put_in}; changed: {changes}")
    return "\n".join(lines)


def _cells(name: str, kind: str, one: Mapping[str, Any]) -> Iterator[Any]:
    yield from (name, kind, f"{one['of']} [{one['test']}]", one["studies"])
    yield "-" if one["put_in"] is None else f"{one['put_in']:.3f} {one['unit']}"
    yield "-" if one["bias_se"] is None else f"{one['bias']:+.3f} ± {one['bias_se']:.3f}"
    yield _covered(one["covered"])
    for key in ("shown", "equivalent"):
        yield "-" if one[key] is None else f"{one[key]['share']:.3f}"
    yield _covered(one["others_covered"])
    for key in ("others_shown", "any_other_shown"):
        yield "-" if one[key] is None else f"{one[key]['share']:.3f}"


def _covered(counted: Mapping[str, Any] | None) -> str:
    if counted is None:
        return "-"
    off = "" if counted["low"] <= 0.95 <= counted["high"] else " *"
    return f"{counted['share']:.3f} ({counted['low']:.3f} to {counted['high']:.3f}){off}"


def _row(cells: Iterator[Any] | Sequence[Any]) -> list[str]:
    return ["| " + " | ".join(str(cell).replace("|", "/") for cell in cells) + " |"]


def _lines(path: Path) -> list[dict[str, Any]]:
    """Return the lines of a file, after removing an incomplete last one."""
    if not path.is_file():
        return []
    whole, found = b"", []
    for line in path.read_bytes().splitlines(keepends=True):
        if not line.endswith(b"\n"):
            path.write_bytes(whole)
            break
        whole += line
        found.append(json.loads(line))
    return found

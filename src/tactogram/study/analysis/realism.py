"""Marks on a visual analogue scale under two conditions that the same people met.

As printed (Saga et al., Fig. 13): Student's t per texture, every mark taken as independent. Here: differences of each
participant's means, paired.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from tactogram.errors import DataError
from tactogram.statistics.clustered import mixed_difference
from tactogram.statistics.comparison import student_t
from tactogram.statistics.equivalence import paired_equivalence
from tactogram.statistics.multiplicity import holm
from tactogram.statistics.signed_rank import pseudomedian, signed_rank_p
from tactogram.statistics.summary import Summary, summary
from tactogram.study.analysis.findings import Finding, Role, Section, answered, verdict_of
from tactogram.study.session.answers import Answers

Numbers = NDArray[np.float64]


def analyse_realism(answers: Answers, *, margin: float | None = None, unit: str = "mm") -> Section:
    """Return what is said of marks in two conditions.

    Confirmatory is the paired t-test of the participants' means over all textures.

    Parameters
    ----------
    answers : Answers
        ``value`` is the mark, ``condition`` one of two, ``stimulus`` the texture.
    margin : float, optional
        In the unit of the scale, given before the answers were seen.
    unit : str
        Of the marks.

    Raises
    ------
    DataError
        If there are not two conditions, or no two participants who met both.
    ParameterError
        If the margin is not > 0.
    """
    kept, notes = answered(answers, "realism")
    names = tuple(sorted(set(kept.column("condition"))))
    if len(names) != 2:
        raise DataError(
            f"realism: must have two conditions to compare, got {len(names)} ({', '.join(names) or 'none'})"
        )
    measure = f"{names[0]} minus {names[1]}, {unit}"
    whole = _differences(kept, names)
    if len(whole) < 2:
        raise DataError(f"realism: two participants must have met both conditions, got {len(whole)}")
    if left := len(set(kept.column("participant"))) - len(whole):
        notes += (f"{left} participants who met one condition only are left out",)
    values = np.array(list(whole.values()))
    findings = [
        *paired_findings(values, "all", measure, margin=margin, n=len(kept), roles=("confirmatory", "check")),
        _mixed(kept, names, measure),
    ]
    per, rows = _textures(kept, names, measure, margin)
    notes += (
        "Student's t as printed takes every mark as independent, which repeated marks of one person are not",
    )
    return Section(
        f"Realism: {names[0]} and {names[1]}",
        kept.rows[0].design,
        kept.rows[0].question,
        len(set(kept.column("participant"))),
        len(kept),
        any(kept.column("simulated")),
        (*findings, *per),
        {f"marks per texture, {unit}": rows},
        notes,
    )


def paired_findings(
    differences: Numbers,
    of: str,
    measure: str,
    *,
    margin: float | None = None,
    n: int,
    roles: tuple[Role, Role] = ("check", "check"),
    ps: tuple[float, float] | None = None,
    equivalence_p: float | None = None,
) -> list[Finding]:
    """Return the paired t-test with interval, Cohen's dz and equivalence, and Wilcoxon's beside it.

    Parameters
    ----------
    differences : float64 array, shape (participant,)
    of, measure : str
    margin : float, optional
    n : int
        Answers that went into them.
    roles : tuple of two roles
        Of the t-test and of Wilcoxon's.
    ps : tuple of (float, float), optional
        Both p after Holm's correction, where there are several such tests.
    equivalence_p : float, optional
        The same of the test of equivalence.
    """
    found: Summary = summary(differences)
    raw = paired_ps(differences)
    p, rank_p = ps or raw
    equal = None if margin is None else paired_equivalence(differences, margin=margin).p
    if equivalence_p is not None:
        equal = equivalence_p
    people, correction = len(differences), "Holm" if ps else "none"
    size = {"dz": found.mean / found.sd} if found.sd > 0 else {}
    t = Finding(
        of,
        "paired t by participant",
        roles[0],
        measure,
        found.mean,
        found.low,
        found.high,
        p,
        verdict_of(p, equivalence_p=equal),
        n,
        people,
        found.mean / found.se if found.se > 0 else None,
        size,
        equal,
        margin,
        correction,
    )
    rank = Finding(
        of,
        "Wilcoxon signed ranks by participant, Hodges-Lehmann",
        roles[1],
        f"pseudomedian of {measure}",
        *pseudomedian(differences),
        rank_p,
        verdict_of(rank_p, equivalence_p=equal),
        n,
        people,
        equivalence_p=equal,
        margin=margin,
        correction=correction,
        note="equivalence is by paired t" if margin is not None else "",
    )
    return [t, rank]


def holm_paired(
    gaps: Mapping[str, tuple[Numbers, int]],
    measure: str,
    margin: float | None,
    roles: tuple[Role, Role] = ("check", "check"),
) -> list[Finding]:
    """Return `paired_findings` of several things, every p with Holm's correction over them.

    Parameters
    ----------
    gaps : mapping from str to (float64 array of shape (participant,), int)
        Differences, and answers that went into them, by what they are of.
    measure : str
    margin : float, optional
    roles : tuple of two roles
    """
    both = [paired_ps(differences) for differences, _ in gaps.values()]
    t_p, rank_p = (holm([pair[k] for pair in both]) for k in (0, 1))
    equal: list[float | None] = [None] * len(gaps)
    if margin is not None:
        equal = [*holm([paired_equivalence(d, margin=margin).p for d, _ in gaps.values()])]
    return [
        finding
        for (of, (differences, n)), t, rank, e in zip(gaps.items(), t_p, rank_p, equal, strict=True)
        for finding in paired_findings(
            differences, of, measure, margin=margin, n=n, roles=roles, ps=(t, rank), equivalence_p=e
        )
    ]


def paired_ps(differences: Numbers) -> tuple[float, float]:
    """Return p of Student's t and of Wilcoxon's signed ranks of differences against 0."""
    if not differences.any():
        return 1.0, 1.0
    found = summary(differences)
    # Differences without spread: t is infinite, as it should be.
    t = abs(found.mean) / found.se if found.se > 0 else np.inf
    return float(2 * stats.t.sf(t, found.n - 1)), signed_rank_p(differences)


def _differences(kept: Answers, names: tuple[str, ...]) -> dict[str, float]:
    """Return each participant's difference: textures that both conditions have, each weighing the same."""
    cells: dict[tuple[str, str, str], list[float]] = {}
    for row in kept:
        cells.setdefault((row.participant, row.stimulus, row.condition), []).append(row.value)
    per: dict[str, list[float]] = {}
    for (person, item, condition), marks in cells.items():
        if condition == names[0] and (person, item, names[1]) in cells:
            per.setdefault(person, []).append(float(np.mean(marks) - np.mean(cells[person, item, names[1]])))
    return {person: float(np.mean(values)) for person, values in per.items()}


def _mixed(kept: Answers, names: tuple[str, ...], measure: str) -> Finding:
    first = np.array([row.condition == names[0] for row in kept])
    found = mixed_difference(kept.numbers(), first, kept.column("participant"), kept.column("stimulus"))
    return Finding(
        "all",
        "linear mixed model, participants and textures at random",
        "check",
        measure,
        found.estimate,
        found.low,
        found.high,
        found.p,
        verdict_of(found.p),
        len(kept),
        len(set(kept.column("participant"))),
        found.statistic,
        note=found.note,
    )


def _textures(
    kept: Answers, names: tuple[str, ...], measure: str, margin: float | None
) -> tuple[list[Finding], list[dict[str, Any]]]:
    groups: Mapping[str, Answers] = kept.by("stimulus")
    printed, rows, paired = [], [], {}
    for item, group in groups.items():
        marks = {name: group.where(condition=name).numbers() for name in names}
        row: dict[str, Any] = {"texture": item}
        for name, values in marks.items():
            if len(values):
                s = summary(values)
                row |= {f"{name} n": s.n, f"{name} mean": s.mean, f"{name} se": s.se}
        rows.append(row)
        if min(len(values) for values in marks.values()) >= 2:
            test = student_t(marks)
            pair = test.pairs[0]
            printed.append(
                Finding(
                    item,
                    "Student's t, uncorrected",
                    "as printed",
                    measure,
                    pair.difference,
                    p=pair.p,
                    verdict=verdict_of(pair.p),
                    n=len(group),
                    participants=len(set(group.column("participant"))),
                    statistic=pair.statistic,
                )
            )
        differences = np.array(list(_differences(group, names).values()))
        if len(differences) >= 2:
            paired[item] = (differences, len(group))
    if len(groups) < 2 or not paired:
        return printed, rows
    return printed + holm_paired(paired, measure, margin), rows

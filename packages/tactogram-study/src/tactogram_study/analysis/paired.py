"""Paired tests of participants' differences: Student's t, Wilcoxon's signed ranks, and equivalence."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from tactogram.statistics import holm, paired_equivalence, pseudomedian, signed_rank_p, summary
from tactogram_study.analysis.findings import Finding, Role

Numbers = NDArray[np.float64]


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
    """Return the paired t-test with interval, Cohen's dz and equivalence, and Wilcoxon's, of ``n`` answers.

    ``roles`` are those of the t-test and of Wilcoxon's; ``ps`` and ``equivalence_p`` replace their p and that of the
    test of equivalence after Holm's correction.
    """
    found = summary(differences)
    p, rank_p = ps or paired_ps(differences)
    equal = equivalence_p
    if equal is None and margin is not None:
        equal = paired_equivalence(differences, margin=margin)
    correction = "Holm" if ps else "none"
    t = Finding(
        of,
        "paired t by participant",
        roles[0],
        measure,
        found.mean,
        found.low,
        found.high,
        p,
        n=n,
        participants=len(differences),
        statistic=found.mean / found.se if found.se > 0 else None,
        effect={"dz": found.mean / found.sd} if found.sd > 0 else {},
        equivalence_p=equal,
        margin=margin,
        correction=correction,
    )
    rank = Finding(
        of,
        "Wilcoxon signed ranks by participant, Hodges-Lehmann",
        roles[1],
        f"pseudomedian of {measure}",
        *pseudomedian(differences),
        rank_p,
        n=n,
        participants=len(differences),
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
    """Return the `paired_findings` of several comparisons, every p with Holm's correction over them.

    ``gaps`` holds, by comparison, the participants' differences and the number of answers.
    """
    both = [paired_ps(differences) for differences, _ in gaps.values()]
    t_p, rank_p = (holm([pair[k] for pair in both]) for k in (0, 1))
    equal: list[float | None] = [None] * len(gaps)
    if margin is not None:
        equal = [*holm([paired_equivalence(d, margin=margin) for d, _ in gaps.values()])]
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

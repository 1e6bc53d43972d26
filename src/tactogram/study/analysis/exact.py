"""Exact binomial tests of shares, as findings."""

from __future__ import annotations

from typing import Any

from tactogram.statistics.shares import ShareEstimate
from tactogram.study.analysis.findings import Finding, Role, verdict_of


def exact_finding(
    of: str,
    share: ShareEstimate,
    measure: str,
    *,
    participants: int,
    role: Role = "check",
    test: str = "exact binomial, interval by Wilson",
    p: float | None = None,
    equivalence_p: float | None = None,
    **more: Any,
) -> Finding:
    """Return the finding of a share that is tested against chance, with Wilson's interval.

    Parameters
    ----------
    of, measure : str
    share : ShareEstimate
    participants : int
    role, test
        As `Finding` has them.
    p : float, optional
        After a correction; by default that of the share.
    equivalence_p : float, optional
    **more
        Further values of the `Finding`.
    """
    p = share.p if p is None else p
    verdict = verdict_of(p, equivalence_p=equivalence_p)
    place = (share.share, *share.wilson, p, verdict, share.n, participants)
    return Finding(of, test, role, measure, *place, equivalence_p=equivalence_p, **more)

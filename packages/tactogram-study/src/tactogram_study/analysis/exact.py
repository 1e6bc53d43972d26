"""Exact binomial tests of shares, as findings and table columns."""

from __future__ import annotations

from typing import Any

from tactogram.statistics import ShareEstimate
from tactogram_study.analysis.findings import Finding, Role


def exact_finding(
    of: str,
    share: ShareEstimate,
    measure: str,
    *,
    participants: int,
    role: Role = "check",
    test: str = "exact binomial, interval by Wilson",
    p: float | None = None,
    **more: Any,
) -> Finding:
    """Return the finding of a share tested against one half, with Wilson's interval.

    ``p`` replaces the share's own after a correction; ``more`` are further values of the `Finding`.
    """
    estimate = (share.share, *share.wilson, share.p if p is None else p)
    return Finding(of, test, role, measure, *estimate, n=share.n, participants=participants, **more)


def share_columns(share: ShareEstimate) -> dict[str, float]:
    """Return the columns of a table with a share and its intervals."""
    wilson, clopper_pearson = share.wilson, share.clopper_pearson
    return {
        "share": share.share,
        "wilson_low": wilson[0],
        "wilson_high": wilson[1],
        "clopper_pearson_low": clopper_pearson[0],
        "clopper_pearson_high": clopper_pearson[1],
    }

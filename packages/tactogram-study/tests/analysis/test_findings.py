"""Verdicts."""

import pytest

from tactogram_study.analysis.findings import (
    EQUIVALENT,
    NOT_SHOWN,
    SHOWN,
    UNDECIDED,
    AnalysisSection,
    Finding,
    verdict_of,
    with_verdicts,
)


def test_verdicts_never_say_that_there_is_no_difference():
    assert verdict_of(0.01) == verdict_of(0.01, equivalence_p=0.01) == SHOWN
    assert verdict_of(0.9) == NOT_SHOWN
    assert verdict_of(0.9, equivalence_p=0.04) == EQUIVALENT
    assert verdict_of(0.9, equivalence_p=0.06) == UNDECIDED


@pytest.mark.parametrize(("alpha", "verdict"), [(0.05, SHOWN), (0.01, UNDECIDED)])
def test_alpha_decides_and_intervals_stay(alpha, verdict):
    finding = Finding(
        "all", "t", "confirmatory", "mm", 1.0, 0.1, 1.9, 0.03, SHOWN, equivalence_p=0.02, margin=5.0
    )
    by_interval = Finding("all", "mixed", "check", "mm", 1.0, 0.1, 1.9, verdict=SHOWN)
    section = AnalysisSection("T", "two_area", "realism", 8, 80, True, (finding, by_interval))
    first, second = with_verdicts(section, alpha=alpha).findings
    assert (first.verdict, first.low, first.high) == (verdict, 0.1, 1.9)
    assert second.verdict == ("" if alpha != 0.05 else SHOWN)
    assert ("smaller than the margin" in first.note) == (alpha == 0.05)

"""Reports of a fit."""

import numpy as np
import pytest

from tactogram.rendering.drive.report import FitReport, percent, signal_facts
from tactogram.signal import Signal


def three():
    return Signal(np.random.default_rng(0).normal(size=(3, 200)), 1000, "m/s^2")


def test_a_report_with_something_that_is_no_json_is_a_defect():
    facts = signal_facts(three())
    report = FitReport("d", "linear", {"asked": "physical"}, facts, facts, facts={"x": float("nan")})
    with pytest.raises(ValueError, match="JSON compliant"):
        report.as_json()
    assert "clipped: nothing" in report.as_text()


@pytest.mark.parametrize(
    ("share", "words"),
    [(1.0, "100 %"), (0.999, "100 %"), (0.0423, "4.2 %"), (3.14e-4, "0.031 %"), (0.0, "0 %")],
)
def test_a_share_is_said_in_two_digits(share, words):
    assert percent(share) == words

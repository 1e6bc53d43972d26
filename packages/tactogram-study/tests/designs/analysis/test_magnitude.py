"""Magnitudes: Stevens' exponent."""

import numpy as np
import pytest
from simulated_answers import only, simulated

from tactogram_study.analysis.findings import EQUIVALENT
from tactogram_study.planned import AnalysisPlan
from tactogram_study.study_analysis import analyse


def flattened(rows):
    """Return estimates that do not grow with intensity."""
    rng = np.random.default_rng(1)
    noise = np.exp(0.05 * rng.standard_normal(len(rows)))
    return simulated(
        "magnitude",
        "magnitude",
        [(p, t, {**columns, "value": float(v)}) for (p, t, columns), v in zip(rows, noise, strict=True)],
    )


def test_stevens_exponent_is_found_whatever_numbers_people_choose():
    rng = np.random.default_rng(0)
    rows = []
    for p in range(8):
        scale, own = np.exp(3 * rng.standard_normal()), 0.6 + 0.05 * rng.standard_normal()
        for t, x in enumerate([0.1, 0.2, 0.4, 0.8] * 2):
            value = float(scale * x**own * np.exp(0.1 * rng.standard_normal()))
            rows.append((p, t + 1, {"stimulus": f"s{x}", "level": f"gain={x}", "value": value}))
    section = only(analyse(simulated("magnitude", "magnitude", rows)))
    [exponent] = section.role("confirmatory")
    assert exponent.low < 0.6 < exponent.high
    assert exponent.margin is None
    flat = only(analyse(flattened(rows), plan=AnalysisPlan({"magnitude": 0.1}))).role("confirmatory")
    assert [one.verdict for one in flat] == [EQUIVALENT]
    means = [row["geometric_mean"] for row in section.tables["geometric means"]]
    assert means[3] / means[0] == pytest.approx(8**0.6, rel=0.15)

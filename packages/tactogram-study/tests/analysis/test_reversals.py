import numpy as np
import pytest
from scipy import special

from tactogram_study.analysis.threshold import reversal_threshold
from tactogram_study.designs.staircase.power import simulated_thresholds


def test_reversals_leave_out_the_first_and_count_peaks_and_valleys_alike():
    x, turned = [0, 8, 4, 6, 2, 4, 3], [False, True, True, True, True, True, False]
    assert reversal_threshold(x, turned) == pytest.approx((2 + 4) / 2)
    assert reversal_threshold(x, [False] * 7) is None


def test_simulated_staircases_settle_where_three_in_a_row_are_as_likely_as_not():
    rng = np.random.default_rng(0)
    place = np.full(400, -20.0)
    found = simulated_thresholds(place, 120, slope=0.5, rng=rng)
    settled = -20 + special.logit((0.5 ** (1 / 3) - 0.5) / 0.5) / 0.5
    assert found.mean() == pytest.approx(settled, abs=0.5)

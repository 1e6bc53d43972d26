import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.statistics.reliability import intraclass_correlation, krippendorff_alpha

NAN = np.nan
# K. Krippendorff, "Computing Krippendorff's Alpha-Reliability", 2011, Sec. C to E: 4 observers, 12 units, missing data.
# He prints 0.743 (nominal), 0.815 (ordinal), 0.849 (interval).
KRIPPENDORFF = np.array(
    [
        [1, 2, 3, 3, 2, 1, 4, 1, 2, NAN, NAN, NAN],
        [1, 2, 3, 3, 2, 2, 4, 1, 2, 5, NAN, 3],
        [NAN, 3, 3, 3, 2, 3, 4, 2, 2, 5, 1, NAN],
        [1, 2, 3, 3, 2, 4, 4, 1, 2, 5, 1, NAN],
    ]
).T
# P. E. Shrout, J. L. Fleiss, Psychological Bulletin 86 (1979), Table 2: six targets, four judges. They print
# ICC(2,1) = 0.29 and ICC(2,4) = 0.62 (Table 4).
SHROUT_FLEISS = np.array(
    [[9, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9], [6, 2, 4, 7]]
)


@pytest.mark.parametrize(("level", "alpha"), [("nominal", 0.743), ("ordinal", 0.815), ("interval", 0.849)])
def test_alpha_is_that_of_krippendorffs_example(level, alpha):
    assert krippendorff_alpha(KRIPPENDORFF, level=level) == pytest.approx(alpha, abs=5e-4)


def test_alpha_of_those_who_agree_is_one_and_of_chance_is_none():
    agreed = np.repeat(np.arange(7.0)[:, None], 5, 1)
    assert krippendorff_alpha(agreed, level="interval") == 1.0
    chance = np.random.default_rng(0).integers(1, 8, (300, 10)).astype(float)
    assert abs(krippendorff_alpha(chance, level="ordinal")) < 0.03


def test_alpha_is_undefined_where_nothing_differs_or_nobody_met_another():
    assert krippendorff_alpha(np.ones((5, 3)), level="interval") is None
    assert krippendorff_alpha([[1, NAN], [NAN, 2]], level="interval") is None


def test_items_of_one_score_say_nothing():
    more = np.vstack([KRIPPENDORFF, [NAN, 7, NAN, NAN]])
    for level in ("nominal", "ordinal", "interval"):
        assert krippendorff_alpha(more, level=level) == krippendorff_alpha(KRIPPENDORFF, level=level)


def test_correlations_are_those_of_shrout_and_fleiss():
    found = intraclass_correlation(SHROUT_FLEISS)
    assert found.single == pytest.approx(0.29, abs=5e-3)
    assert found.average == pytest.approx(0.62, abs=5e-3)
    assert (found.items, found.raters, found.left_out_items, found.left_out_raters) == (6, 4, 0, 0)


def test_who_lacks_a_score_is_left_out_of_correlations_and_counted():
    absent = np.column_stack([SHROUT_FLEISS, [9, NAN, NAN, 7, 8, 9]])
    found = intraclass_correlation(absent)
    assert found.single == intraclass_correlation(SHROUT_FLEISS).single
    assert found.left_out_raters == 1


def test_correlations_need_two_complete_raters_and_a_difference():
    assert intraclass_correlation([[1, NAN], [NAN, 2], [3, NAN]]) is None
    assert intraclass_correlation(np.ones((4, 4))) is None


def test_what_is_no_table_is_refused():
    with pytest.raises(ParameterError, match=r"shape \(item, rater\), got shape \(3,\)"):
        krippendorff_alpha([1, 2, 3], level="nominal")
    with pytest.raises(ParameterError, match="finite"):
        intraclass_correlation([[1, np.inf], [1, 2]])
    with pytest.raises(ParameterError, match="nominal, ordinal, interval, got 'ratio'"):
        krippendorff_alpha(SHROUT_FLEISS, level="ratio")

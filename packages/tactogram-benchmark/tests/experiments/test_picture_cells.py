"""Cells of tables of pictures: their comparison in pairs."""

import pytest

from tactogram_benchmark.experiments.picture_cells import against


def test_the_paired_test_is_scipys():
    assert against([1.0, 2.0, 3.0], [2.0, 3.5, 3.9]) == pytest.approx(0.0256, abs=1e-3)
    assert against([1.0, 2.0], [2.0, 3.0]) is None
    assert against([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]) is None

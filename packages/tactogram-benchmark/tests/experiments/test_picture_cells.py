"""Cells of tables of pictures: their comparison in pairs."""

import pytest

from tactogram_benchmark.experiments.picture_cells import MEASURES, against


def test_measures_are_those_of_the_paper_first_and_none_is_pixel_by_pixel():
    """Sec. 4.1: "the LPIPS and the FID"; "Standard metrics such as PSNR and SSIM are not employed"."""
    assert MEASURES[:2] == ("lpips", "fid")
    assert not {"psnr", "ssim"} & set(MEASURES)


def test_the_paired_test_is_scipys():
    """Sec. 4.3: "two-sided paired t-tests were conducted"."""
    assert against([1.0, 2.0, 3.0], [2.0, 3.5, 3.9]) == pytest.approx(0.0256, abs=1e-3)
    assert against([1.0, 2.0], [2.0, 3.0]) is None
    assert against([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]) is None

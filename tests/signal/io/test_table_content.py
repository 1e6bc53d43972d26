"""Numbers of a table at even times."""

import numpy as np
import openpyxl
import pytest
from tests.signal.io.sample_files import written

from tactogram.signal.io import read_file, read_signal


def test_jittered_stamps_are_resampled_and_reported(tmp_path):
    rng = np.random.default_rng(0)
    t = (np.arange(2000) + 0.1 * rng.normal(size=2000)) / 1000
    text = "t [s],a [mm]\n" + "\n".join(f"{v:.9f},{np.sin(2 * np.pi * 100 * v):.9f}" for v in t)
    file = read_file(written(tmp_path, text))
    expected = np.sin(2 * np.pi * 100 * (t[0] + np.arange(len(file.signal)) / file.signal.rate))
    np.testing.assert_allclose(1000 * file.signal.samples[0, 30:-30], expected[30:-30], atol=1e-3)
    assert file.signal.unit == "m"
    assert file.timing.jitter_rms == pytest.approx(1e-4, rel=0.1)
    assert read_signal(written(tmp_path, text), rate=500).rate == 500


@pytest.mark.parametrize(
    ("missing", "suffix"), [("", ".csv"), ("nan", ".csv"), ("NaN", ".csv"), ("", ".xlsx")]
)
def test_short_gaps_are_interpolated_and_reported(missing, suffix, tmp_path):
    wave = np.sin(2 * np.pi * np.arange(400) / 25)
    rows = [[k / 100, value, -value] for k, value in enumerate(wave)]
    for k in (100, 200, 201, 202):
        rows[k][2 if k < 200 else 1] = missing
    if suffix == ".csv":
        path = written(tmp_path, "t [s],x [g],y [g]\n" + "\n".join(",".join(map(str, row)) for row in rows))
    else:
        path, book = tmp_path / "a.xlsx", openpyxl.Workbook()
        for row in (["t [s]", "x [g]", "y [g]"], *rows):
            book.active.append(row)
        book.save(path)
    file = read_file(path)
    assert file.timing.dropped == 4
    np.testing.assert_allclose(file.signal.samples[0], 9.80665 * wave, atol=0.05)

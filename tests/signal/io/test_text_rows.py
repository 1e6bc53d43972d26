"""Rows of text."""

import numpy as np
import pytest
from tests.signal.io.sample_files import X, written

from tactogram.signal.io import read_signal


@pytest.mark.parametrize("separator", [",", ";", "\t", " ", "  ", ", "])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_any_separator(tmp_path, separator, end):
    lines = ["time_ms" + separator + "x" + separator + "y"]
    lines += [f"{i}{separator}{v:.6f}{separator}{-v:.6e}" for i, v in enumerate(X)]
    signal = read_signal(written(tmp_path, "\ufeff" + end.join(lines)), unit="m/s^2")
    assert signal.rate == pytest.approx(1000)
    assert signal.axes == ("x", "y")
    np.testing.assert_allclose(signal.samples, [X, -X], atol=1e-6)


def test_comments_blank_lines_quotes_and_last_separators(tmp_path):
    text = '# made by a logger\n% rate 100\n\n"t [s]","x, left"\n' + "\n".join(
        f'{i / 100},"{i}"' for i in range(9)
    )
    assert read_signal(written(tmp_path, text)).axes == ("x",)
    text = "t,a\n" + "".join(f"{i / 100},{i},\n" for i in range(9))
    np.testing.assert_array_equal(read_signal(written(tmp_path, text)).samples[0], np.arange(9))

"""What stands above a table."""

import numpy as np
from tests.signal.io.sample_files import X, written

from tactogram.signal.io import read_signal


def test_a_table_without_heading(tmp_path):
    text = "\n".join(f"{i % 4} {i % 5} {i % 7}" for i in range(9))
    signal = read_signal(written(tmp_path, text, "a.txt"), rate=100, unit="N")
    assert (signal.rate, signal.axes) == (100, ("x", "y", "z"))
    assert read_signal(written(tmp_path, text, "a.txt"), rate=100, axes=["2"]).samples[0, 5] == 0
    one = read_signal(written(tmp_path, "1\n2\n3\n", "b.txt"), rate=10000)
    np.testing.assert_array_equal(one.samples, [[1, 2, 3]])
    assert one.axes == ("z",)


def test_a_heading_in_a_comment_as_numpy_writes_it(tmp_path):
    np.savetxt(tmp_path / "a.txt", np.stack([np.arange(9) / 50, X[:9]], axis=1), header="t [s] force")
    signal = read_signal(tmp_path / "a.txt")
    assert (signal.axes, signal.rate) == (("force",), 50)

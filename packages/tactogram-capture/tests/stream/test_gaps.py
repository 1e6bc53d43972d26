"""Signals without gaps from samples with gaps."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram.errors import DataError
from tactogram_capture import filled, gap_free
from tactogram_capture.stream.gaps import gaps


def with_gaps(*holes, n=100):
    x = np.arange(3 * n, dtype=np.float32).reshape(3, n)
    for start, stop in holes:
        x[:, start:stop] = np.nan
    return x


def test_segments_contain_the_measured_samples_and_their_positions():
    x = with_gaps((20, 30), (50, 51))
    pieces = gap_free(x, 100.0, "m/s^2", ("x", "y", "z"))

    assert [(p.first_index, len(p.signal)) for p in pieces] == [(0, 20), (30, 20), (51, 49)]
    assert (pieces[1].signal.samples == x[:, 30:50]).all()
    assert pieces[1].signal.rate == 100.0


def test_filling_by_lines_is_reported_and_leaves_the_measured_samples():
    x = with_gaps((20, 22), (50, 53))
    signal, report = filled(x, 100.0, "m/s^2")

    came = np.isfinite(x)
    assert (signal.samples[came] == x[came]).all()
    # The test's samples lie on a line, which a line then gives back.
    assert signal.samples == pytest.approx(with_gaps(), abs=1e-3)
    assert report == {"samples": 5, "gaps": 2, "longest": 3, "share": 0.05}


def test_gaps_at_the_ends_are_cut_off_and_not_filled():
    signal, report = filled(with_gaps((0, 5), (90, 100)), 100.0, "m/s^2")

    assert len(signal) == 85
    assert report["samples"] == 0


def test_a_gap_longer_than_allowed_is_refused():
    with pytest.raises(DataError, match=r"a gap of 0.2 s is longer than the limit for filling \(0.1 s\)"):
        filled(with_gaps((20, 40)), 100.0, "m/s^2")


def test_nothing_but_gaps_is_refused():
    with pytest.raises(DataError, match="all 100 samples were lost"):
        filled(with_gaps((0, 100)), 100.0, "m/s^2")


@given(st.lists(st.booleans(), min_size=1, max_size=80))
def test_segments_and_gaps_make_up_the_whole(came):
    x = np.where(came, np.float32(1), np.float32(np.nan))[None]
    held = [(p.first_index, p.first_index + len(p.signal)) for p in gap_free(x, 1.0, "1")]
    covered = sorted(held + gaps(x))

    assert [start for start, _ in covered] == [0, *(stop for _, stop in covered[:-1])]
    assert covered[-1][1] == len(came)

"""Channels of a device: units, and gaps by their time stamps."""

import numpy as np
import pytest

from tactogram_capture.stream.channels import described_unit, split_at_gaps


def test_jitter_of_stamps_is_no_gap_and_a_stream_without_rate_has_none():
    stamps = np.cumsum(np.random.default_rng(1).exponential(0.01, 200))
    samples = np.zeros((1, 200), np.float32)

    assert sum(p.shape[1] for p in split_at_gaps(samples, stamps, 100.0, None)) == 200
    assert split_at_gaps(samples, stamps * 100, None, None)[0].shape == (1, 200)


def test_unit_is_the_given_one_else_that_of_all_channels_else_counts():
    assert described_unit("mg", ["V", "V"])[0] == "m/s^2"
    assert described_unit(None, ["mV", "mV"]) == ("V", pytest.approx(1e-3))
    assert described_unit(None, ["mV", "g"]) == ("1", 1.0)
    assert described_unit(None, ["microvolts"]) == ("V", pytest.approx(1e-6))
    assert described_unit(None, ["arbitrary"]) == ("1", 1.0)

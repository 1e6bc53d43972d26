"""Takes: losses are marked, reported and restored."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram.errors import DataError
from tactogram_capture.session.take import Take, joined, rate_of, recording_of, restored
from tactogram_capture.source import Block
from tactogram_capture.stream.gaps import bridged

AXES = ("x", "y", "z")


def take(samples, rate=330.0, measured=329.9):
    return Take(np.asarray(samples, np.float32), AXES, "m/s^2", rate, measured, 70)


def noise(n=100, seed=0):
    return np.random.default_rng(seed).standard_normal((3, n)).astype(np.float32)


@given(st.lists(st.booleans(), min_size=2, max_size=60).filter(any), st.integers(0, 5))
def test_lost_samples_are_restored_as_lost_and_received_ones_exactly(came, seed):
    samples = noise(len(came), seed)
    samples[:, ~np.array(came)] = np.nan
    recording = recording_of(take(samples), what={"material": "a"}, simulated=False)
    np.testing.assert_array_equal(restored(recording), samples)
    assert ("received" in recording.streams) == (not all(came))


def test_a_loss_is_bridged_by_a_straight_line_and_reported():
    samples = noise()
    samples[:, 30:40] = np.nan
    recording = recording_of(take(samples), what={}, simulated=True)
    x = recording.stream("acceleration").samples.astype(np.float64)
    a, b = x[:, 29], x[:, 40]
    np.testing.assert_allclose(x[:, 34], a + (b - a) * 5 / 11, atol=1e-6)
    assert recording.stream("received").samples.sum() == 90
    assert "lost 10 of 100 samples in 1 gaps" in recording.history[1]
    assert "0.091-0.121" in recording.history[1]
    assert "measured 329.9 Hz (-303 ppm)" in recording.history[0]
    assert recording.simulated


def test_a_take_without_losses_has_no_stream_of_losses():
    recording = recording_of(take(noise()), what={}, simulated=False)
    assert set(recording.streams) == {"acceleration"}
    assert len(recording.history) == 1


def test_a_take_with_all_samples_lost_is_no_recording():
    with pytest.raises(DataError, match="all 5 samples were lost"):
        bridged(np.full((3, 5), np.nan, np.float32))


@pytest.mark.parametrize(
    ("measured", "reference", "rate"),
    [
        ((330.2, 330.1, 330.3), 330.0, 330.0),  # near
        ((331.0, 329.0, 333.0), 330.0, 330.0),  # not sure that it is another
        ((331.0, 330.9, 331.1), 330.0, 331.0),
        ((385.0, 360.0, 400.0), 330.0, 330.0),  # a busy computer: a few arrivals say little
        ((400.0, 399.5, 400.5), 330.0, 400.0),
        (None, 330.0, 330.0),
        ((328.0, 327.9, 328.1), None, 328.0),
        ((328.0, 320.0, 336.0), None, None),  # not known well enough to begin
        (None, None, None),
    ],
)
def test_the_rate_is_nominal_unless_the_measurement_contradicts_it(measured, reference, rate):
    measured = measured and dict(zip(("hz", "low", "high"), measured, strict=True))
    assert rate_of(measured, reference) == rate


def test_blocks_are_cut_at_the_limits_and_must_be_consecutive():
    samples = noise(30)
    blocks = [Block(samples[:, i : i + 10], i, 0.0) for i in (0, 10, 20)]
    np.testing.assert_array_equal(joined(blocks, start=7, stop=23), samples[:, 7:23])
    with pytest.raises(DataError, match="consecutive"):
        joined([blocks[0], blocks[2]], start=0, stop=30)
    with pytest.raises(DataError, match="no sample"):
        joined(blocks, start=40, stop=50)

"""Live recognition: latest windows, reported losses, measured latency, no queue."""

from itertools import pairwise

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_capture.cli.live_view import line
from tactogram_capture.live.recognition import Classification, Latencies, classify_windows, window_signal
from tactogram_capture.session.feed import Feed


def run(source, *, listen=None, clock=None, **options):
    heard = []

    def default(signal):
        heard.append(signal)
        return Classification({"a": 0.25, "b": 0.75}, none_of_these=False)

    clock = clock or (lambda: 0.03 * source.packet)
    feed = Feed(source, clock=clock)
    found = list(
        classify_windows(feed, listen or default, **({"window_s": 1.0, "hop_s": 0.5} | options), clock=clock)
    )
    return found, heard


def test_windows_contain_the_latest_samples_and_follow_by_the_hop(played):
    source = played(packets=100)
    found, heard = run(source)
    all_played = np.concatenate(source.played, axis=1)
    ends = [guess.end_index for guess in found]
    assert ends[0] == 330
    assert all(165 <= b - a < 175 for a, b in pairwise(ends))
    for guess, signal in zip(found, heard, strict=True):
        np.testing.assert_array_equal(signal.samples, all_played[:, guess.end_index - 330 : guess.end_index])
        assert signal.rate == 330.0


def test_the_first_window_is_whole(played):
    found, heard = run(played(packets=32))
    assert (found, heard) == ([], [])


def test_a_loss_is_bridged_and_reported_and_too_large_a_loss_not_classified(played):
    found, heard = run(played(packets=70, lost=range(12, 15)))
    assert found[0].lost == pytest.approx(30 / 330)
    assert np.isfinite(heard[0].samples).all()
    found, heard = run(played(packets=70, lost=range(10, 30)))
    assert found[0].classification is None
    assert found[0].facts()["material"] is None
    assert "not classified: 61 % of the window was lost" in line(found[0])


def test_a_window_with_all_samples_lost_is_no_signal():
    assert window_signal(np.full((3, 9), np.nan, np.float32), 330.0, "m/s^2", ("x", "y", "z")) == (None, 1.0)


def test_latency_is_from_the_last_sample_to_the_result(played):
    source = played(packets=200)
    now = [0.0]

    def clock():
        return max(now[0], 0.03 * (source.packet - 1))

    def listen(signal):
        now[0] = clock() + 0.012
        return Classification({"a": 1.0})

    found, _ = run(source, listen=listen, clock=clock)
    assert len(found) > 5
    np.testing.assert_allclose([guess.latency_s for guess in found], 0.012, atol=1e-9)
    latencies = Latencies()
    for guess in found:
        latencies.add(guess)
    assert latencies.facts() == pytest.approx(
        {"windows": len(found), "p50_ms": 12, "p99_ms": 12, "max_ms": 12}
    )


def test_a_classifier_that_is_too_slow_skips_windows_and_shows_nothing_old(played):
    source = played(packets=400)
    now = [0.0]

    def clock():
        return max(now[0], 0.03 * (source.packet - 1))

    def listen(signal):
        now[0] = clock() + 1.3  # a hop is 0.5 s
        return Classification({"a": 1.0})

    found, _ = run(source, listen=listen, clock=clock)
    assert max(guess.skipped for guess in found) >= 1
    # After a second and more of listening, what is judged next is not more than a hop old.
    assert all(guess.latency_s < 1.3 + 0.5 + 1e-9 for guess in found)


def test_a_log_has_no_latency_and_no_skipped_windows(played):
    found, _ = run(played(packets=200), clock=lambda: 1e6)
    assert [guess.latency_s for guess in found] == [None] * len(found)
    assert not any(guess.skipped for guess in found)
    assert Latencies().facts()["p50_ms"] is None


def test_classification_stops_after_the_given_seconds(played):
    found, _ = run(played(), seconds=3.0)
    assert found[-1].end_index <= 3.1 * 330


def test_a_source_of_unknown_rate_is_classified_once_its_rate_is_measured(played):
    source = played(rate=None, packets=100)
    facts = source.facts
    rate = {"hz": 331.67, "low": 331.5, "high": 331.8}
    source.facts = lambda: facts() | {"rate": rate if source.packet > 40 else None}
    found, heard = run(source)
    assert found[0].end_index == 410
    assert heard[0].rate == pytest.approx(331.7)


def test_windows_and_hops_of_zero_are_refused(played):
    with pytest.raises(ParameterError, match="hop"):
        run(played(), hop_s=0.0)

"""Packets on the timeline of a sensor: losses in their place, and no false samples."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram_capture.twelite.messages import Packet
from tactogram_capture.twelite.source import LONGEST_GAP, MOST_LOST, Timeline


def packet(sequence, arrival=float("nan"), *, mode="fifo", value=None):
    """Return a packet whose samples all equal its number."""
    samples = np.full((3, 10), sequence if value is None else value, np.float32)
    return Packet("81000001", sequence % 65536, mode, samples, "hex", arrival)


def line_of(packets):
    line = Timeline("81000001")
    pieces = [piece for one in packets for piece in line.add(one)]
    line.finish()
    index = 0
    for piece in pieces:
        assert piece.first_index == index
        index += piece.samples.shape[1]
    assert index == line.length
    return np.concatenate([piece.samples for piece in pieces], axis=1), line


def test_lost_packets_are_nan_in_their_place():
    samples, line = line_of([packet(n) for n in (5, 6, 9, 10)])

    assert samples.shape == (3, 60)
    assert np.isnan(samples[:, 20:40]).all()
    assert (samples[:, 40:50] == 9).all()
    assert (line.received, line.lost, line.lost_packets, line.restarts) == (40, 20, 2, 0)


def test_wrapped_numbers_are_no_gap():
    samples, line = line_of([packet(n) for n in range(65530, 65546)])

    assert np.isfinite(samples).all()
    assert line.lost_packets == 0


def test_a_loss_across_the_wrap_of_the_numbers_is_counted():
    samples, line = line_of([packet(n) for n in (65534, 65535, 65539)])

    assert line.lost_packets == 3
    assert np.isnan(samples[:, 20:50]).all()


def test_packets_of_two_relays_are_used_once_and_late_ones_not():
    samples, line = line_of([packet(n) for n in (1, 1, 2, 4, 3, 5, 5, 6)])

    assert (samples[0, ::10] == [1, 2, np.nan, 4, 5, 6])[[0, 1, 3, 4, 5]].all()
    assert dict(line.dropped) == {"duplicate": 2, "late": 1}


def test_one_stray_number_does_not_move_the_timeline():
    samples, line = line_of([packet(n) for n in (1, 2, 30000, 3, 4)])

    assert np.isfinite(samples).all()
    assert samples.shape == (3, 40)
    assert dict(line.dropped) == {"stray": 1}


def test_a_long_silence_has_as_many_losses_as_its_numbers_skip():
    before = [packet(n, n / 33) for n in range(100)]
    after = [packet(n, n / 33) for n in range(2100, 2110)]
    _, line = line_of(before + after)

    assert (line.lost_packets, line.restarts) == (2000, 0)


def test_a_restarted_sensor_leaves_a_gap_as_long_as_the_silence():
    before = [packet(n, n / 33) for n in range(1000, 1100)]
    after = [packet(n, 1100 / 33 + 5 + n / 33) for n in range(50)]
    samples, line = line_of(before + after)

    assert line.restarts == 1
    assert line.lost_packets == 0
    assert line.lost / 330 == pytest.approx(5, abs=0.1)
    assert samples.shape[1] == 1500 + line.lost


def test_a_restart_in_a_log_without_times_is_one_packet_long():
    _, line = line_of([packet(n) for n in [*range(40000, 40010), *range(5)]])

    assert (line.restarts, line.lost) == (1, 10)


def test_a_restart_at_lower_numbers_is_confirmed_by_five_packets():
    samples, line = line_of([packet(n) for n in [*range(50), *range(20)]])

    assert line.restarts == 1
    assert np.isfinite(samples).all(axis=0).sum() == 700


def test_a_jump_of_the_clock_does_not_fill_the_memory():
    before = [packet(n, n / 33) for n in range(100)]
    after = [packet(n, 1e9 + n / 33) for n in range(50000, 50010)]
    samples, _ = line_of(before + after)

    assert samples.shape[1] <= LONGEST_GAP + 1200


def test_packets_of_another_mode_have_another_unit_and_are_left_out():
    samples, line = line_of([packet(1), packet(2, mode="single"), packet(3)])

    assert line.dropped["another mode"] == 1
    assert np.isnan(samples[:, 10:20]).all()


def test_samples_missing_in_a_packet_are_counted_as_lost():
    broken = packet(2)
    broken.samples[:, 4:] = np.nan
    samples, line = line_of([packet(1), broken])

    assert (line.received, line.lost) == (14, 6)
    assert samples.shape == (3, 20)


@given(st.lists(st.integers(0, 65535), max_size=60))
def test_any_order_of_numbers_gives_each_packet_at_most_once_in_order(numbers):
    line = Timeline("81000001")
    pieces = []
    for number, sequence in enumerate(numbers):
        pieces += line.add(packet(sequence, number / 33, value=number))
    line.finish()
    used = [int(piece.samples[0, -1]) for piece in pieces]

    assert used == sorted(set(used))
    assert len(used) + sum(line.dropped.values()) == len(numbers)
    assert line.received == 10 * len(used)
    assert line.received + line.lost == line.length


@given(st.lists(st.integers(1, MOST_LOST), min_size=1, max_size=30))
def test_lost_and_received_samples_make_up_the_sent_ones(steps):
    numbers = [7, *(7 + np.cumsum(steps)).tolist()]
    samples, line = line_of([packet(n) for n in numbers])

    assert line.received == 10 * len(numbers)
    assert line.lost == 10 * (numbers[-1] - numbers[0] + 1 - len(numbers))
    for n in numbers:
        assert (samples[:, 10 * (n - 7) : 10 * (n - 6)] == n).all()

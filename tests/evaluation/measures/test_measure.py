import numpy as np
import pytest
from hypothesis import given, strategies as st

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import segments
from tactogram.evaluation.measures.measure import (
    CHUNK_SAMPLES,
    SignalSet,
    check_alike,
    once_per_set,
    stacks,
)
from tactogram.signal import Signal


def ramp(n, rate=100.0):
    return Signal(np.arange(n, dtype=np.float32), rate, "1")


def test_pieces_follow_each_other_and_the_rest_is_dropped():
    pieces = segments([ramp(250), ramp(90), ramp(110)], 1.0)
    assert [float(p.samples[0, 0]) for p in pieces] == [0, 100, 0]
    assert {len(p) for p in pieces} == {100}


@given(st.lists(st.integers(10, 400), min_size=1, max_size=6), st.integers(1, 12))
def test_count_pieces_without_repetition(lengths, count):
    signals = [ramp(n) for n in lengths]
    held = sum(n // 50 for n in lengths)
    if held < count:
        with pytest.raises(
            ParameterError, match=f"the signals must hold {count} pieces of 0.5 s, got {held}"
        ):
            segments(signals, 0.5, count=count)
    else:
        pieces = segments(signals, 0.5, count=count)
        assert len(pieces) == count
        every = [(n, k) for n, length in enumerate(lengths) for k in range(length // 50)]
        assert len(every) == len(segments(signals, 0.5))


def test_few_pieces_are_spread_over_all_recordings():
    signals = [Signal(np.full(100, k), 100, "1") for k in range(8)]
    assert [float(p.samples[0, 0]) for p in segments(signals, 1.0, count=4)] == [0, 2, 4, 6]


@pytest.mark.parametrize("seconds", [0, -1, np.nan, np.inf])
def test_an_invalid_length_is_refused(seconds):
    with pytest.raises(ParameterError, match="seconds must be > 0 and finite"):
        segments([ramp(100)], seconds)


def test_what_cannot_be_cut_is_refused():
    with pytest.raises(ParameterError, match="holds no sample"):
        segments([ramp(100)], 0.001)
    with pytest.raises(ParameterError, match="count must be >= 1"):
        segments([ramp(100)], 0.5, count=0)
    with pytest.raises(ParameterError, match="over time"):
        segments([Signal(np.ones(100), 10, "1", domain="displacement")], 0.5)


def test_sets_of_different_kinds_are_not_compared():
    with pytest.raises(ParameterError, match="got 2 kinds"):
        check_alike([ramp(10)], [ramp(10, rate=200)])
    with pytest.raises(ParameterError, match="at least one signal, got none"):
        check_alike([ramp(10)], [])
    with pytest.raises(ParameterError, match="at least 0.2 s, got 0.1 s"):
        check_alike([ramp(10)], shortest_s=0.2)


def test_every_signal_is_in_one_stack_and_none_is_too_large():
    signals = [Signal(np.full((3, n), n + k), 1000, "1") for n in (7, 200_000) for k in range(9)]
    found = list(stacks(signals))
    assert all(stack.size <= CHUNK_SAMPLES for stack in found)
    assert sorted(float(x[0, 0]) for stack in found for x in stack) == sorted(
        float(s.samples[0, 0]) for s in signals
    )


def test_a_set_is_measured_once_for_each_setting():
    asked = []

    @once_per_set
    def samples(signals, factor):
        asked.append(factor)
        return factor * sum(map(len, signals))

    held = SignalSet([ramp(100), ramp(50)])
    assert [samples(held, 1), samples(held, 2), samples(held, 1), samples(held, 2)] == [150, 300, 150, 300]
    assert [samples([*held], 1), samples([*held], 1)] == [150, 150]  # a list may change
    assert samples(SignalSet(held[:1]), 1) == 100
    assert asked == [1, 2, 1, 1, 1]

"""Patterns of on and off."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp
from tests.rendering.families.test_amplitude_stream import tone

from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.families.pattern import _on_off, runs
from tactogram.rendering.level import parse_level


@given(hnp.arrays(np.float64, st.integers(1, 200), elements=st.floats(0, 1)), st.integers(1, 5))
def test_on_and_off_last_long_enough(share, shortest):
    values = _on_off(share, shortest)
    assert set(values) <= {0.0, 1.0}
    assert not values[share == 0].any()
    timings, strengths = runs(values, 50)
    assert sum(timings) == pytest.approx(20 * len(share), abs=1)
    if (share > 0).all():
        first = 1 if strengths[0] == 0 else 0  # it may begin with less silence than that
        assert all(t >= 20 * shortest for t in timings[first:-1])
    assert all(a != b for a, b in pairwise(strengths))


@pytest.mark.parametrize("share", [0.1, 0.25, 0.5, 0.8, 1.0])
def test_the_share_of_time_on_is_the_strength(share):
    assert _on_off(np.full(2000, share), 2).mean() == pytest.approx(share, abs=0.01)


def test_phone_strengths_follow_the_envelope_and_timings_are_whole_ms():
    drive = fit(tone(1, swell=1), open_display("phone"), level=parse_level("peak=1"))
    facts = drive.report.facts
    assert facts["strength_correlation"] > 0.99
    assert max(facts["strengths"]) == 255
    assert sum(facts["timings_ms"]) == 1500
    np.testing.assert_array_equal(
        np.repeat(facts["strengths"], np.array(facts["timings_ms"]) // 20)[:-1], drive.signal.samples[0, :-1]
    )


@pytest.mark.parametrize(
    ("shortest_ms", "rate", "steps"), [(35, 50, 2), (45, 50, 3), (40, 50, 2), (35, 1000, 35)]
)
def test_a_motors_shortest_pulse_is_rounded_up_to_steps(shortest_ms, rate, steps):
    phone = open_display("phone-on-off", changes={"shortest_ms": shortest_ms, "rate": rate})
    values = fit(tone(1, swell=1), phone, level=parse_level("peak=0.4")).signal.samples[0]
    edges = np.flatnonzero(np.diff(values)) + 1
    assert len(edges) > 4
    assert np.diff(edges).min() == steps

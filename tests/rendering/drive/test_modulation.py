"""Pre-emphasis: flat to the reported bandwidth, within its cap."""

import numpy as np
import pytest
from benchmarks.experiments.simulated_transducer import simulate_envelope
from hypothesis import given, settings, strategies as st
from tests.rendering.families.test_ultrasonic import amplitude, tone

from tactogram.rendering.drive.modulation import (
    attained,
    pre_emphasis,
)
from tactogram.rendering.families.ultrasonic import Settings, modulated
from tactogram.signal import Signal
from tactogram_playback.transducer.circuit import Transducer


@settings(max_examples=25)
@given(q=st.floats(15, 800), cap=st.floats(6, 40), part=st.floats(0.05, 1))
def test_pre_emphasis_comes_back_flat_to_the_reported_bandwidth(q, cap, part):
    s = Settings(q=q, pre_emphasis=True, cap_db=cap, output="envelope")
    rate = 48_000
    flat, _ = attained(s.carrier_hz / (2 * q), cap_db=cap, highest_hz=1000)
    # A slow tone and one up to the reported bandwidth, both whole numbers of periods in 0.2 s.
    slow, fast = 10, max(15.0, 5 * np.floor(part * flat / 5))
    both = Signal(tone(slow).samples + 0.3 * tone(fast).samples, 8000, "m/s^2")
    drive, facts = modulated(both, s, rate=rate, fade_s=0)
    heard = simulate_envelope(Transducer(q=q), drive).samples[0][-round(0.3 * rate) : -round(0.1 * rate)]
    if fast <= facts["transducer"]["flat_to_hz"]:
        ratio = amplitude(heard, fast, rate) / amplitude(heard, slow, rate)
        assert 20 * np.log10(ratio / 0.3) == pytest.approx(0, abs=0.1)
        assert amplitude(heard, slow, rate) == pytest.approx(
            facts["carrier_v"] * facts["depth"] / facts["full_scale"], rel=5e-3
        )


def test_a_cap_bounds_what_is_raised_and_the_bandwidth_says_so():
    f = np.array([0, 10, 100, 1000.0])
    h = pre_emphasis(f, cutoff_hz=47, cap_db=20)
    np.testing.assert_allclose(np.abs(h), np.minimum(10, np.hypot(1, f / 47)))
    flat, half = attained(47, cap_db=20, highest_hz=1000)
    assert np.hypot(1, flat / 47) == pytest.approx(10)
    assert 10 / np.hypot(1, half / 47) == pytest.approx(np.sqrt(0.5))
    assert attained(470, cap_db=20, highest_hz=1000) == (1000, 1000)

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.crest_factor import (
    crest_factor,
    low_crest_phases,
    periodic_signal,
    random_phases,
    straight_to_display,
)

LENGTH = 2000


def spectrum(seed=0, bins=200):
    return np.abs(np.random.default_rng(seed).standard_normal(bins))


def low(amplitudes, seed=0, **options):
    phases = low_crest_phases(amplitudes, length=LENGTH, rng=np.random.default_rng(seed), **options)
    return periodic_signal(amplitudes, phases, length=LENGTH)


def at_random(amplitudes, seed):
    phases = random_phases(len(amplitudes), rng=np.random.default_rng(seed))
    return periodic_signal(amplitudes, phases, length=LENGTH)


def test_a_sinusoid_has_the_square_root_of_two():
    x = periodic_signal(np.array([0.0, 0.3]), np.zeros(2), length=400)
    assert crest_factor(x) == pytest.approx(np.sqrt(2))
    np.testing.assert_allclose(x, 0.3 * np.cos(2 * np.pi * 2 * np.arange(400) / 400), atol=1e-12)


@settings(deadline=None, max_examples=15)
@given(amplitudes=st.lists(st.floats(0, 5), min_size=1, max_size=60), seed=st.integers(0, 99))
def test_amplitudes_are_kept_exactly(amplitudes, seed):
    x = low(np.array(amplitudes), seed, swaps=20)
    got = np.abs(np.fft.rfft(x)) / (LENGTH / 2)
    np.testing.assert_allclose(got[1 : len(amplitudes) + 1], amplitudes, atol=1e-12)
    np.testing.assert_allclose(got[[0, *range(len(amplitudes) + 1, len(got))]], 0, atol=1e-12)


def test_crest_factor_is_below_that_of_random_phases():
    least = min(crest_factor(at_random(spectrum(), seed)) for seed in range(20))
    assert crest_factor(low(spectrum())) < 0.65 * least


def test_equal_lines_come_near_to_a_sinusoid():
    assert crest_factor(low(np.ones(200))) < 1.7


def test_a_loop_has_no_seam():
    x = low(spectrum())
    inner = np.abs(np.diff(x)).max()
    assert abs(x[0] - x[-1]) <= inner
    twice = np.abs(np.fft.rfft(np.tile(x, 2)))
    np.testing.assert_allclose(twice[1::2], 0, atol=1e-9)  # nothing between the harmonics of the loop


def test_same_seed_is_the_same_signal_and_another_is_not():
    np.testing.assert_array_equal(low(spectrum(), 1), low(spectrum(), 1))
    assert not np.allclose(low(spectrum(), 1), low(spectrum(), 2))


def test_silence_stays_silence():
    assert not low(np.zeros(5)).any()
    with pytest.raises(ParameterError, match="not 0"):
        crest_factor(np.zeros(5))


def test_harmonics_above_half_the_rate_are_refused():
    with pytest.raises(ParameterError, match="at most 49 of 100 samples, got 50"):
        periodic_signal(np.ones(50), np.zeros(50), length=100)


def sensor(seconds=2.5, rate=1000.0, level=1.0):
    samples = np.random.default_rng(0).standard_normal((4, round(seconds * rate)))
    return Signal(5 + level * samples, rate, "V", ("g1", "g2", "g3", "g4"))


def test_middle_second_of_the_first_axis_fills_the_scale():
    given = sensor()
    made = straight_to_display(given, rate=1000.0, axes=("drive",))
    middle = given.samples[0, 750:1750].astype(float)
    expected = middle - middle.mean()
    np.testing.assert_allclose(made.samples[0], expected / np.abs(expected).max(), atol=1e-6)
    assert (made.unit, made.axes, made.rate) == ("1", ("drive",), 1000.0)


def test_how_strong_it_was_is_lost():
    one, other = (straight_to_display(sensor(level=s), rate=1000.0, axes=("d",)) for s in (1.0, 0.01))
    np.testing.assert_allclose(one.samples, other.samples, atol=1e-3)


def test_comes_at_the_displays_rate_with_its_axes_at_full_scale():
    made = straight_to_display(sensor(), rate=4000.0, axes=("left", "right"))
    assert len(made) == 4000
    assert np.abs(made.samples).max() == pytest.approx(1.0)
    np.testing.assert_array_equal(made.samples[0], made.samples[1])


def test_a_constant_stays_silent_and_a_short_signal_is_refused():
    still = Signal(np.ones(1000), 1000.0, "V")
    assert not straight_to_display(still, rate=1000.0, axes=("d",)).samples.any()
    with pytest.raises(ParameterError, match="of 1 s needs as much of a sensor's, got 0.5 s"):
        straight_to_display(sensor(0.5), rate=1000.0, axes=("d",))

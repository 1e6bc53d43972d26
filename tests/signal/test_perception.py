import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import ParameterError, UnitError
from tactogram.signal import Signal
from tactogram.signal.perception import (
    detection_threshold,
    sensation_level_db,
    spqi_threshold_db,
    weighted,
)

T = np.arange(8000) / 4000


def at_threshold(frequency, unit, level=1.0):
    amplitude = level * detection_threshold(frequency, unit)
    return Signal(amplitude * np.sin(2 * np.pi * frequency * T + 0.4), 4000, unit)


def test_the_threshold_is_as_published_below_its_minimum():
    """Verrillo 1963: flat to 40 Hz, then -12 dB per octave to about 250 Hz."""
    db = 20 * np.log10(detection_threshold([10.0, 40.0, 80.0, 160.0, 250.0]) / 1e-7)
    assert db[0] == db[1]
    np.testing.assert_allclose(np.diff(db[1:4]), -12, atol=1e-9)
    assert db[4] == pytest.approx(0)


def test_the_most_sensitive_frequency_is_250_hz():
    f = np.arange(5, 1000.0)
    assert f[detection_threshold(f).argmin()] == 250


def test_acceleration_and_velocity_follow_from_displacement():
    w = 2 * np.pi * np.array([30.0, 100, 400])
    displacement, velocity, acceleration = (
        detection_threshold(w / (2 * np.pi), u) for u in ("m", "m/s", "m/s^2")
    )
    np.testing.assert_allclose(velocity, displacement * w)
    np.testing.assert_allclose(acceleration, displacement * w**2)


def test_the_codec_curve_has_its_published_points():
    np.testing.assert_allclose(
        spqi_threshold_db([39, 102, 203, 250, 352, 500, 781, 2000]),
        [-37, -60, -76, -77, -72, -53, 0, 0],
        atol=0.7,
    )


@given(st.floats(30, 900), st.sampled_from(["m", "m/s", "m/s^2"]), st.floats(-10, 40))
@settings(deadline=None, max_examples=40)
def test_a_sine_is_as_far_above_threshold_as_it_is(frequency, unit, level_db):
    x = at_threshold(frequency, unit, 10 ** (level_db / 20))
    assert sensation_level_db(x) == pytest.approx(level_db, abs=0.3)


def test_equally_felt_sines_weigh_the_same():
    for frequency in (50.0, 100.0, 250.0, 500.0):
        felt = weighted(at_threshold(frequency, "m/s^2")).samples[0, 1000:-1000]
        assert felt.std() * np.sqrt(2) == pytest.approx(1, abs=0.01)


def test_axes_add_their_power():
    x = at_threshold(100.0, "m/s^2")
    three = Signal(np.repeat(x.samples, 3, axis=0), 4000, "m/s^2")
    assert sensation_level_db(three) - sensation_level_db(x) == pytest.approx(10 * np.log10(3), abs=1e-4)


def test_gravity_is_not_felt_and_silence_is_silent():
    assert sensation_level_db(Signal(np.zeros(100), 1000, "m")) == -np.inf
    x = at_threshold(100.0, "m/s^2")
    assert sensation_level_db(x.with_samples(x.samples + np.float32(9.81))) == pytest.approx(
        sensation_level_db(x), abs=0.1
    )


def test_what_has_no_threshold_is_refused():
    with pytest.raises(UnitError, match="threshold is known in m, m/s, m/s\\^2, got N"):
        weighted(Signal(T, 4000, "N"))
    with pytest.raises(ParameterError, match="frequency must be > 0"):
        detection_threshold([0.0])
    with pytest.raises(ParameterError, match="frequency must be >= 0"):
        spqi_threshold_db([-1.0])
    with pytest.raises(ParameterError, match="low < high"):
        weighted(Signal(T, 4000, "m"), band=(0, 100))
    with pytest.raises(ParameterError, match="displacement"):
        weighted(Signal(T, 4000, "m", domain="displacement"))

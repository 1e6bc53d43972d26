import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.full_scale import straight_to_display


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

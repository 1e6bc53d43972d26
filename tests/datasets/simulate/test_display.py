import numpy as np
import pytest
from scipy.fft import rfft

from tactogram.datasets.simulate.studies import drives
from tactogram.datasets.simulate.touch import (
    CARRIER_HZ,
    HALF,
    HORN_FRICTION,
    LUBRICATED,
    QUALITY,
    display_touched,
)
from tactogram.errors import ParameterError
from tactogram.signal import Signal

T = np.arange(10_000) / 10_000


def drive(samples):
    return Signal(np.asarray(samples, np.float32), 10_000.0, "1", ("drive",))


def sine(hz, level=1.0):
    return drive(level * np.sin(2 * np.pi * hz * T))


def test_39_different_signals_of_full_scale_and_one_second():
    made = drives()
    assert [d.name for d in made] == [f"signal{n:02d}" for n in range(1, 40)]
    assert len({d.recording("ultrasonic").id for d in made}) == 39
    for d in made:
        x = d.signal.samples[0]
        assert (len(x), d.signal.rate, d.signal.unit, d.signal.axes) == (10_000, 10_000.0, "1", ("drive",))
        assert np.abs(x).max() == pytest.approx(d.level)
        assert abs(x.mean()) < 1e-6


def test_further_signals_continue_the_39():
    made = drives(120)
    assert [d.recording("ultrasonic").id for d in made[:39]] == [
        d.recording("ultrasonic").id for d in drives()
    ]
    assert len({d.recording("ultrasonic").id for d in made}) == 120
    assert all(0.05 <= d.level <= 1 for d in made[39:])
    assert [d.name for d in drives(20)] == [d.name for d in made[:20]]


def test_no_signal_has_a_seam():
    """The step from its end to its beginning is none that it does not take anyway."""
    for d in drives(120):
        x = d.signal.samples[0].astype(float)
        assert abs(x[0] - x[-1]) <= np.abs(np.diff(x)).max() + 1e-6, d.is_a


def test_a_signal_is_what_it_is_called():
    made = {d.is_a: np.abs(rfft(d.signal.samples[0])) for d in drives()}
    assert made["sine of 320 Hz"].argmax() == 320
    pulses = made["20 pulses of 2 ms a second"]
    assert pulses[20::20].sum() > 0.99 * pulses.sum()
    noise = made["noise of 100 to 400 Hz"]
    assert noise[100:401].min() > 100 * noise[402:].max()


def test_a_display_signal_is_a_recording_of_no_material():
    first = drives()[0].recording("ultrasonic")
    assert first.material is None
    assert first.labels["item"] == "signal01"
    assert first.simulated


def test_the_transducer_passes_the_envelope_up_to_its_corner():
    corner = CARRIER_HZ / (2 * QUALITY)
    assert corner == 141.0
    slow, at_corner = (display_touched(sine(hz, 0.02)).drag.std() for hz in (5, 141))
    assert at_corner / slow == pytest.approx(0.5**0.5, rel=0.02)


def test_vibration_takes_friction_away():
    """At half of the envelope, as a weak signal leaves it: mu = mu0 (1 - a e^2 / (e^2 + h^2))."""
    expected = HORN_FRICTION * (1 - LUBRICATED * 0.25 / (0.25 + HALF**2))
    assert display_touched(sine(200, 0.01)).friction == pytest.approx(expected, rel=1e-3)
    assert display_touched(sine(5, 1.0)).friction > 1.2 * expected


def test_a_display_has_no_relief():
    touched = display_touched(sine(20))
    assert (touched.relief_mm, touched.steepness) == (0.0, 0.0)


def test_what_is_beyond_full_scale_is_cut_off():
    over = 3 * np.sin(2 * np.pi * 50 * T)
    np.testing.assert_array_equal(
        display_touched(drive(over)).drag, display_touched(drive(np.clip(over, -1, 1))).drag
    )


@pytest.mark.parametrize(
    "wrong",
    [
        Signal(np.zeros((1, 10_000)), 10_000.0, "V", ("drive",)),
        Signal(np.zeros((2, 10_000)), 10_000.0, "1", ("a", "b")),
        Signal(np.zeros((1, 500)), 10_000.0, "1", ("drive",)),
    ],
)
def test_a_drive_that_no_display_takes_is_refused(wrong):
    with pytest.raises(ParameterError, match="drive"):
        display_touched(wrong)

"""Display signals of the simulated studies."""

import numpy as np
import pytest
from scipy.fft import rfft

from tactogram_simulate.materials import PLATES
from tactogram_simulate.studies import COUNT, IMAGE_SETS, PER_FAMILY, RATERS, drives
from tactogram_simulate.tactile_images import FAMILIES


def test_39_different_signals_of_full_scale_and_one_second():
    made = drives()
    assert [d.name for d in made] == [f"signal{n:02d}" for n in range(1, 40)]
    assert len({d.recording("ultrasonic").id for d in made}) == 39
    for d in made:
        x = d.signal.samples[0]
        assert (len(x), d.signal.rate, d.signal.unit, d.signal.axes) == (10_000, 10_000.0, "1", ("drive",))
        assert np.abs(x).max() == pytest.approx(d.level)
        assert abs(x.mean()) < 1e-6


def test_as_many_people_answer_as_in_the_papers():
    """2023, Sec. III: "384 instances", "1248 instances"; 2025, Sec. II-B: "37 participants", "320 images"."""
    assert (RATERS["ultrasonic"] * len(PLATES), RATERS["ultrasonic"] * COUNT) == (384, 1248)
    assert (RATERS["tactile_images"], PER_FAMILY * len(FAMILIES), IMAGE_SETS) == (37, 320, 4)


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

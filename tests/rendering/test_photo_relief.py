import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.photo_relief import photo_to_touch, slopes_of
from tactogram.signal import Image


def picture(row, scale=0.1, rows=40):
    """Return a photograph of grey columns, 0 to 1."""
    grey = np.round(255 * np.asarray(row))[None, :, None]
    return Image(np.broadcast_to(grey, (rows, len(row), 3)).astype(np.uint8), scale)


def test_ribs_become_a_tone_of_speed_over_period():
    ribs = picture(0.5 + 0.4 * np.sin(2 * np.pi * np.arange(1000) / 20))  # 2 mm each
    signal = photo_to_touch(ribs, speed_mm_s=120, rate=4000)
    assert signal.seconds == pytest.approx(100 / 120, abs=1e-3)
    assert (signal.unit, signal.domain) == ("1", "time")
    spectrum = np.abs(np.fft.rfft(signal.samples[0]))
    assert np.argmax(spectrum) / signal.seconds == pytest.approx(60, abs=1.2)


def test_a_step_up_pushes_once_and_the_light_of_the_scene_does_not():
    lit = np.linspace(0.2, 0.5, 1000)
    lit[600:] += 0.3
    slopes = slopes_of(picture(lit)).samples[0]
    assert np.argmax(slopes) in range(597, 603)
    assert slopes.max() == pytest.approx(1.0)
    assert np.abs(slopes[150:400]).max() < 0.02
    assert slopes[-400:].min() > -0.2  # bright to the right: up, not down


def test_the_middle_row_is_drawn():
    rows = np.full((81, 300, 3), 128, np.uint8)
    rows[:30, ::2] = 255  # stripes above what a tip at the middle touches
    rows[36:45, 150:] = 200
    slopes = slopes_of(Image(rows, 0.2)).samples[0]
    assert np.argmax(slopes) in (149, 150)
    assert np.abs(slopes[:120]).max() < 0.05


@pytest.mark.parametrize(
    ("photograph", "message"),
    [
        (picture(np.full(300, 0.5)), "no contrast to draw; crop it"),
        (picture(0.5 + 0.004 * np.sin(np.arange(300))), "no contrast to draw"),
        (picture([0.1, 0.9], scale=None), "scale is unknown; give the width"),
        (picture([0.5]), "no contrast"),
    ],
)
def test_what_cannot_be_drawn_is_refused(photograph, message):
    with pytest.raises(ParameterError, match=message):
        slopes_of(photograph)

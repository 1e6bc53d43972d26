"""Spectrograms on a common scale."""

import numpy as np
import pytest
from scipy.signal import get_window

from tactogram.errors import ParameterError
from tactogram.evaluation.generation.spectrogram_figures import spectrograms_figure
from tactogram.signal import Signal


def tone(frequency, gain=1.0, *, rate=1000.0, axes=3):
    t = np.arange(int(2 * rate)) / rate
    wave = gain * np.sin(2 * np.pi * frequency * t)
    return Signal(np.stack([9.81 + wave, wave / 2, wave / 4][:axes]), rate, "m/s^2")


def pictures(figure):
    return [place.images[0] for place in figure.axes if place.images]


def test_what_is_compared_shares_a_scale_and_gravity_does_not_set_it():
    drawn = pictures(
        spectrograms_figure({"tile": {"recorded": tone(100), "generated": tone(100, 0.5)}}, scale="0-1")
    )
    assert len(drawn) == 6
    loud, soft = (np.asarray(picture.get_array()).max() for picture in drawn[:2])
    assert (loud, soft) == pytest.approx((1.0, 0.5), rel=1e-3)
    assert [np.asarray(p.get_array()).max() for p in drawn[2::2]] == pytest.approx([1, 1])
    assert all(picture.get_clim() == (0, 1) for picture in drawn)


def test_a_picture_is_the_transform_of_the_paper():
    """Saga et al., Sec. III-B: "a Hamming window (N=256) was used, and the hop size was set to 128", from 0 to 1."""
    noise = np.random.default_rng(0).standard_normal((1, 2000))
    drawn = pictures(spectrograms_figure({"a": {"recorded": Signal(noise, 1000, "N")}}, scale="0-1"))[0]
    frames = np.lib.stride_tricks.sliding_window_view(noise[0] - noise.mean(), 256)[::128]
    magnitude = np.abs(np.fft.rfft(frames * get_window("hamming", 256))).T[3:]  # from 10 Hz on
    np.testing.assert_allclose(drawn.get_array(), magnitude / magnitude.max(), atol=1e-5)


def test_decibels_keep_the_level_of_everything():
    groups = {"a": {"recorded": tone(100)}, "b": {"recorded": tone(100, 0.1)}}
    drawn = pictures(spectrograms_figure(groups, scale="dB"))
    x_of_a, x_of_b, y_of_a = (np.asarray(drawn[k].get_array()).max() for k in (0, 1, 2))
    assert x_of_a - x_of_b == pytest.approx(20, abs=0.01)
    assert x_of_a - y_of_a == pytest.approx(20 * np.log10(2), abs=0.01)
    assert len({picture.get_clim() for picture in drawn}) == 1


@pytest.mark.parametrize("rate", [330.0, 1000.0, 10_000.0])
def test_a_tone_is_drawn_at_its_frequency(rate):
    picture = pictures(spectrograms_figure({"tile": {"recorded": tone(100, rate=rate, axes=1)}}))[0]
    left, right, bottom, top = picture.get_extent()
    values = np.asarray(picture.get_array())
    row = values.mean(axis=1).argmax()
    height = (top - bottom) / len(values)
    assert abs(bottom + (row + 0.5) * height - 100) < 0.51 * height
    assert height == pytest.approx(min(rate, 1000) / 256, rel=1e-3)
    assert top <= min(rate / 2, 1000) + height
    assert left == 0
    assert 1.5 < right <= 2.0


def test_what_does_not_fit_together_is_refused():
    with pytest.raises(ParameterError, match="at least one signal, got none"):
        spectrograms_figure({})
    with pytest.raises(ParameterError, match="got 2 kinds"):
        spectrograms_figure({"a": {"one": tone(50), "other": tone(50, axes=1)}})


@pytest.mark.parametrize(("scale", "lowest"), [("0-1", 0), ("dB", -240)])
def test_silence_is_drawn_as_the_lowest_level_on_a_scale_of_its_own(scale, lowest):
    silent = Signal(np.zeros((1, 600)), 1000, "N")
    picture = pictures(spectrograms_figure({"nothing": {"recorded": silent}}, scale=scale))[0]
    assert np.asarray(picture.get_array()) == pytest.approx(lowest)
    assert picture.get_clim() == {"0-1": (0, 1), "dB": (-60, 0)}[scale]

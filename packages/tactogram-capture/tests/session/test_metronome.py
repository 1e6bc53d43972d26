"""The metronome beats once per stroke, and does not drift."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_capture.session.metronome import Metronome, click_track, interval_s


@pytest.mark.parametrize(("speed", "seconds"), [(100, 0.8), (200, 0.4), (400, 0.2)])
def test_a_beat_lasts_as_long_as_a_stroke_of_80_mm(speed, seconds):
    assert interval_s(80.0, speed) == pytest.approx(seconds)


def onsets(signal):
    loud = np.abs(signal.axis("mono")) > 0.01
    starts = np.flatnonzero(loud & ~np.concatenate([[False], loud[:-1]]))
    return starts[np.concatenate([[True], np.diff(starts) > 0.05 * signal.rate])] / signal.rate


@pytest.mark.parametrize("speed", [100, 200, 400])
def test_beats_are_on_time_to_the_last_and_never_clip(speed):
    interval = interval_s(70.0, speed)
    track = click_track(interval, 30.0)
    beats = onsets(track)
    assert len(beats) == int(np.ceil(30.0 / interval))
    np.testing.assert_allclose(beats, interval * np.arange(len(beats)), atol=5e-3)
    assert np.abs(track.samples).max() <= 0.5
    assert track.seconds == 30.0


def pitch(samples, rate):
    spectrum = np.abs(np.fft.rfft(samples, 1 << 15))
    return float(np.argmax(spectrum)) * rate / (1 << 15)


def test_strokes_out_and_back_sound_different_and_one_way_ones_alike():
    both, one = click_track(0.4, 2.0), click_track(0.4, 2.0, back_and_forth=False)
    click = round(0.03 * both.rate)
    tones = [
        pitch(s.samples[0, round(0.4 * k * s.rate) :][:click], s.rate) for s in (both, one) for k in (0, 1)
    ]
    np.testing.assert_allclose(tones, [1200, 800, 1200, 1200], atol=10)


def test_invalid_beats_are_refused():
    with pytest.raises(ParameterError, match="interval"):
        click_track(0.0, 1.0)
    with pytest.raises(ParameterError, match="stroke"):
        interval_s(80.0, 0.0)


def test_a_loudspeaker_gets_the_whole_track():
    played, hushed = [], []
    metronome = Metronome(played.append, lambda: hushed.append(1))
    metronome.start(0.4, 2.0, back_and_forth=True)
    metronome.stop()
    assert played[0].seconds == 2.0
    assert hushed == [1]

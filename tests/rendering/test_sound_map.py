import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.sound_map import pitch_of, sound_to_touch
from tactogram.signal import Signal

RATE = 22_050
TIME = np.arange(2 * RATE) / RATE


def sound(samples):
    return Signal(np.asarray(samples, np.float32), RATE, "1")


def voice(hz, harmonics=5):
    """Return a harmonic sound whose second harmonic is stronger than its pitch."""
    phase = 2 * np.pi * np.cumsum(np.broadcast_to(hz, TIME.shape)) / RATE
    return 0.2 * sum(np.sin(k * phase) * (1.5 if k == 2 else 1 / k) for k in range(1, harmonics + 1))


def power_at(touch, hz):
    """Return the amplitude of a signal's part at a frequency."""
    t = np.arange(len(touch)) / touch.rate
    return 2 * abs(np.mean(touch.samples[0] * np.exp(-2j * np.pi * hz * t)))


def rms(signal):
    return float(np.sqrt(np.mean(signal.samples.astype(float) ** 2)))


def test_an_envelope_is_a_tone_of_250_hz_as_strong_as_the_sound():
    swell = np.sin(np.pi * TIME / 2) ** 2
    touch, facts = sound_to_touch(sound(0.6 * swell * np.sin(2 * np.pi * 3000 * TIME)), "envelope")
    found = envelope_of(touch)
    at = [0.5, 1.0, 1.5]
    assert np.interp(at, found.times, found.amplitude) == pytest.approx([0.3, 0.6, 0.3], abs=0.01)
    assert np.interp(at, found.times, found.frequency) == pytest.approx([250] * 3, abs=1)
    assert (touch.rate, touch.seconds, facts["touch_hz"]) == (8000, 2.0, [250, 250])


@pytest.mark.parametrize(
    ("hz", "octaves", "felt"), [(60, 0, 60), (220, 0, 220), (440, 0, 440), (880, 1, 440), (1760, 2, 440)]
)
def test_a_pitch_moves_down_by_whole_octaves(hz, octaves, felt):
    touch, facts = sound_to_touch(sound(voice(hz)), "pitch")
    assert (facts["octaves_down"], facts["voiced"]) == (octaves, pytest.approx(1, abs=0.06))
    found = envelope_of(touch)
    assert np.interp([0.5, 1.0, 1.5], found.times, found.frequency) == pytest.approx([felt] * 3, rel=0.01)
    assert rms(touch) == pytest.approx(rms(sound(voice(hz))), rel=0.03)


def test_intervals_remain_in_a_glide_over_an_octaves_border():
    touch, facts = sound_to_touch(sound(voice(np.linspace(300, 900, len(TIME)))), "pitch")
    found = envelope_of(touch)
    assert np.interp([0.5, 1, 1.5], found.times, found.frequency) == pytest.approx([225, 300, 375], rel=0.02)
    assert facts["octaves_down"] == 1


def test_a_pitch_that_would_fall_below_20_hz_is_moved_up():
    touch, facts = sound_to_touch(sound(np.where(TIME < 1, voice(60), voice(1760))), "pitch")
    found = envelope_of(touch)
    assert np.interp([0.5, 1.5], found.times, found.frequency) == pytest.approx([30, 440], rel=0.02)
    assert facts["octaves_down"] == 2


def test_a_pitch_holds_through_what_has_none():
    gap = np.where(
        (TIME > 0.8) & (TIME < 1.2), np.random.default_rng(0).standard_normal(len(TIME)) / 5, voice(300)
    )
    pitch = pitch_of(sound(gap))
    assert np.isnan(pitch[85:115]).mean() > 0.8
    assert pitch[20:70] == pytest.approx(np.full(50, 300), rel=0.003)
    _, facts = sound_to_touch(sound(gap), "pitch")
    assert 0.7 < facts["voiced"] < 0.85
    assert np.allclose(facts["touch_hz"], 300, rtol=0.2)


@pytest.mark.parametrize("silent", [np.zeros(RATE), np.random.default_rng(0).standard_normal(RATE)])
def test_a_sound_without_pitch_is_refused(silent):
    with pytest.raises(ParameterError, match="no pitch to follow; map it by envelope or bands"):
        sound_to_touch(sound(silent), "pitch")


def test_each_band_has_its_tone():
    parts = {100: 0.4, 500: 0.3, 2000: 0.2, 6000: 0.1}
    made = sound(sum(a * np.sin(2 * np.pi * hz * TIME) for hz, a in parts.items()))
    touch, facts = sound_to_touch(made, "bands")
    found = [power_at(touch, hz) for hz in (50, 100, 200, 400)]
    assert found == pytest.approx([0.4, 0.3, 0.2, 0.1], abs=0.01)
    assert facts == {"by": "bands", "touch_hz": [50, 400]}
    assert rms(touch) == pytest.approx(rms(made), rel=0.02)


def test_bands_above_half_the_rate_are_absent():
    low = Signal(np.sin(2 * np.pi * 300 * np.arange(3000) / 1500), 1500, "1")
    assert sound_to_touch(low, "bands")[1]["touch_hz"] == [50, 100]


def test_an_unknown_map_is_refused():
    with pytest.raises(ParameterError, match="map must be one of envelope, pitch, bands, got 'chroma'"):
        sound_to_touch(sound(voice(300)), "chroma")

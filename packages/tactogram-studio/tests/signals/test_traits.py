import io
import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from PIL import Image

from tactogram.signal import Signal
from tactogram.signal.perception import detection_threshold, sensation_level_db
from tactogram_studio.signals import traits as worked_out
from tactogram_studio.signals.pictures import spectrogram_png, spectrum_options
from tactogram_studio.signals.traits import (
    band_levels,
    envelope,
    peak_of,
    rms_of,
    scales_of,
    spectrogram_db,
    strongest_db,
    threshold_note,
    traits_of,
)

RATE = 2000.0


def sine(frequency, amplitude, *, seconds=2.0, unit="m/s^2", offset=0.0):
    t = np.arange(round(seconds * RATE)) / RATE
    return Signal(offset + amplitude * np.sin(2 * np.pi * frequency * t)[None], RATE, unit)


@given(st.integers(1, 3000), st.integers(1, 300), st.integers(0, 2**32 - 1))
def test_decimation_keeps_the_extremes_of_every_pixel(n, width, seed):
    samples = np.random.default_rng(seed).normal(size=n).astype(np.float32)

    place, value = envelope(samples, width)

    assert np.array_equal(samples[place], value)
    assert np.all(np.diff(place) > 0)
    assert value.max() == samples.max()
    assert value.min() == samples.min()
    assert len(place) <= max(n if n <= 2 * width else 0, 2 * width)


def test_a_single_sample_is_not_lost_in_a_minute():
    samples = np.zeros(600_000, np.float32)
    samples[123_457] = 3.0

    place, value = envelope(samples, 600)

    assert value[list(place).index(123_457)] == 3.0


def test_a_sine_stands_at_its_frequency_and_its_level():
    frequency, time, level = spectrogram_db(sine(250, 0.5, offset=9.8))

    middle = level[:, len(time) // 2]
    assert frequency[middle.argmax()] == pytest.approx(250)
    assert middle.max() == pytest.approx(20 * math.log10(0.5), abs=0.01)
    assert middle[0] < -60  # gravity is not drawn
    assert time[0] == 0
    assert time[-1] == pytest.approx(2.0, abs=0.04)


def test_the_spectrogram_is_of_all_axes_together():
    one = sine(250, 0.3)
    both = Signal(np.concatenate([one.samples, one.samples]), RATE, "m/s^2", ("x", "y"))

    _, _, level = spectrogram_db(both)

    assert level.max() == pytest.approx(spectrogram_db(one)[2].max() + 10 * math.log10(2), abs=1e-6)


def test_a_long_signal_is_transformed_in_pieces_to_the_same_levels(monkeypatch):
    noise = np.random.default_rng(0).normal(size=(2, 4000))
    signal = Signal(noise, RATE, "m/s^2", ("x", "y"))
    whole = spectrogram_db(signal)[2]
    monkeypatch.setattr(worked_out, "AT_ONCE", 500)

    np.testing.assert_array_equal(spectrogram_db(signal)[2], whole)


def test_a_shorter_signal_ends_where_it_ends_on_shared_scales():
    short, long = (traits_of(sine(250, 0.5, seconds=seconds)) for seconds in (1.0, 2.0))

    picture = Image.open(io.BytesIO(spectrogram_png(short, scales=scales_of([short, long]))))

    alpha = np.array(picture)[:, :, 3]
    assert picture.size == (640, 160)
    assert alpha[:, :320].min() == 255
    assert alpha[:, 321:].max() == 0


@pytest.mark.parametrize("frequency", [100.0, 251.0, 640.0])
def test_a_band_has_the_amplitude_of_the_sine_in_it(frequency):
    middle, amplitude = band_levels(sine(frequency, 0.2))

    assert amplitude.max() == pytest.approx(0.2, rel=0.01)
    assert middle[amplitude.argmax()] == pytest.approx(frequency, rel=0.13)


def test_bands_hold_all_the_power_of_a_noise():
    samples = np.random.default_rng(0).normal(size=20_000)
    signal = Signal(samples[None], RATE, "m/s^2")

    middle, amplitude = band_levels(signal)

    half = 10 ** (1 / 20)
    share = (middle[-1] * half - middle[0] / half) / (RATE / 2)
    assert (amplitude**2 / 2).sum() == pytest.approx(share * samples.var(), rel=0.05)


@pytest.mark.parametrize("unit", ["N", "V", "1"])
def test_no_threshold_is_drawn_where_none_is_known(unit):
    signal = sine(250, 0.5, unit=unit)

    assert [one["name"] for one in spectrum_options(traits_of(signal))["series"]] == ["level"]
    note, felt = threshold_note(signal)
    assert note.startswith("No detection threshold is known")
    assert felt
    assert threshold_note(sine(250, 0.0, unit=unit)) == ("The signal is silent: it cannot be felt.", False)


def test_over_displacement_nothing_is_said_of_the_threshold():
    signal = Signal(np.random.default_rng(0).normal(size=(1, 400)), 10.0, "m", domain="displacement")

    options = spectrum_options(traits_of(signal))

    assert [one["name"] for one in options["series"]] == ["level"]
    assert options["xAxis"]["name"] == "cycles per mm"
    assert "at a speed" in threshold_note(signal)[0]


def test_the_note_says_what_perception_says():
    weak, strong = sine(250, 1e-3), sine(250, 10.0)

    note, felt = threshold_note(strong)
    assert note.startswith(f"{sensation_level_db(strong):.0f} dB above")
    assert felt
    note, felt = threshold_note(weak)
    assert note.startswith(
        f"Cannot be felt: its strongest moment is {-sensation_level_db(weak):.0f} dB below"
    )
    assert not felt


def test_a_tap_is_felt_however_long_the_pause_after_it():
    tap = np.zeros(round(20 * RATE))
    tap[:60] = 0.8 * np.sin(2 * np.pi * 250 * np.arange(60) / RATE)
    signal = Signal(tap[None], RATE, "m/s^2")

    note, felt = threshold_note(signal)

    assert sensation_level_db(signal) < 0
    assert felt
    assert f"strongest moment is {strongest_db(signal):.0f} dB above" in note
    sine_db = sensation_level_db(sine(250, 0.8))
    assert strongest_db(signal) == pytest.approx(sine_db + 10 * math.log10(60 / 400), abs=5)  # 0.03 of 0.2 s


def test_what_is_slower_or_faster_than_people_feel_is_said_to_be():
    note, felt = threshold_note(sine(2, 3.0))

    assert not felt
    assert note.endswith("Most of the signal is outside of that range.")
    assert "20 to 1000 Hz" in note


def test_the_threshold_decides_what_may_not_be_felt():
    threshold = float(detection_threshold(250.0, "m/s^2"))

    assert threshold_note(sine(250, 1.1 * threshold))[1]
    assert threshold_note(sine(250, 0.5 * threshold))[0].startswith(
        "May not be felt: its strongest moment is 6 dB"
    )
    assert threshold_note(sine(250, 0.1 * threshold))[0].startswith(
        "Cannot be felt: its strongest moment is 20 dB"
    )


def test_spectrograms_share_a_scale_of_tens():
    quiet, loud = (traits_of(sine(250, amplitude)) for amplitude in (0.01, 0.5))

    assert scales_of([loud]).top_db == 0  # -6 dB
    assert scales_of([quiet]).top_db == -40
    assert scales_of([quiet, loud]).top_db == 0


def test_level_is_about_the_mean_and_of_all_axes():
    signal = Signal(
        np.stack([sine(50, 3.0).samples[0], 9.8 + sine(90, 4.0).samples[0]]), RATE, "m/s^2", ("x", "y")
    )

    assert rms_of(signal) == pytest.approx(math.sqrt(12.5), rel=1e-3)
    assert peak_of(signal) == pytest.approx(4.0, rel=1e-2)

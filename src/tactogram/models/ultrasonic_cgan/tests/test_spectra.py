import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.model import ItemRatings
from tactogram.models.ultrasonic_cgan import Config
from tactogram.models.ultrasonic_cgan.spectra import (
    FLOOR,
    display_spectra,
    felt_features,
    filled,
    sensor_side,
    sensor_spectra,
)
from tactogram.signal import Signal

RATE, WORDS = 500.0, ("rough", "sticky")


def test_a_measurement_gives_84_spectra_of_1000_bins():
    """Sec. III-B: of each of four gauges 21 windows, so that 12 plates of ten measurements give 10,080."""
    signal = Signal(
        np.random.default_rng(0).standard_normal((4, 25_000)), 10_000.0, "V", ("a", "b", "c", "d")
    )
    spectra = sensor_spectra(signal, Config())
    assert spectra.shape == (4, 21, 1000)


def test_spectra_are_those_of_a_plain_transform_of_the_middle_two_seconds(tiny, measurement):
    """Hatori & Takemura 2023, Sec. III-B: "standardized so that it had a mean of 0 and variance of 1"."""
    signal = measurement(1, 0, 0, 0).signal
    spectra = sensor_spectra(signal, tiny)
    x = signal.samples[2, 125:1125].astype(float)
    x = (x - x.mean()) / x.std()
    for window in (0, 7, 20):
        start = 25 * window  # 0.05 s
        naive = np.abs(np.fft.rfft(x[start : start + 500])) / 250
        np.testing.assert_allclose(spectra[2, window], naive[1:61], rtol=1e-4, atol=1e-6)


def test_level_and_offset_of_a_sensor_do_not_matter_and_those_of_a_display_signal_do(
    tiny, measurement, display
):
    signal = measurement(0, 0, 0, 0).signal
    np.testing.assert_allclose(
        sensor_spectra(signal.with_samples(0.01 * signal.samples + 5), tiny),
        sensor_spectra(signal, tiny),
        rtol=1e-2,
    )
    drive = display(9, 0, 0, level=0.02).signal
    assert display_spectra(drive, tiny)[0, 0, 9] == pytest.approx(0.02, rel=1e-5)


def test_windows_of_one_measurement_have_its_surface_and_its_raters(tiny, kind, data, rated):
    side = sensor_side(data()[:6], tiny, kind.materials)
    assert side.spectra.shape == (6 * 84, 60)
    np.testing.assert_array_equal(side.item, np.repeat([0, 0, 1, 1, 2, 2], 84))
    np.testing.assert_array_equal(side.place[:, 0], np.repeat(range(6), 84))
    np.testing.assert_allclose(side.table[2], rated(0.1, 0.9, 2).scores, rtol=1e-6)
    assert (side.raters == 4).all()


def test_gaps_of_raters_are_their_items_mean(kind):
    scores = np.array([[0.2, np.nan], [0.4, 0.6], [0.9, 0.8]])
    got, gaps = filled(ItemRatings(kind.words, ("a", "b", "c"), scores))
    assert gaps == 1
    np.testing.assert_allclose(got, [[0.2, 0.7], [0.4, 0.6], [0.9, 0.8]], rtol=1e-6)


@pytest.mark.parametrize(
    ("signal", "message"),
    [
        (Signal(np.ones((1, 1000)), RATE, "V"), "must vary"),
        (Signal(np.zeros((1, 400)), RATE, "V"), "must last 1 s or longer, got 0.8 s"),
        (Signal(np.ones((1, 400)), 100.0, "V"), "above 120; got 100"),
        (Signal(np.ones((1, 400)), 500.5, "V"), "whole number of Hz"),
        (Signal(np.ones((1, 4000)), RATE, "V", domain="displacement"), "over time"),
    ],
)
def test_sensor_signals_of_no_use_are_refused(tiny, signal, message):
    with pytest.raises(ParameterError, match=message):
        sensor_spectra(signal, tiny)


def test_a_line_is_felt_in_its_octave_and_noise_by_its_number_of_lines():
    line, noise = torch.zeros(1000), torch.ones(1000)
    line[99] = 1000**0.5  # of 100 Hz, as strong as the noise
    tone, rough = felt_features(torch.stack((line, noise)))
    silent = 10 * np.log10(FLOOR)
    expected = [
        *[silent] * 6,
        0.0,
        *[silent] * 3,
        0.0,
        0.0,
    ]  # octaves from 1, 2, ..., 64, ... Hz; whole; lines
    np.testing.assert_allclose(tone, expected, atol=0.02)
    shares = [1, 2, 4, 8, 16, 32, 64, 128, 256, 489]
    np.testing.assert_allclose(
        rough, [*10 * np.log10(np.divide(shares, 1000) + FLOOR), 10 * np.log10(1 + FLOOR), 30.0], atol=1e-3
    )


def test_what_is_below_zero_is_not_felt():
    torch.testing.assert_close(felt_features(-torch.ones(1, 1000)), felt_features(torch.zeros(1, 1000)))

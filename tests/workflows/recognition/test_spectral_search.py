"""Search by spectra alone: bands, levels, and the nearest recordings."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.workflows.recognition.spectral_search import RANGE_DB, band_centres, find_similar, spectrum


def test_bands_are_third_octaves_below_half_the_rate():
    bands = band_centres(4000.0, "time")
    assert (bands[0], bands[-1]) == pytest.approx((20.0, 20 * 10**1.6))  # the next is above 1000 Hz
    assert np.diff(np.log10(bands)) == pytest.approx(0.1)
    assert band_centres(500.0, "time")[-1] < 250
    over_mm = band_centres(40.0, "displacement")
    assert (over_mm[0], over_mm[-1] < 20) == (pytest.approx(0.2), True)


def test_a_sine_is_the_strongest_band_whatever_its_level():
    sine = np.sin(2 * np.pi * 200 * np.arange(8000) / 2000)[None]
    levels = spectrum(Signal(sine, 2000.0, "m/s^2"))
    assert band_centres(2000.0, "time")[levels.argmax()] == pytest.approx(200, rel=0.01)
    assert levels.mean() == pytest.approx(0, abs=1e-4)
    assert np.ptp(levels) == pytest.approx(RANGE_DB, abs=1e-3)
    np.testing.assert_allclose(spectrum(Signal(30 * sine, 2000.0, "m/s^2")), levels, atol=1e-3)
    assert not spectrum(Signal(np.ones((1, 8000)), 2000.0, "m/s^2")).any()


def test_the_nearest_are_of_the_same_material_and_spectra_are_kept(store, texture, tmp_path):
    found = find_similar(store, texture("tile", 999), count=3, cache=tmp_path)
    assert [each["material"] for each in found["nearest"]] == ["tile"] * 3
    assert found["materials"][0]["material"] == "tile"
    assert found["recordings"] == 40
    assert [each["distance"] for each in found["nearest"]] == sorted(
        each["distance"] for each in found["nearest"]
    )
    told = []
    first = found["nearest"][0]["id"]
    again = find_similar(
        store, texture("tile", 999), without=[first], cache=tmp_path, progress=lambda *each: told.append(each)
    )
    assert told == []
    assert again["recordings"] == 39
    assert first not in [each["id"] for each in again["nearest"]]


def test_what_cannot_be_compared_is_refused(store, texture):
    with pytest.raises(ParameterError, match="count must be at least 1, got 0"):
        find_similar(store, texture("tile", 1), count=0)
    friction = Signal(np.ones((1, 400)), 40.0, "1", ("mu",), "displacement")
    with pytest.raises(ParameterError, match="runs over time, the signal over displacement"):
        find_similar(store, friction)

"""Levels, equalisation and limits of linear displays."""

import numpy as np
import pytest
from scipy import fft

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.catalogue import display_of, open_display
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal
from tactogram.signal.filters import differentiate
from tactogram.signal.perception import sensation_level_db


def coil(**changes):
    values = {
        "name": "coil",
        "title": "a coil",
        "family": "linear",
        "rate": 4000,
        "channels": ["a"],
        "unit": "V",
        "limit": 100,
        "band": [20, 800],
        "response": {"kind": "resonator", "unit": "m/s^2", "gain": 4, "resonance_hz": 65, "q": 2},
    }
    return display_of(values | changes)


def texture(seconds=2.0, rate=2000, size=1.0, seed=0):
    """Return noise of 60 to 500 Hz that fades in and out, so that the fades remove nothing."""
    rng = np.random.default_rng(seed)
    n = round(seconds * rate)
    spectrum = np.fft.rfft(rng.normal(size=n))
    f = np.fft.rfftfreq(n, 1 / rate)
    spectrum[(f < 60) | (f > 500)] = 0
    x = np.fft.irfft(spectrum, n) * np.hanning(n)
    return Signal((size * x / x.std()).astype(np.float32), rate, "m/s^2")


def output(drive, display):
    """Return the output of a display, computed with a second of silence around it."""
    n = fft.next_fast_len(len(drive) + 2 * round(drive.rate))
    f = fft.rfftfreq(n, 1 / drive.rate)
    h = np.concatenate([[0], display.response.at(f[1:])])
    x = fft.irfft(fft.rfft(drive.samples.astype(np.float64), n, axis=1) * h, n, axis=1)[:, : len(drive)]
    return Signal(x, drive.rate, display.response.unit, drive.axes)


def test_a_physical_match_comes_out_as_the_signal():
    display, signal = coil(), texture()
    drive = fit(signal, display, level=parse_level("physical"))
    came = output(drive.signal, display).samples[0, ::2]
    error = came - signal.samples[0]
    assert np.std(error) < 0.01 * np.std(signal.samples)
    assert drive.report.facts["out_of_band_db"] < 1e-6


def test_a_displacement_comes_out_as_its_acceleration():
    display, still = coil(), texture(rate=4000)
    moved = still.with_samples(1e-6 * still.samples, unit="m")
    signal = differentiate(differentiate(moved))
    drive = fit(moved, display, level=parse_level("physical"))
    came = output(drive.signal, display)
    middle = slice(1000, -1000)
    error = came.samples[0, middle] - signal.samples[0, middle]
    assert np.std(error) < 0.02 * np.std(signal.samples)
    assert any("m converted to m/s^2" in line for line in drive.report.scaled)


@pytest.mark.parametrize("level", ["sensation", "sensation=12"])
def test_a_sensation_level_comes_out_as_asked(level):
    """The band ends below the signal's: the rest of the spectrum compensates."""
    display, signal = coil(band=[20, 150]), texture()
    drive = fit(signal, display, level=parse_level(level))
    wanted = 12 if "=" in level else sensation_level_db(signal)
    assert sensation_level_db(output(drive.signal, display)) == pytest.approx(wanted, abs=0.05)
    assert drive.report.facts["sensation_level_db"]["rendered"] == pytest.approx(wanted, abs=0.05)
    assert any("outside 20 to 150 Hz" in line for line in drive.report.unreachable)


def test_a_gain_of_three_is_three_times_the_physical_match():
    display, signal = coil(), texture()
    once, thrice = (
        fit(signal, display, level=parse_level(text)).signal.samples for text in ("physical", "gain=3")
    )
    np.testing.assert_allclose(thrice, 3 * once, atol=1e-5)


def test_a_peak_is_a_share_of_the_limit():
    drive = fit(texture(), coil(), level=parse_level("peak=0.25")).signal
    assert np.abs(drive.samples).max() == pytest.approx(25, rel=1e-3)


@pytest.mark.parametrize("end", [slice(0, 40), slice(-40, None)])
def test_a_peak_is_that_share_even_where_the_loudest_moment_is_in_a_fade(end):
    loud = texture().samples.copy()
    loud[0, end] += 30 * np.sin(2 * np.pi * 100 * np.arange(40) / 2000).astype(np.float32)
    drive = fit(Signal(loud, 2000, "m/s^2"), coil(), level=parse_level("peak=0.8"))
    assert np.abs(drive.signal.samples).max() == pytest.approx(80, rel=1e-5)
    assert drive.signal.samples[0, [0, -1]] == pytest.approx([0, 0], abs=1e-4)
    assert drive.report.clipped == []


def test_without_a_response_only_gain_and_peak_have_a_meaning():
    display = open_display("audio")
    with pytest.raises(UnitError, match="measure its response, or use gain=FACTOR"):
        fit(texture(), display, level=parse_level("physical"))
    drive = fit(texture(), display, level=parse_level("gain=0.1")).signal
    np.testing.assert_allclose(drive.samples[0, 960:-960:24], 0.1 * texture().samples[0, 40:-40], atol=2e-3)
    np.testing.assert_array_equal(drive.samples[0], drive.samples[1])


def test_a_friction_coefficient_has_no_level_of_acceleration():
    signal = texture().with_samples(texture().samples, unit="1")
    with pytest.raises(UnitError, match="same physical unit; the signal is in 1"):
        fit(signal, coil(), level=parse_level("sensation"))


def test_the_cap_limits_what_a_weak_frequency_is_raised_by():
    """At 20 Hz the coil's output is a tenth of that above: 20 dB more drive than the cap of 6 dB allows."""
    t = np.arange(8000) / 4000
    window = np.hanning(8000)
    weak = Signal(window * np.sin(2 * np.pi * 25 * t), 4000, "m/s^2")
    display = coil(linear={"cap_db": 6}, band=[10, 800])
    drive = fit(weak, display, level=parse_level("physical"))
    best = 1 / np.abs(display.response.at(np.geomspace(10, 800, 5000))).max()
    assert np.abs(drive.signal.samples).max() == pytest.approx(10 ** (6 / 20) * best, rel=0.02)
    low, high = drive.report.facts["capped_hz"]
    assert low < 25 < high
    assert any("the cap is 6 dB" in line for line in drive.report.unreachable)


def test_equalising_the_magnitude_leaves_the_phase():
    display = coil(linear={"equalise": "magnitude"})
    drive = fit(texture(), display, level=parse_level("physical"))
    came, wanted = output(drive.signal, display).samples[0, ::2], texture().samples[0]
    inside = slice(150, 900)  # 75 to 450 Hz
    got, want = np.fft.rfft(came)[inside], np.fft.rfft(wanted)[inside]
    np.testing.assert_allclose(np.abs(got), np.abs(want), atol=0.02 * np.abs(want).max())
    phase = np.angle(display.response.at(np.fft.rfftfreq(4000, 1 / 2000)[inside]))
    strong = np.abs(want) > 0.2 * np.abs(want).max()
    np.testing.assert_allclose(np.angle(got / want)[strong], phase[strong], atol=0.1)


def test_without_equalisation_one_gain_stands_for_all_frequencies():
    display = coil(linear={"equalise": "none"})
    drive = fit(texture(rate=4000), display, level=parse_level("physical")).signal
    factor = 1 / abs(display.response.at(250.0))
    np.testing.assert_allclose(
        drive.samples[0, 100:-100], factor * texture(rate=4000).samples[0, 100:-100], atol=5e-3
    )


def test_too_strong_a_signal_is_made_weaker_and_said_to_be():
    loud = fit(texture(size=200), coil(limit=5), level=parse_level("physical"))
    assert np.abs(loud.signal.samples).max() <= 5
    assert loud.report.facts["limiting"] < 0.2
    assert any("over the limit of 5 V" in line for line in loud.report.scaled)
    clipped = np.mean(np.abs(loud.signal.samples) > 4.99)
    assert clipped <= 0.0015


def test_it_may_clip_or_refuse_instead():
    loud = fit(texture(size=200), coil(limit=5, linear={"over": "clip"}), level=parse_level("physical"))
    assert loud.report.facts["limiting"] == 1
    assert any("% of the samples at 5 V" in line for line in loud.report.clipped)
    with pytest.raises(ParameterError, match="over the limit of 5 V"):
        fit(texture(size=200), coil(limit=5, linear={"over": "refuse"}), level=parse_level("physical"))


def test_per_axis_channels_take_the_axes_in_order():
    three = Signal(np.stack([texture(seed=s).samples[0] for s in range(3)]), 2000, "m/s^2")
    display = coil(channels=["a", "b"])
    drive = fit(three, display, level=parse_level("physical"), axes="channels")
    for row in range(2):
        alone = fit(three.select("xyz"[row]), coil(), level=parse_level("physical")).signal
        np.testing.assert_allclose(drive.signal.samples[row], alone.samples[0], atol=1e-4)
    assert any(line.startswith("axes z:") for line in drive.report.unreachable)
    with pytest.raises(ParameterError, match="has 4 channels, the signal 3 axes"):
        fit(three, coil(channels=list("abcd")), level=parse_level("physical"), axes="channels")


def test_the_octaves_tell_what_the_band_takes():
    drive = fit(texture(), coil(band=[20, 250]), level=parse_level("physical"))
    rows = {row["centre_hz"]: row for row in drive.report.facts["bands"]}
    assert rows[125.0]["rendered_db"] == pytest.approx(rows[125.0]["wanted_db"], abs=0.2)
    assert rows[500.0]["rendered_db"] < rows[500.0]["wanted_db"] - 30
    assert rows[125.0]["reachable"]
    assert not rows[500.0]["reachable"]

"""Displacement, gravity and fades in a fit."""

import numpy as np
import pytest
from tests.rendering.families.test_linear import coil, texture

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal


def test_a_signal_over_displacement_needs_a_speed():
    x = np.sin(2 * np.pi * 2 * np.arange(400) / 20)  # 2 per mm over 20 mm
    groove = Signal(x, 20, "m/s^2", domain="displacement")
    with pytest.raises(ParameterError, match="needs speed_mm_s"):
        fit(groove, coil(), level=parse_level("physical"))
    drive = fit(groove, coil(), level=parse_level("physical"), speed_mm_s=50.0).signal
    assert drive.seconds == pytest.approx(0.4)
    spectrum = np.abs(np.fft.rfft(drive.samples[0] * np.hanning(len(drive))))
    assert np.argmax(spectrum) / drive.seconds == pytest.approx(100, abs=2.5)
    with pytest.raises(ParameterError, match="takes no speed"):
        fit(texture(), coil(), level=parse_level("physical"), speed_mm_s=50.0)


def test_gravity_is_taken_out_and_said_to_be():
    signal = texture()
    heavy = signal.with_samples(signal.samples + 9.81)
    light, with_gravity = (fit(s, coil(dc=True), level=parse_level("gain=2")) for s in (signal, heavy))
    np.testing.assert_allclose(with_gravity.signal.samples, light.signal.samples, atol=1e-4)
    assert any("constant of up to 9.81 m/s^2" in line for line in with_gravity.report.scaled)
    assert not any("constant" in line for line in light.report.scaled)


def test_a_drive_that_a_fade_makes_smaller_says_so():
    x = np.zeros(2000)
    x[:8] = 1
    drive = fit(Signal(x, 2000, "1"), open_display("string-tablet"), level=parse_level("peak=1"))
    assert any("in a fade of 50 ms" in words for words in drive.report.scaled)


def test_a_display_may_be_named_and_another_argument_is_refused():
    named, opened = (fit(texture(), each, level="gain=2") for each in ("audio", open_display("audio")))
    np.testing.assert_array_equal(named.signal.samples, opened.signal.samples)
    with pytest.raises(ParameterError, match=r"^level must be a Level or its text, such as peak=0.5, got 5$"):
        fit(texture(), "audio", level=5)
    with pytest.raises(ParameterError, match=r"^name must be a path, got 5$"):
        fit(texture(), 5, level="gain=2")

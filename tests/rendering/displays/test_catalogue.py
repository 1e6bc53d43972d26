"""Every shipped display: level, limits, rest and report; changes by key, and unknown names."""

import functools
import json

import numpy as np
import pytest

from tactogram.errors import DataError, ParameterError, UnitError
from tactogram.rendering.displays.catalogue import FAMILIES, display_family, open_display, shipped
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal

DISPLAYS = sorted(shipped())
UNITS = ("m/s^2", "1", "N")
LEVELS = ("physical", "sensation", "sensation=25", "gain=0.01", "gain=50", "peak=1", "peak=0.1")


def noise(unit="m/s^2", *, seconds=0.5, axes=3, size=3.0, seed=0):
    rng = np.random.default_rng(seed)
    return Signal(size * rng.normal(size=(axes, round(1000 * seconds))).astype(np.float32) + 0.1, 1000, unit)


@functools.cache
def drives(name):
    """Return every drive of a display for noise: unit, level, drive."""
    display, found = open_display(name), []
    for unit in UNITS:
        for level in LEVELS:
            try:
                found.append((unit, level, fit(noise(unit), display, level=parse_level(level))))
            except (UnitError, ParameterError):
                continue
    return found


def fitted(signal, display, level):
    """Return the drive, or None if the family refuses."""
    try:
        return fit(signal, display, level=parse_level(level)).signal
    except (ParameterError, UnitError):
        return None


def test_every_family_has_a_display():
    assert {open_display(name).family for name in DISPLAYS} == set(FAMILIES.names())


@pytest.fixture(params=DISPLAYS)
def name(request):
    return request.param


def test_its_name_is_its_file_and_it_says_where_it_is_from(name):
    display = open_display(name)
    assert display.name == name
    assert display.title
    assert display.source


def test_some_level_can_be_asked_of_it(name):
    assert {level.partition("=")[0] for _, level, _ in drives(name)} >= {"gain", "peak"}


def test_no_sample_leaves_the_limits(name):
    display = open_display(name)
    for unit, level, drive in drives(name):
        samples = drive.signal.samples.astype(np.float64)
        assert samples.max() <= display.limit, (unit, level)
        assert samples.min() >= display.floor, (unit, level)


def test_rate_unit_channels_and_duration_are_right(name):
    display = open_display(name)
    for _, _, drive in drives(name):
        assert (drive.signal.rate, drive.signal.unit) == (display.rate, display.unit)
        assert drive.signal.axes == display.channels
        assert drive.signal.seconds == pytest.approx(0.5, abs=1.01 / display.rate)


def test_it_ends_at_rest(name):
    display = open_display(name)
    for _, _, drive in drives(name):
        np.testing.assert_allclose(drive.signal.samples[:, -1], display.rest, atol=1e-6 * display.limit)


def test_there_is_no_dc_where_it_is_forbidden(name):
    display = open_display(name)
    if display.dc:
        pytest.skip("a constant is allowed")
    for _, _, drive in drives(name):
        mean = drive.signal.samples.astype(np.float64).mean(axis=1)
        assert np.abs(mean).max() < 1e-6 * display.limit


def test_its_report_is_json_and_text_without_nan(name):
    for _, level, drive in drives(name):
        facts = drive.report.as_json()
        assert json.loads(json.dumps(facts, allow_nan=False)) == facts
        assert facts["level"]["asked"] == level
        text = drive.report.as_text()
        assert "nan" not in text.lower().split()
        assert "scaled: " in text


def test_the_same_in_gives_the_same_out(name):
    display = open_display(name)
    first, second = (fit(noise(), display, level=parse_level("peak=0.7")) for _ in range(2))
    np.testing.assert_array_equal(first.signal.samples, second.signal.samples)
    assert first.report == second.report


def test_silence_stays_silence_or_a_steady_rest(name):
    """A carrier or a pretension may remain, but must not vary after the fade."""
    display = open_display(name)
    silent = noise().with_samples(np.zeros((3, 500)))
    for level in ("peak=1", "gain=2"):
        drive = fitted(silent, display, level)
        if drive is None:
            continue
        fade = 2 * round(display.fade_ms / 1e3 * display.rate) + 1
        x = drive.samples[:, fade:-fade].astype(np.float64)
        blocks = x[:, : x.shape[1] // 5 * 5].reshape(len(x), 5, -1)
        loudness = np.sqrt(np.mean(blocks**2, axis=2))
        spread = np.ptp(loudness, axis=1).max()
        assert spread < 5e-3 * display.limit


def test_a_stronger_signal_at_a_gain_is_not_rendered_weaker(name):
    display = open_display(name)
    level = parse_level("gain=0.001")
    unit = "1" if display_family(display.family).renders == "friction" else "m/s^2"
    soft, loud = (fit(noise(unit, size=size), display, level=level).signal.samples for size in (1.0, 2.0))
    assert np.ptp(loud) >= np.ptp(soft)


@pytest.mark.parametrize("samples", [1, 2, 7])
def test_very_short_signals_pass(name, samples):
    display = open_display(name)
    signal = Signal(np.linspace(-1, 1, samples, dtype=np.float32)[None] + 0.1, 200.0, "m/s^2")
    drive = fitted(signal, display, "peak=0.5")
    assert drive is None or np.abs(drive.samples).max() <= max(display.limit, -display.floor)


def test_enormous_and_tiny_signals_stay_within_limits(name):
    display = open_display(name)
    for size in (1e12, 1e-12):
        drive = fitted(noise(size=size), display, "peak=1")
        assert drive is None or drive.samples.max() <= display.limit


def test_values_of_a_display_can_be_changed_by_dotted_key():
    display = open_display("voice-coil", changes={"limit": 2.5, "linear.cap_db": 10, "response.q": 5})
    assert (display.limit, display.settings.cap_db, display.response.q) == (2.5, 10, 5)
    with pytest.raises(ParameterError, match="limit is a value"):
        open_display("voice-coil", changes={"limit.x": 1})


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(ParameterError, match="audio.*voice-coil, or a TOML file, got 'nothing'"):
        open_display("nothing")
    with pytest.raises(DataError, match="nothing.toml"):
        open_display("nothing.toml")

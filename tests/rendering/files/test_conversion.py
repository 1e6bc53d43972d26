import json
import re
from dataclasses import asdict

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from hypothesis.extra.numpy import arrays

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.drive.level_scaling import without_constant
from tactogram.rendering.files import check_file, haptic_formats, read_haptic, to_one_axis, write_haptic
from tactogram.rendering.files.conversion import GRAVITY
from tactogram.rendering.files.documents import Notes, encoded
from tactogram.rendering.files.events import Events, Part, Transient
from tactogram.rendering.files.loss import loss_between
from tactogram.rendering.files.reading import decoded
from tactogram.signal import Signal

FORMATS = haptic_formats()
RATE = 2000
ENVELOPES = [name for name, kind in FORMATS.items() if kind.holds != "waveform"]


def effect(seconds=1.0, strength=0.9, unit="1"):
    t = np.arange(round(seconds * RATE)) / RATE
    x = strength * (0.5 - 0.5 * np.cos(2 * np.pi * 2 * t)) * np.sin(2 * np.pi * 150 * t)
    return Signal(x, RATE, unit)


def file_for(folder, format):
    return folder / f"x{FORMATS[format].suffix}"


@pytest.mark.parametrize("format", FORMATS)
def test_every_format_is_valid_and_read_back(tmp_path, format):
    path = file_for(tmp_path, format)
    found = write_haptic(path, effect(), format=format, metadata={"simulated": True})
    assert check_file(path) == {
        "file": str(path),
        "format": format,
        "valid": True,
        "problems": [],
        "warnings": [],
    }
    file = read_haptic(path)
    assert file.metadata == {"simulated": True}
    assert (file.signal.unit, file.facts["format"], file.facts["full_scale"]) == ("1", format, 1.0)
    assert found["bytes"] == path.stat().st_size
    least = 0.75 if format == "vibration" else 0.98
    assert found["loss"]["envelope_correlation"] > least
    assert abs(found["loss"]["level_db"]) < (6 if format == "vibration" else 0.3)
    assert found["loss"] == asdict(loss_between(effect(), file.signal))


@pytest.mark.parametrize("format", [f for f in FORMATS if f != "vibration"])
def test_level_and_unit_come_back(tmp_path, format):
    path = file_for(tmp_path, format)
    found = write_haptic(path, effect(strength=40.0, unit="m/s^2"), format=format)
    file = read_haptic(path)
    assert file.signal.unit == "m/s^2"
    assert found["full_scale"] == pytest.approx(40, rel=0.05)
    assert found["scaled_by"] == pytest.approx(1 / found["full_scale"])
    assert file.facts["full_scale"] == found["full_scale"]
    assert np.abs(file.signal.samples).max() == pytest.approx(40, rel=0.06)


def test_gravity_takes_no_part_of_full_scale(tmp_path):
    stroke = effect(strength=2.0, unit="m/s^2")
    held = stroke.with_samples(stroke.samples + 9.81)
    found = write_haptic(tmp_path / "x.hjif", held, format="hjif")
    assert found["constant"] == "a constant of up to 9.81 m/s^2 removed: gravity or an offset, no vibration"
    assert found["full_scale"] == pytest.approx(2.0, rel=0.01)
    assert read_haptic(tmp_path / "x.hjif").signal.samples == pytest.approx(stroke.samples, abs=1e-3)
    force = held.with_samples(held.samples, unit="N")
    assert write_haptic(tmp_path / "f.hjif", force, format="hjif")["full_scale"] > 11


@pytest.mark.parametrize("format", FORMATS)
def test_full_scale_is_kept_or_refused(tmp_path, format):
    path = file_for(tmp_path, format)
    found = write_haptic(path, effect(strength=2.0, unit="m/s^2"), format=format, full_scale=8.0)
    assert (found["full_scale"], found["scaled_by"]) == (8.0, 0.125)
    path.unlink()
    with pytest.raises(ParameterError, match="at least the peak of .* m/s.2, got 1; it would clip"):
        write_haptic(path, effect(strength=2.0, unit="m/s^2"), format=format, full_scale=1.0)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("wrong", [0, -1, np.nan, np.inf])
def test_a_full_scale_must_be_a_number_above_0(tmp_path, wrong):
    with pytest.raises(ParameterError, match="full_scale must be > 0"):
        write_haptic(tmp_path / "x.ahap", effect(), format="ahap", full_scale=wrong)


def test_a_signal_of_full_scale_is_not_scaled(tmp_path):
    assert write_haptic(tmp_path / "x.ahap", effect(strength=0.2), format="ahap")["full_scale"] == 1.0


def test_three_axes_become_one_by_dft321_and_two_by_their_mean(tmp_path):
    x = effect().samples[0]
    three = Signal(np.stack([x, 0 * x, x]), RATE, "m/s^2")
    two = Signal(np.stack([x, 0.8 * x]), RATE, "1", ("left", "right"))
    found = [write_haptic(tmp_path / "x.ahap", signal, format="ahap") for signal in (three, two)]
    assert [f["reduced_by"] for f in found] == ["DFT321 of x, y, z", "mean of left, right"]
    assert read_haptic(tmp_path / "x.ahap").signal.axes == ("mean",)
    chosen = write_haptic(tmp_path / "x.ahap", two, format="ahap", axis="left")
    assert chosen["reduced_by"] == "axis left of left, right"


@pytest.mark.parametrize(("right", "level"), [(0, 0.9), (-1, 0.9 * 2**0.5), (-0.5, 0.9 * 1.25**0.5)])
def test_channels_that_cancel_in_their_mean_keep_their_power(right, level, tmp_path):
    x = effect().samples[0]
    two = Signal(np.stack([x, right * x]), RATE, "1", ("left", "right"))
    found = write_haptic(tmp_path / "x.ahap", two, format="ahap")
    assert found["reduced_by"] == f"sum of the power of left, {'-' if right else ''}right"
    assert np.abs(read_haptic(tmp_path / "x.ahap").signal.samples).max() == pytest.approx(level, rel=0.03)
    if right == -1:
        with pytest.raises(
            ParameterError, match="mean of left, right is silent, since they cancel; choose one"
        ):
            write_haptic(tmp_path / "x.ahap", two, format="ahap", axis="mean")


def test_which_axis_is_checked():
    signal = Signal(np.ones((2, 9)), 10, "1", ("a", "b"))
    np.testing.assert_allclose(
        to_one_axis(Signal(np.stack([np.ones(9), 3 * np.ones(9)]), 10, "1", ("a", "b")))[0].samples, 2
    )
    with pytest.raises(ParameterError, match="must be one of a, b, dft321, mean, got 'c'"):
        to_one_axis(signal, "c")
    with pytest.raises(ParameterError, match="dft321 needs three axes, got 2"):
        to_one_axis(signal, "dft321")
    one = Signal(np.ones(9), 10, "1", ("a",))
    assert to_one_axis(one) == (one, None)


@pytest.mark.parametrize("format", ENVELOPES)
def test_displacement_is_refused_where_there_is_only_time(tmp_path, format):
    signal = Signal(np.ones(90), 40, "1", domain="displacement")
    with pytest.raises(ParameterError, match="at a speed first"):
        write_haptic(file_for(tmp_path, format), signal, format=format)
    assert list(tmp_path.iterdir()) == []


def test_a_carrier_of_an_envelope_is_stated(tmp_path):
    found = write_haptic(tmp_path / "x.ahap", effect(), format="ahap")
    assert found["carrier"] == {"carrier_hz": [65.0, 300.0], "carrier_from": "sharpness"}


def test_a_length_beyond_all_in_hjif_is_refused(tmp_path):
    path = file_for(tmp_path, "hjif")
    write_haptic(path, effect(0.1), format="hjif")
    text = path.read_text()
    path.write_text(re.sub(r'"sample_count":[1-9]\d*', f'"sample_count":{2**63 - 1}', text, count=1))
    assert path.read_text() != text
    with pytest.raises(DataError, match="more than 33554432 samples"):
        read_haptic(path)


def test_losses_are_those_of_known_differences():
    t = np.arange(RATE) / RATE
    one = Signal((1 + 0.5 * np.sin(2 * np.pi * 3 * t)) * np.sin(2 * np.pi * 150 * t), RATE, "1")
    half = loss_between(one, one.with_samples(0.5 * one.samples))
    assert half.envelope_correlation == pytest.approx(1)
    assert half.waveform_correlation == pytest.approx(1)
    assert half.envelope_error == pytest.approx(0.5)
    assert half.level_db == pytest.approx(-6.02, abs=0.01)
    assert half.snr_db == pytest.approx(6.02, abs=0.01)
    octave = Signal((1 + 0.5 * np.sin(2 * np.pi * 3 * t)) * np.sin(2 * np.pi * 300 * t), RATE, "1")
    assert loss_between(one, octave).frequency_octaves == pytest.approx(1, abs=0.02)
    silent = loss_between(one.with_samples(0 * one.samples), one)
    assert (silent.envelope_error, silent.waveform_correlation, silent.level_db) == (None, None, None)
    steady = Signal(np.sin(2 * np.pi * 150 * t), RATE, "1")
    assert loss_between(steady, steady).snr_db is None


@st.composite
def signals(draw):
    count, axes = draw(st.integers(1, 400)), draw(st.sampled_from([1, 1, 2, 3]))
    samples = draw(
        arrays(
            np.float32,
            (axes, count),
            elements=st.floats(-1e6, 1e6, width=32, allow_subnormal=False),
            fill=st.sampled_from([0.0, 1.0, -3.0]).map(np.float32),
        )
    )
    rate = draw(st.sampled_from([200.0, 333.3, 1000.0, 8000.0, 44100.0, 250_000.0]))
    unit = draw(st.sampled_from(["1", "m/s^2", "V"]))
    domain = draw(st.sampled_from(["time", "time", "time", "displacement"]))
    return Signal(samples, rate, unit, tuple("abc"[:axes]), domain)


@pytest.mark.parametrize("format", FORMATS)
@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(signal=signals())
def test_any_signal_makes_a_valid_file_or_a_clear_refusal(tmp_path, format, signal):
    path = file_for(tmp_path, format)
    path.unlink(missing_ok=True)
    try:
        found = write_haptic(path, signal, format=format)
    except ParameterError as error:
        refusal = str(error)
    else:
        refusal = None
    if refusal is not None:
        assert not path.exists()
        assert "\n" not in refusal
        return
    assert check_file(path)["valid"]
    back = read_haptic(path).signal
    assert back.unit == signal.unit
    assert np.isfinite(back.samples).all()
    if format == "hjif":
        tolerance = 2e-6 * found["full_scale"]
        if not found["resampled_to"]:
            expected = without_constant(signal, least=GRAVITY)[0].samples
            np.testing.assert_allclose(back.samples, expected, atol=tolerance, rtol=1e-6)
    elif format != "vibration":
        assert back.seconds <= signal.seconds + 0.04  # a last transient has its length
        if format not in ("ahap", "haps"):  # these have no length but that of their events
            assert back.seconds >= signal.seconds - 2e-3


@pytest.mark.parametrize("format", FORMATS)
def test_what_is_written_has_not_changed(tmp_path, golden, format):
    rate = 400
    t = np.arange(rate // 2) / rate
    x = np.where(t < 0.2, 0.6, 0.2) * np.sin(2 * np.pi * 90 * t)
    write_haptic(tmp_path / "x", Signal(x, rate, "1"), format=format, metadata={"simulated": True})
    made = json.loads((tmp_path / "x").read_text())
    if "date" in made:
        made["date"] = "2026-01-01"
    kept = json.loads(golden(f"burst-{format}.json", encoded(made).decode()))
    _compare(made, kept)
    notes = Notes()
    decoded(kept, FORMATS[format], notes)
    assert (notes.problems, notes.warnings) == ([], [])


def _compare(made, kept):
    if isinstance(made, dict):
        assert made.keys() == kept.keys()
        for key in made:
            _compare(made[key], kept[key])
    elif isinstance(made, list):
        assert len(made) == len(kept)
        for one, other in zip(made, kept, strict=True):
            _compare(one, other)
    elif isinstance(made, float):
        assert made == pytest.approx(kept, abs=2e-4)
    else:
        assert made == kept


@pytest.mark.real_data
def test_real_effects_go_through_every_format(real_data, tmp_path):
    from tactogram.signal.io import read_signal

    paths = sorted((real_data("vibviz") / "wav").glob("*.wav"), key=lambda path: path.stat().st_size)
    found = {}
    for path in paths[:2]:
        for format in FORMATS:
            file = file_for(tmp_path, format)
            found[path.stem, format] = write_haptic(file, read_signal(path, unit="1"), format=format)
            assert check_file(file, format=format)["valid"]
    for (_, format), result in found.items():
        loss = result["loss"]
        if format == "hjif":
            assert loss["waveform_correlation"] > 0.99
        elif format in ("ahap", "haptic", "android"):
            assert loss["envelope_error"] < 0.2
            assert abs(loss["level_db"]) < 1.0


def drawn(peak):
    part = Part.of([0.0, 0.2, 0.4], [0.0, peak, 0.0], 0.0, 120.0)
    return Events(0.4, (part,), (Transient(0.3, 0.5, 180.0),))


def test_drawn_events_are_written_point_by_point(tmp_path):
    write_haptic(tmp_path / "x.haptic", drawn(0.5), format="haptic")
    back = read_haptic(tmp_path / "x.haptic").events
    assert back.joined.times.tolist() == [0.0, 0.2, 0.3, 0.4]
    assert back.joined.amplitude == pytest.approx([0, 0.5, 0.25, 0], abs=1e-4)
    [tap] = back.transients
    assert (tap.time, tap.amplitude) == (0.3, pytest.approx(0.5, abs=1e-4))
    assert tap.frequency == pytest.approx(180, abs=0.1)


@pytest.mark.parametrize("format", ENVELOPES)
def test_drawn_events_above_full_scale_set_it(format, tmp_path):
    found = write_haptic(file_for(tmp_path, format), drawn(1.6), format=format)
    assert found["full_scale"] == pytest.approx(1.6)
    assert check_file(file_for(tmp_path, format))["valid"]

import base64
import io
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
import soundfile
import torch
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image as Pillow

from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import write_signal


def test_samples_are_copied_and_read_only():
    samples = np.zeros((3, 5), np.float32)
    signal = Signal(samples, 100, "m/s^2")
    samples[0, 0] = 7
    assert signal.samples[0, 0] == 0
    with pytest.raises(ValueError, match="read-only"):
        signal.samples[0, 0] = 1


def test_a_read_only_float32_array_is_not_copied():
    first = Signal(np.ones((1, 5), np.float32), 100, "N")
    assert Signal(first.samples, 100, "N").samples is first.samples


@given(arrays(np.float64, st.tuples(st.integers(1, 4), st.integers(1, 20)), elements=st.floats(-1e6, 1e6)))
def test_samples_are_kept_to_float32(samples):
    signal = Signal(samples, 10, "m", axes=tuple("abcd"[: len(samples)]))
    np.testing.assert_array_equal(signal.samples, samples.astype(np.float32))
    assert len(signal) == samples.shape[1]


def test_a_signal_is_an_array_of_its_samples():
    signal = Signal([[1, 2], [3, 4]], 10, "N", ("a", "b"))
    assert np.asarray(signal) is signal.samples
    assert np.asarray(signal, np.float64).tolist() == [[1, 2], [3, 4]]
    np.testing.assert_array_equal(np.sqrt(signal), np.sqrt(signal.samples))
    copy = np.array(signal)
    torch.from_numpy(copy)[0, 0] = 7  # without a warning, which is an error in tests
    assert copy[0, 0] == 7
    assert signal.samples[0, 0] == 1


def test_a_signal_says_what_it_is():
    assert repr(Signal(np.zeros((3, 50)), 100, "m/s^2")) == "<Signal: x, y, z in m/s^2, 0.5 s at 100 Hz>"
    friction = Signal(np.zeros(40), 20, "1", ("along",), domain="displacement")
    assert repr(friction) == "<Signal: along in 1, 2 mm at 20 per mm>"


def test_one_axis_may_be_flat():
    assert Signal([1, 2, 3], 10, "V").samples.shape == (1, 3)


@pytest.mark.parametrize(
    ("shape", "axes", "names"),
    [
        ((2000, 3), (), ("x", "y", "z")),
        ((2000, 1), (), ("z",)),
        ((2000, 2), ("left", "right"), ("left", "right")),
    ],
)
def test_an_array_with_the_axes_last_is_turned_where_only_that_fits(shape, axes, names):
    samples = np.random.default_rng(0).normal(size=shape)
    signal = Signal(samples, 1000, "m/s^2", axes)
    np.testing.assert_array_equal(signal.samples, samples.T.astype(np.float32))
    assert signal.axes == names


@pytest.mark.parametrize("shape", [(2, 3), (4, 3), (2000, 2), (2000, 5)])
def test_an_array_that_may_be_either_needs_names(shape):
    with pytest.raises(ParameterError, match=f"axes must be {shape[0]} different names"):
        Signal(np.zeros(shape), 1000, "m/s^2")


@pytest.mark.parametrize("samples", [[[1, 2], [3]], "abc", None, [1j], object()])
def test_what_is_no_array_of_numbers_is_one_line(samples):
    with pytest.raises(ParameterError, match="samples must be") as refused:
        Signal(samples, 1000, "N")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("value", "got"),
    [([0.0, 1.0], "list"), (np.zeros((3, 9)), "ndarray"), ("x.wav", "'x.wav'"), (None, "NoneType")],
)
def test_what_is_no_signal_is_refused_with_how_to_make_one(value, got, tmp_path):
    with pytest.raises(ParameterError, match=f"^signal must be a Signal, .* got {got}; ") as refused:
        write_signal(tmp_path / "x.wav", value)
    assert (refused.value.parameter, refused.value.expected) == ("signal", "be a Signal")
    assert refused.value.value is value
    assert not (tmp_path / "x.wav").exists()


def test_axes_have_names():
    signal = Signal([[1, 2], [3, 4], [5, 6]], 10, "m/s^2")
    assert signal.axes == ("x", "y", "z")
    np.testing.assert_array_equal(signal.select("z", "x").samples, [[5, 6], [1, 2]])
    with pytest.raises(ParameterError, match="axis must be one of x, y, z, got 'w'"):
        signal.axis("w")


def test_duration_and_path_length():
    assert Signal(np.zeros(50), 100, "N").seconds == 0.5
    friction = Signal(np.ones(50), 10, "1", domain="displacement")
    assert friction.length_mm == 5
    with pytest.raises(ParameterError, match="use length_mm"):
        _ = friction.seconds


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"samples": []}, "not empty"),
        ({"samples": [[[1.0]]]}, r"shape \(1, 1, 1\)"),
        ({"samples": ["a"]}, "real numbers"),
        ({"samples": [0, float("nan")]}, "got nan at axis 0, sample 1"),
        ({"samples": [1e300]}, "got inf at axis 0, sample 0"),
        ({"rate": 0}, "rate must be > 0 and finite, got 0"),
        ({"rate": float("inf")}, "rate must be > 0 and finite"),
        ({"unit": "g"}, "unit must be one of m/s"),
        ({"axes": ("x", "y")}, "axes must be 1 different names"),
        ({"domain": "space"}, "domain must be"),
    ],
)
def test_what_is_no_signal_is_refused(arguments, message):
    with pytest.raises(ParameterError, match=message):
        Signal(**({"samples": [0.0, 1.0], "rate": 10, "unit": "N"} | arguments))


def test_an_image_is_colour_bytes():
    image = Image(np.zeros((2, 3, 3), np.uint8), mm_per_pixel=0.1)
    assert not image.pixels.flags.writeable
    with pytest.raises(ParameterError, match="pixels must be uint8"):
        Image(np.zeros((2, 3)))
    with pytest.raises(ParameterError, match="mm_per_pixel must be > 0"):
        Image(np.zeros((2, 3, 3), np.uint8), mm_per_pixel=0)


TIME = np.arange(660) / 330.0
STROKE = Signal(np.stack([9.81 + 0 * TIME, np.sin(2 * np.pi * 50 * TIME), 0.1 * TIME]), 330.0, "m/s^2")
FRICTION = Signal(np.sin(np.arange(400) / 3), 20, "1", ("along",), domain="displacement")


def test_plot_returns_the_axes_of_a_figure_of_pyplot():
    with plt.rc_context({"backend": "agg"}):
        axes = STROKE.plot(title="a stroke", shown=1)
        assert axes.shape == (3, 2)
        assert axes[0, 0].figure is plt.gcf()
        np.testing.assert_array_equal(axes[1, 0].lines[0].get_ydata(), STROKE.axis("y")[:330])
        plt.close("all")


@pytest.mark.parametrize("signal", [STROKE, FRICTION], ids=["over time", "over displacement"])
def test_a_notebook_shows_facts_picture_and_player(signal):
    page = signal._repr_html_()
    assert "<p>&lt;Signal: " in page
    picture, sound = (base64.b64decode(data) for data in re.findall(r"base64,([^\"]+)", page))
    assert Pillow.open(io.BytesIO(picture)).format == "PNG"
    samples, rate = soundfile.read(io.BytesIO(sound))
    assert rate >= 3000  # browsers refuse slower files
    assert np.abs(samples).max() == pytest.approx(0.9, abs=0.001)


def test_a_long_signal_is_heard_for_ten_seconds():
    page = Signal(np.sin(np.arange(30_000)), 1000, "1")._repr_html_()
    samples, rate = soundfile.read(io.BytesIO(base64.b64decode(re.findall(r"base64,([^\"]+)", page)[1])))
    assert len(samples) == 10 * rate

"""What of a signal is drawn: values that are known beforehand."""

import io
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.colors import to_hex
from PIL import Image

from tactogram.signal import Signal
from tactogram.signal.perception import detection_threshold
from tactogram_studio.signals import pictures
from tactogram_studio.signals.pictures import spectrogram_png, spectrum_options, waveform_options
from tactogram_studio.signals.traits import (
    traits_of,
)

RATE = 2000.0


def sine(frequency, amplitude, *, seconds=2.0, unit="m/s^2", offset=0.0):
    t = np.arange(round(seconds * RATE)) / RATE
    return Signal(offset + amplitude * np.sin(2 * np.pi * frequency * t)[None], RATE, unit)


def test_each_axis_has_its_row_on_the_same_scale():
    signal = Signal(np.stack([sine(50, 0.3).samples[0], sine(50, 0.02).samples[0]]), RATE, "N", ("a", "b"))

    options = waveform_options(traits_of(signal))

    assert [axis["name"] for axis in options["yAxis"]] == ["a, N", "b, N"]
    assert {axis["max"] for axis in options["yAxis"]} == {0.5}
    assert max(options["dataset"][0]["source"]["v"]) == pytest.approx(0.3, rel=1e-3)


def test_the_brightest_row_of_the_picture_is_the_tones():
    picture = np.array(Image.open(io.BytesIO(spectrogram_png(traits_of(sine(250, 0.5))))).convert("L"), float)

    row = picture[:, 300].argmax()

    assert 1000 * (1 - (row + 0.5) / 160) == pytest.approx(250, abs=20)


def test_the_threshold_is_drawn_in_the_signals_unit():
    series = {
        one["name"]: one["data"] for one in spectrum_options(traits_of(sine(250, 0.5, unit="m")))["series"]
    }

    for frequency, value in series["detection threshold"]:
        assert value == pytest.approx(float(detection_threshold(frequency, "m")), rel=2e-3)
    assert max(v for _, v in series["level"]) == pytest.approx(0.5, rel=0.01)


def test_the_bar_has_the_colours_of_the_pictures():
    style = (Path(pictures.__file__).parents[1] / "static/signals.css").read_text()
    bar = re.findall(r"#[0-9a-f]{6}\b", style[style.index("linear-gradient(to right") :])

    assert bar == [to_hex(colormaps["magma"](share)) for share in np.linspace(0, 1, 11)]


@pytest.mark.parametrize("n", [1, 2, 3, 7])
def test_the_shortest_signals_can_be_drawn(n):
    signal = Signal(np.linspace(0, 1, n)[None], 1000.0, "m/s^2")

    assert waveform_options(traits_of(signal))["dataset"][0]["source"]["v"]
    assert spectrogram_png(traits_of(signal)).startswith(b"\x89PNG")
    assert spectrum_options(traits_of(signal))["yAxis"]["min"] > 0

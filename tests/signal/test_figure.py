"""A signal as a figure, and in a notebook."""

import io

import numpy as np
from PIL import Image as Pillow

from tactogram.signal import Signal
from tactogram.signal.figure import signal_figure

TIME = np.arange(660) / 330.0
STROKE = Signal(np.stack([9.81 + 0 * TIME, np.sin(2 * np.pi * 50 * TIME), 0.1 * TIME]), 330.0, "m/s^2")
FRICTION = Signal(np.sin(np.arange(400) / 3), 20, "1", ("along",), domain="displacement")


def test_the_shortest_signals_are_drawn():
    for signal in (STROKE.cut(0, 20), STROKE.cut(0, 1), FRICTION.cut(0, 3)):
        picture = io.BytesIO()
        signal_figure(signal).savefig(picture, format="png")
        assert Pillow.open(picture).width > 300


def test_a_spectrogram_contains_no_padding():
    steady = Signal(np.full((1, 2100), 9.81, np.float32), 1000.0, "m/s^2")
    trace, picture, *_ = signal_figure(steady, shown=1.0).axes
    levels = picture.collections[0].get_array()
    assert np.ptp(levels, axis=1).max() < 0.1  # dB: no frame holds zeros, which would be a step
    assert (trace.get_xlabel(), picture.get_xlim()) == ("time, s (the first 1 s)", (0.0, 2.1))


def test_a_signal_of_one_frame_has_a_spectrogram():
    _, picture, *_ = signal_figure(STROKE.cut(0, 100)).axes
    edges = picture.collections[0].get_coordinates()[0, :, 0]
    np.testing.assert_allclose(edges * STROKE.rate, [25, 75])  # as wide as its hop


def test_friction_is_drawn_over_position():
    trace, picture, *_ = signal_figure(FRICTION, shown=5).axes
    assert trace.get_xlabel() == "position, mm (the first 5 mm)"
    assert (picture.get_ylabel(), picture.get_xlim()) == ("1/mm", (0.0, 20.0))

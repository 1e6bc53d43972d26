import numpy as np
import pytest
import torch

from tactogram.errors import ParameterError
from tactogram.model import SignalKind
from tactogram.models.stroke_statistics import Config, build
from tactogram.signal import Signal
from tactogram.training.window_classifier import windows_at


def test_windows_are_those_that_begin_at_the_starts_some_at_a_time():
    signal = Signal(np.arange(20.0).reshape(2, 10), 10.0, "N", ("a", "b"))
    batches = list(windows_at(signal, 3, np.array([0, 4, 7]), at_once=2))
    assert [tuple(batch.shape) for batch in batches] == [(2, 2, 3), (1, 2, 3)]
    expected = [[[s, s + 1, s + 2], [s + 10, s + 11, s + 12]] for s in (0.0, 4.0, 7.0)]
    assert torch.equal(torch.cat(batches), torch.tensor(expected))


def test_a_classifier_needs_two_materials_and_whole_windows():
    with pytest.raises(ParameterError, match="at least 2 materials, got 1"):
        build(Config(), SignalKind(400.0, "N", ("x",), ("cork",)))
    classifier = build(Config(), SignalKind(400.0, "N", ("x",), ("cork", "tile")))
    short = Signal(np.ones((1, 20)), 400.0, "N", ("x",))
    with pytest.raises(ParameterError, match="signal must have at least 64 samples at 400 Hz, got 20"):
        classifier.regular_windows(short, 64, 32, at_once=8)


def test_candidates_have_the_probability_of_all_but_a_twentieth_of_the_recordings_left_out():
    classifier = build(Config(), SignalKind(400.0, "N", ("x",), ("cork", "felt", "tile")))
    classifier.left_out = np.linspace(0.05, 0.9, 18)
    assert classifier.candidates(np.array([0.2, 0.1, 0.7])) is None  # 19 are needed
    classifier.left_out = np.array([*np.linspace(0.3, 0.9, 18), 0.15])
    assert classifier.candidates(np.array([0.2, 0.1, 0.7])) == ("tile", "cork")
    classifier.left_out = np.full(40, 0.9)
    assert classifier.candidates(np.array([0.4, 0.6, 0.0])) == ("felt",)  # never none

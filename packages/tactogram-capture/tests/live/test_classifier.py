"""Classifier of windows: their preparation, and the threshold of none of these."""

import pytest

from tactogram.workflows.training.loaded_run import load_run
from tactogram_capture.live.classifier import LiveClassifier


def test_a_window_is_prepared_as_the_run_was_trained_and_other_rates_are_resampled(run, texture):
    loaded = load_run(run.folder)
    listener = LiveClassifier(loaded)
    signal = texture("tile", 5, seconds=listener.window_s)
    expected = loaded.model.probabilities(loaded.prepare(signal))
    assert list(listener(signal).probabilities.values()) == pytest.approx(expected.tolist())
    other = listener(texture("cork", 6, seconds=0.2, rate=500.0))
    assert sum(other.probabilities.values()) == pytest.approx(1)


def test_none_of_these_is_set_on_windows_as_long_as_those_that_are_heard(run, texture):
    listener = LiveClassifier(load_run(run.folder), window_s=0.5)
    assert listener.calibrated_on > 5
    loud = texture("tile", 7, seconds=0.5)
    odd = loud.with_samples(40 * (loud.samples - loud.samples.mean(axis=1, keepdims=True)))
    assert listener(odd).none_of_these
    assert sum(bool(listener(texture("tile", s, seconds=0.5)).none_of_these) for s in range(100, 120)) <= 6

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.evaluation.classification import ClassificationResult, evaluate_classifier
from tactogram.model import Example, Model
from tactogram.signal import Signal
from tactogram.statistics import pooled


class SampleClassifier(Model):
    """A classifier whose samples are the probabilities of class b, one per window."""

    materials = ("a", "b")
    step = None

    def __init__(self):
        pass

    def window_probabilities(self, signal):
        p = signal.samples[0].astype(float)
        return np.stack([1 - p, p], axis=1)

    def probabilities(self, signal):
        return pooled(self.window_probabilities(signal))


def example(material, *answers):
    return Example("i", Signal(list(answers), 1.0, "1"), material)


def test_windows_and_recordings_are_counted():
    result = evaluate_classifier(
        SampleClassifier(), [example("a", 0.1, 0.2, 0.9), example("b", 0.6, 0.4, 0.4), example("b", 0.9)]
    )
    np.testing.assert_array_equal(result.windows, [[2, 1], [2, 2]])
    np.testing.assert_array_equal(result.recordings, [[1, 0], [1, 1]])
    assert result.window_accuracy == pytest.approx(4 / 7)
    assert result.recording_accuracy == pytest.approx(2 / 3)
    figures = result.as_dict()
    assert figures["per_material"]["b"] == {
        "window_accuracy": 0.5,
        "recording_accuracy": 0.5,
        "recordings": 2,
    }
    assert figures["chance"] == 0.5


def test_a_classifier_without_windows_classifies_whole_recordings():
    class Whole(SampleClassifier):
        window_probabilities = Model.window_probabilities

        def probabilities(self, signal):
            return np.array([1 - signal.samples.mean(), signal.samples.mean()])

    result = evaluate_classifier(Whole(), [example("a", 0.1, 0.9, 0.9), example("b", 0.6, 0.4, 0.8)])
    np.testing.assert_array_equal(result.windows, [[0, 1], [0, 1]])
    np.testing.assert_array_equal(result.recordings, result.windows)


def test_the_share_of_recordings_whose_class_is_a_candidate_is_counted():
    class Doubtful(SampleClassifier):
        def candidates(self, probabilities):
            return ("b", "a") if probabilities[1] > 0.4 else ("a",)

    known = [example("a", 0.1), example("a", 0.45), example("b", 0.2), example("b", 0.8)]
    result = evaluate_classifier(Doubtful(), known)
    np.testing.assert_array_equal(result.candidates, [[2, 1], [2, 1]])
    assert result.candidate_facts == {"right_among": 0.75, "mean_number": 1.5}
    assert evaluate_classifier(SampleClassifier(), known).candidate_facts is None


def test_folds_add_up():
    one = evaluate_classifier(SampleClassifier(), [example("a", 0.1)])
    two = evaluate_classifier(SampleClassifier(), [example("b", 0.1)])
    np.testing.assert_array_equal((one + two).recordings, [[1, 0], [1, 0]])
    with pytest.raises(ParameterError, match="different classes"):
        _ = one + ClassificationResult(("a", "c"), one.windows, one.recordings, one.candidates)


def test_the_interval_is_wilsons():
    counts = np.array([[5, 5], [0, 0]])
    low, high = ClassificationResult(("a", "b"), counts, counts, counts).recording_interval
    # Wilson half-width at 5 of 10 is 0.263.
    assert (high - low) / 2 == pytest.approx(0.263, abs=0.001)
    assert (high + low) / 2 == pytest.approx(0.5)


def test_an_unknown_class_is_refused():
    with pytest.raises(ParameterError, match="recording i is of 'z', which the classifier does not know"):
        evaluate_classifier(SampleClassifier(), [example("z", 0.1)])

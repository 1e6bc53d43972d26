"""Materials that a text describes, by similarities written out here."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.features import text_classifier
from tactogram.features.text_classifier import describe, plain

ANGLES = {
    "silk": 0.1,
    "velvet": 0.0,
    "tweed": 0.5,
    "granite": 1.5,
    "glass": 1.2,
    "window pane": 0.0,
    "?": 3.0,
}


@pytest.fixture(autouse=True)
def _embeddings(monkeypatch):
    """Unit vectors in the plane: a text is as similar as the cosine of its angle from angle 0."""

    def embedded(texts):
        angles = np.array([ANGLES.get(plain(text), 0.0) for text in texts])
        return np.stack([np.cos(angles), np.sin(angles)], axis=1).astype(np.float32)

    monkeypatch.setattr(text_classifier, "embedded", embedded)


def test_names_are_written_with_spaces():
    assert plain("Window_pane-of  GLASS") == "window pane of glass"


def test_weights_are_a_softmax_of_cosines_and_small_ones_are_left_out():
    found = describe("something smooth", ["granite", "silk", "tweed", "velvet"], synonyms={})
    gap = np.exp(20 * (np.cos(0.1) - 1))
    assert list(found) == [
        "velvet",
        "silk",
    ]  # of tweed exp(20 (cos 0.5 - 1)), 0.09 of the greatest, is too little
    assert found["velvet"] == pytest.approx(1 / (1 + gap), abs=1e-4)
    assert sum(found.values()) == pytest.approx(1, abs=1e-4)


def test_a_synonym_counts_for_its_material():
    assert describe("a pane", ["glass", "granite"], synonyms={"glass": ["window pane"]}) == {"glass": 1.0}


def test_a_text_like_no_material_is_refused_with_the_nearest():
    with pytest.raises(ParameterError, match="'x' is like none of the 1; the nearest are granite"):
        describe("x", ["granite"], synonyms={})

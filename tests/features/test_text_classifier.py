"""Words of a text, the names that they mention, and mixes by similarities written out here."""

import numpy as np
import pytest

from tactogram.features import text_classifier
from tactogram.features.text_classifier import content_words, mentioned, mixed, plain, stem

ANGLES = {"silk": 0.1, "velvet": 0.0, "tweed": 0.5, "granite": 1.5, "glass": 1.2, "window pane": 0.0}


@pytest.fixture(autouse=True)
def _embeddings(monkeypatch):
    """Unit vectors in the plane: a text is as similar as the cosine of its angle from angle 0."""

    def embedded(texts):
        angles = np.array([ANGLES.get(plain(text), 0.0) for text in texts])
        return np.stack([np.cos(angles), np.sin(angles)], axis=1).astype(np.float32)

    monkeypatch.setattr(text_classifier, "embedded", embedded)


def test_names_are_written_with_spaces():
    assert plain("Window_pane-of  GLASS") == "window pane of glass"


def test_words_are_in_phrases_without_those_that_name_nothing():
    assert content_words("The feel of a Wet, old sand-paper on my tiles", ["sandpaper"]) == [
        ["wet", "old", "sandpaper"],
        ["tiles"],
    ]
    assert content_words("the", []) == []


def test_a_plural_has_the_stem_of_its_singular():
    assert [stem(word) for word in ("tiles", "tile", "glass", "gas")] == ["tile", "tile", "glass", "gas"]


def test_a_mention_by_all_words_counts_before_one_by_the_last():
    names = {name: (name,) for name in ("wool", "steel wool", "grained leather", "oak")}
    assert mentioned(["steel", "wool"], names, heads=True) == {"steel wool": {"steel", "wool"}}
    assert mentioned(["leather", "gloves"], names, heads=True) == {"grained leather": {"leather"}}
    assert mentioned(["leather", "gloves"], names) == {}
    assert mentioned(["leather", "oak"], names, heads=True) == {"oak": {"oak"}}
    assert mentioned(["sandpaper"], {"a": ("sand_paper",)}) == {"a": {"sandpaper"}}


def test_weights_are_a_softmax_of_cosines_and_small_ones_are_left_out():
    fabrics = dict.fromkeys(["granite", "silk", "tweed", "velvet"], "something smooth")
    weights = mixed(fabrics, synonyms={})
    gap = np.exp(20 * (np.cos(0.1) - 1))
    assert list(weights) == [
        "velvet",
        "silk",
    ]  # of tweed exp(20 (cos 0.5 - 1)), 0.09 of the greatest, is too little
    assert weights["velvet"] == pytest.approx(1 / (1 + gap), abs=1e-4)
    assert sum(weights.values()) == pytest.approx(1, abs=1e-4)


def test_a_synonym_counts_for_its_material():
    said = dict.fromkeys(["glass", "granite"], "a pane")
    assert mixed(said, synonyms={"glass": ["window pane"]}) == {"glass": 1.0}


def test_a_single_material_needs_no_embedding(monkeypatch):
    monkeypatch.setattr(text_classifier, "embedded", None)
    assert mixed({"granite": "granite"}, synonyms={}) == {"granite": 1.0}

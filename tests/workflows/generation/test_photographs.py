"""What is said of a photograph or a text that describes a surface."""

import pytest

from tactogram.workflows.generation.photographs import description_text

PREDICTION = {
    "given": ["image", "text"],
    "materials": 84,
    "explained": 0.4,
    "explained_range": (0.25, 0.5),
    "mean": False,
    "error_db": 3.21,
}


@pytest.mark.parametrize(
    ("facts", "says"),
    [
        ({"material": {"cork": 1.0}, "classified_as": "cork"}, "photograph classified as cork"),
        (
            {"classified_as": "cork", "confidence": 0.914, "novelty": 0.2},
            "photograph classified as cork, confidence 0.91",
        ),
        (
            {"text": "a rug", "material": {"felt": 0.75, "cork": 0.25}, "classified_as": "felt"},
            "described: felt 0.75, cork 0.25; photograph classified as felt",
        ),
        (
            {"prediction": PREDICTION},
            "predicted from the photograph and text, which explains 40 % (25 to 50) of the variance of this run's 84 "
            "materials, each left out; standard deviation 3.2 dB",
        ),
        (
            {"prediction": PREDICTION | {"mean": True}},
            "the mean of all materials was generated, as the photograph and text may tell nothing: it explains 40 % "
            "(25 to 50) of the variance of this run's 84 materials, each left out",
        ),
    ],
)
def test_a_description_is_a_sentence(facts, says):
    assert description_text(facts) == says


def test_a_confident_classification_is_no_prediction():
    facts = {"classified_as": "cork", "confidence": 0.9, "prediction": PREDICTION}
    assert description_text(facts) == "photograph classified as cork, confidence 0.90"
    assert description_text(facts | {"confidence": 0.1}).startswith("predicted from the photograph")


def test_a_photograph_unlike_the_others_is_said_to_be():
    text = description_text({"nearest_photograph": "tile", "novelty": 1.0})
    assert text.startswith("photograph unlike anything the run was trained on")
    assert "than 100 % of these are from one of another material; the nearest shows tile" in text

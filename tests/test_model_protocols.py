"""What is asked of a model is declared in `tactogram.model`: no attribute is looked for by its name."""

import ast
from pathlib import Path

import pytest
from pydantic import BaseModel

from tactogram import model as protocols, models
from tactogram.model import SignalKind, window_of
from tactogram.recipe import Recipe
from tactogram_capture.source import PlanFollower
from tactogram_capture.sources.played import StoreReplaySource

ROOM = Path(protocols.__file__).parent
ASKED = (
    "model",
    "learner",
    "generator",
    "classifier",
    "predictor",
    "embedder",
    "config",
    "source",
    "judge",
    "loaded",
)
"""Names of variables and attributes that hold a model, or a source."""
KEPT = {
    "CheckpointSelector": {"pix2pix", "pix2pixhd", "residue_fusion_gan", "stroke_cnn", "visual_tactile_gan"},
    "OutcomeReporter": {"stroke_cnn", "ultrasonic_cgan"},
    "FigureReporter": {"ultrasonic_cgan"},
    "WindowClassifier": {"stroke_cnn"},
    "Embedder": {"stroke_cnn"},
    "NoiselessGenerator": {"pix2pixhd", "residue_fusion_gan", "visual_tactile_gan"},
    "PhotographClassifier": {"nearest_photo", "residue_fusion_gan", "texture_flow", "visual_tactile_gan"},
    "DescriptionPredictor": {"texture_flow"},
    "PictureGenerator": {"pix2pix", "pix2pixhd", "residue_fusion_gan", "visual_tactile_gan"},
    "PublishedEvaluator": {"frictgan"},
    "SelectionReporter": {"ultrasonic_cgan"},
    "SpreadReporter": {"tactile_image_cgan", "texture_flow"},
    "TextureMapModel": {"ar_texture", "texture_var"},
    "LimitReporter": {"ar_texture", "replay", "texture_flow", "texture_gan", "texture_var"},
    "MotionPredictor": {"texture_flow"},
    "NoveltyReporter": {"rater"},
    "FeatureReporter": {"rater"},
}


def probes(text):
    """Return the lines that look for an attribute of a model by its name."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name)):
            continue
        if node.func.id in ("hasattr", "getattr") and ast.unparse(node.args[0]).split(".")[-1] in ASKED:
            found.append(ast.unparse(node))
    return found


@pytest.mark.parametrize("room", ["workflows", "studio", "experiments", "evaluation", "training"])
def test_no_attribute_of_a_model_is_looked_for_by_its_name(room):
    found = {
        path.name: lines for path in (ROOM / room).rglob("*.py") if (lines := probes(path.read_text("utf-8")))
    }
    assert not found


def test_a_probe_is_found():
    text = "hasattr(loaded.model, 'ends')\ngetattr(learner, 'watch', None)\ngetattr(status, 'x', 1)"
    assert probes(text) == ["hasattr(loaded.model, 'ends')", "getattr(learner, 'watch', None)"]


def built(facts):
    """Return an untrained model of the recipe tiny, of signals; None where it is of images."""
    recipe = Recipe.load(facts.recipe("tiny"))
    axes = ("x", "y", "z") if recipe.prepare.axes == "all" else tuple(recipe.prepare.axes)
    rated = {} if facts.learns_from == "recordings" else {"words": ("rough",), "scale": (1.0, 7.0)}
    kind = SignalKind(1000.0, "m/s^2", axes, ("cork", "tile"), **rated)
    if facts.gives == "image":
        kind = protocols.ImageKind(("rough",), (1.0, 7.0), ("i",))
    return facts.build(facts.config(recipe.config), kind, seed=0)


def test_each_optional_protocol_is_kept_by_the_models_that_offer_it():
    found = {name: set() for name in KEPT}
    for facts in (face for model in models.available().values() for face in model.faces):
        learner = built(facts)
        for name, kept_by in found.items():
            if isinstance(learner, getattr(protocols, name)):
                kept_by.add(facts.name)
    assert found == KEPT


def test_the_window_is_that_of_the_configuration():
    class Plain(BaseModel):
        pass

    class Windowed(BaseModel):
        window: int = 96

    assert window_of(Windowed()) == 96
    assert window_of(Plain()) == 0


def test_a_simulated_source_follows_a_plan():
    assert issubclass(StoreReplaySource, PlanFollower)

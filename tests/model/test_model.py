"""The base class of all models: its defaults, and that no attribute of a model is looked for by its name."""

import ast
from pathlib import Path

import pytest

from tactogram import model as interface, models
from tactogram.errors import ParameterError
from tactogram.model import Model, ModelConfig, SignalKind
from tactogram.recipe import Recipe
from tactogram_capture.sources.played import StoreReplaySource

ROOT = Path(__file__).parents[2]
ROOMS = (
    "src/tactogram/evaluation",
    "src/tactogram/training",
    "src/tactogram/workflows",
    "packages/tactogram-benchmark/src",
    "packages/tactogram-studio/src",
)
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
OWN = {
    "set_validation": {"pix2pix", "pix2pixhd", "residue_fusion_gan", "stroke_cnn", "visual_tactile_gan"},
    "outcome": {"stroke_cnn", "ultrasonic_cgan"},
    "figures": {"ultrasonic_cgan"},
    "exported_networks": {"stroke_cnn", "stroke_statistics"},
    "window_probabilities": {"stroke_cnn", "stroke_statistics"},
    "embed": {"stroke_cnn", "stroke_statistics"},
    "classify_photograph": {"nearest_photo", "residue_fusion_gan", "texture_flow", "visual_tactile_gan"},
    "prediction_facts": {"texture_flow"},
    "evaluate_as_published": {"frictgan"},
    "selection_for": {"ultrasonic_cgan"},
    "image_spread": {"tactile_image_cgan", "texture_flow"},
    "maps": {"ar_texture", "texture_var"},
    "limits": {"ar_texture", "replay", "texture_flow", "texture_gan", "texture_var"},
    "predicted_ranges": {"texture_flow"},
    "novelty": {"rater"},
    "feature_description": {"rater"},
}
"""Methods and properties of `Model` that have a default, and the models that have their own."""


def probes(text):
    """Return the lines that look for an attribute of a model by its name."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name)):
            continue
        if node.func.id in ("hasattr", "getattr") and ast.unparse(node.args[0]).split(".")[-1] in ASKED:
            found.append(ast.unparse(node))
    return found


@pytest.mark.parametrize("room", ROOMS)
def test_no_attribute_of_a_model_is_looked_for_by_its_name(room):
    found = {str(path): probes(path.read_text("utf-8")) for path in (ROOT / room).rglob("*.py")}
    assert found
    assert {name: lines for name, lines in found.items() if lines} == {}


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
        kind = interface.ImageKind(("rough",), (1.0, 7.0), ("i",))
    return facts.build(facts.config(recipe.config), kind, seed=0)


def test_every_default_is_that_of_the_models_without_their_own():
    found = {name: set() for name in OWN}
    for facts in (face for model in models.available().values() for face in model.faces):
        learner = built(facts)
        kind = type(learner)
        assert kind.embeds == (kind.embed is not Model.embed)
        for name, kept_by in found.items():
            if name in vars(learner) or getattr(kind, name) is not getattr(Model, name):
                kept_by.add(facts.name)
    assert found == OWN


class Trivial(Model):
    saved = ("materials", "level")
    level = 0.0

    def step(self, stage, batch):
        self.level = float(len(batch))
        return {"level": self.level}


def trivial(*materials):
    return Trivial(None, SignalKind(1000.0, "m/s^2", ("x",), materials))


def test_a_model_of_one_method_is_trained_saved_and_restored():
    model, other = trivial("cork"), trivial("cork")
    [stage] = model.stages(["a", "b"])
    [batch] = model.batches(stage, ["a", "b"], seed=0)
    assert model.step(stage, batch) == {"level": 2.0}
    assert list(model.batches(stage, ["a", "b"], seed=0, start=1)) == []
    assert model.state() == {"materials": ["cork"], "level": 2.0}
    other.load_state(model.state())
    assert other.level == 2.0
    with pytest.raises(ParameterError, match="state is of cork; expected tile"):
        trivial("tile").load_state(model.state())


def test_what_a_model_does_not_do_is_refused_or_empty():
    model = trivial("cork")
    with pytest.raises(ParameterError, match="Trivial does not generate"):
        model.generate({}, seed=0)
    for does in (model.probabilities, model.window_probabilities, model.embed, model.predict):
        with pytest.raises(ParameterError, match="Trivial does not"):
            does(None)
    assert model.limits({"words": {"rough": 9.0}}) == []
    assert model.set_validation([]) == ""
    assert [*model.maps, *model.predicted_ranges, *model.rated_means] == []


def test_the_window_is_that_of_the_configuration():
    assert models.find("stroke_cnn").config({"window": 96}).input_samples(330.0) == 96
    assert ModelConfig().input_samples(330.0) == 0


def test_a_simulated_source_follows_a_plan():
    assert callable(StoreReplaySource.on_trial)  # it strokes what a session's plan says

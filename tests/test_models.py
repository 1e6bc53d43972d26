"""The promises that every model keeps. A new model's folder is met here without an edit."""

import sys
from concurrent.futures import ThreadPoolExecutor, TimeoutError as FutureTimeout
from dataclasses import replace
from functools import cache
from itertools import islice
from threading import Event
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram import models
from tactogram.errors import ParameterError, TactogramError
from tactogram.model import (
    Example,
    ImageExample,
    ImageKind,
    ItemRatings,
    Model,
    SignalKind,
)
from tactogram.recipe import Recipe
from tactogram.signal import Image, Signal
from tactogram.training.checkpoint import load_state, save_state
from tactogram.training.loop import fit
from tactogram.training.run import TrainingPosition

RATE = 1000.0
WORDS = ("rough", "sticky")
GRAIN = {"cork": 1, "felt": 4, "tile": 9}
"""Pixels of a square of the photograph of each material."""
MATERIALS = {"cork": [1, -1.6, 0.9], "felt": [1, -0.9], "tile": [1, 0.3, 0.8]}
"""Simulated: noise through a filter per material."""


def photograph(material, seed):
    squares = np.random.default_rng(seed).integers(0, 256, (40, 40), np.uint8)
    gray = np.kron(squares, np.ones((GRAIN[material], GRAIN[material]), np.uint8))[:40, :40]
    return Image(np.repeat(gray[..., None], 3, axis=2))


def surface(material, seed, axes=("x", "y", "z")):
    noise = np.random.default_rng(seed).standard_normal((3, 1500))
    x = lfilter([1], MATERIALS[material], noise)[:, 500:]
    signal = Signal(0.2 * x / x.std(), RATE, "m/s^2").select(*axes)
    picture = photograph(material, seed)
    return Example(f"{material}-{seed}", signal, material, {"image": picture}, (picture,))


def data(seeds, axes=("x", "y", "z")):
    return [surface(name, seed, axes) for name in MATERIALS for seed in seeds]


TRAINING, UNSEEN = data(range(3)), data(range(10, 12))
KIND = SignalKind(RATE, "m/s^2", ("x", "y", "z"), tuple(sorted(MATERIALS)), simulated=True)
SCORES = {"rough": 5.0, "sticky": 2.0}
ASKED = {
    "material": "cork",
    "image": UNSEEN[0].photographs[0],
    "words": SCORES,
    "vibration": UNSEEN[0].signal,
}


def rated(material, seed):
    """Simulated: what three raters say, by material, item and rater."""
    rng = np.random.default_rng([seed, GRAIN[material]])
    means = np.array([GRAIN[material], 10 - GRAIN[material]]) / 10 + rng.normal(0, 0.05, 2)
    return ItemRatings(WORDS, ("ann", "bob", "eve"), np.clip(means + rng.normal(0, 0.1, (3, 2)), 0, 1))


def rated_data(facts, seeds):
    """What a model that learns from ratings is given: rated signals, images, or surfaces beside signals."""
    if facts.learns_from == "images":
        return [
            ImageExample(f"{m}-{s}", (photograph(m, s),), f"{m}-{s}", rated(m, s))
            for m in MATERIALS
            for s in seeds
        ]
    surfaces = [replace(e, item=e.material, rated=rated(e.material, 0)) for e in data(seeds, axes(facts))]
    signals = [
        replace(e, material=None, item=e.id, rated=rated(e.material, int(e.id.split("-")[1])))
        for e in data(seeds, axes(facts))
    ]
    return surfaces + signals if facts.learns_from == "both" else signals


def training(facts):
    return data(range(3), axes(facts)) if facts.learns_from == "recordings" else rated_data(facts, range(3))


def unseen(facts):
    if facts.learns_from == "recordings":
        return data(range(10, 12), axes(facts))
    return rated_data(facts, range(10, 12))


def kind(facts):
    if facts.learns_from == "images":
        return ImageKind(WORDS, (1.0, 7.0), tuple(e.item for e in training(facts)), simulated=True)
    found = replace(KIND, axes=axes(facts))
    if facts.learns_from == "recordings":
        return found
    materials = found.materials if facts.learns_from == "both" else ()
    return replace(found, words=WORDS, scale=(1.0, 7.0), materials=materials)


def axes(facts):
    """Axes that the recipe takes: some models know only one."""
    wanted = Recipe.load(facts.recipe("tiny")).prepare.axes
    return KIND.axes if wanted == "all" else wanted


def asked(facts, **more):
    """What a model needs to generate, and words if it takes any."""
    return {name: ASKED[name] for name in (*facts.needs, *{"words"} & {*facts.takes})} | more


FACES = [face for facts in models.available().values() for face in facts.faces]


def among(found):
    return pytest.mark.parametrize("facts", found, ids=lambda facts: f"{facts.name}-{facts.learns_from}")


def with_task(*tasks):
    return among([facts for facts in FACES if facts.task in tasks])


def generators(gives):
    return among([facts for facts in FACES if facts.task == "generation" and facts.gives == gives])


by_words = among([f for f in FACES if "words" in f.needs or f.learns_from == "images"])
every = with_task("classification", "generation", "prediction")


def built(facts, seed=0):
    recipe = Recipe.load(facts.recipe("tiny"))
    return facts.build(facts.config(recipe.config), kind(facts), seed=seed)


def once(facts):
    """A trained model that no test changes."""
    return trained_once(facts.name, facts.learns_from)[0]


@cache
def trained_once(name, learns_from):
    """The model, and the stage and the losses of each of its steps."""
    seen = []
    facts = models.find(name).of(images=learns_from == "images")
    learner = built(facts)
    fit(learner, training(facts), seed=0, on_step=lambda place, stage, losses: seen.append((stage, losses)))
    return learner, seen


def outputs(learner, facts):
    """What a trained model says, as one array."""
    if facts.task == "generation":
        mix = {"material": {"cork": 1, "tile": 2}} if "material" in (*facts.needs, *facts.takes) else {}
        made = learner.generate(asked(facts, **mix), seed=3)
        return made.pixels if isinstance(made, Image) else made.samples
    if facts.task == "classification":
        return np.array([learner.probabilities(e.signal) for e in UNSEEN])
    return np.array([list(learner.predict(e.signal).values()) for e in UNSEEN])


@every
def test_is_a_model(facts):
    assert isinstance(built(facts), Model)


@every
def test_has_the_three_recipes_and_every_one_loads(facts):
    assert {"paper", "quick", "tiny"} <= set(facts.recipes())
    for name in facts.recipes():
        recipe = Recipe.load(facts.recipe(name))
        assert recipe.model == facts.name
        facts.config(recipe.config)


@every
def test_says_what_it_is_in_a_readme(facts):
    text = (facts.folder / "README.md").read_text(encoding="utf-8")
    assert "@" in text, "a BibTeX entry"
    assert facts.doi in text


@every
def test_tiny_trains_and_its_losses_stay_finite(facts):
    _, seen = trained_once(facts.name, facts.learns_from)
    stages = built(facts).stages(training(facts))
    assert len(seen) == sum(stage.steps for stage in stages)
    assert all(losses for _, losses in seen)
    assert all(np.isfinite(list(losses.values())).all() for _, losses in seen)


@every
def test_judges_unseen_recordings_in_finite_figures(facts):
    figures = once(facts).validate(unseen(facts))
    assert figures
    assert np.isfinite(list(figures.values())).all()


@every
def test_state_comes_back_from_a_file(facts, tmp_path):
    learner, other = once(facts), built(facts, seed=1)
    save_state(tmp_path / "model.safetensors", learner.state())
    other.load_state(load_state(tmp_path / "model.safetensors")[0])
    np.testing.assert_array_equal(outputs(other, facts), outputs(learner, facts))


@every
def test_the_same_seed_is_the_same_model_though_it_was_interrupted(facts, tmp_path):
    """Stopped after half the steps of the last stage, saved, and continued in a new process's place."""
    learner = built(facts)
    examples = training(facts)
    *first, last = learner.stages(examples)
    stop = TrainingPosition(len(first), last.steps // 2)

    class KilledError(Exception):
        pass

    def kill(position, stage, losses):
        if position == stop:
            save_state(tmp_path / "checkpoint.safetensors", learner.state())
            raise KilledError

    if stop.step:
        with pytest.raises(KilledError):
            fit(learner, examples, seed=0, on_step=kill)
    resumed = built(facts)
    if stop.step:
        resumed.load_state(load_state(tmp_path / "checkpoint.safetensors")[0])
    fit(resumed, examples, seed=0, start=stop if stop.step else TrainingPosition())
    np.testing.assert_array_equal(outputs(resumed, facts), outputs(once(facts), facts))


@every
def test_batches_depend_on_seed_and_step_alone(facts):
    learner, examples = once(facts), training(facts)
    stage = learner.stages(examples)[-1]
    start = min(2, stage.steps - 1)
    from_begin = list(islice(learner.batches(stage, examples, seed=5), start, stage.steps))
    from_there = list(islice(learner.batches(stage, examples, seed=5, start=start), stage.steps - start))
    assert len(from_begin) == len(from_there) > 0
    for one, other in zip(from_begin, from_there, strict=True):
        for a, b in zip(one, other, strict=True):
            np.testing.assert_array_equal(_array(a), _array(b))


@generators("signal")
def test_generates_signals_of_its_kind(facts):
    learner = once(facts)
    one = learner.generate(asked(facts), seconds=0.5, seed=3)
    replace(KIND, axes=axes(facts)).check(one)
    assert len(one) == 500
    np.testing.assert_array_equal(one.samples, learner.generate(asked(facts), seconds=0.5, seed=3).samples)
    assert not np.array_equal(one.samples, learner.generate(asked(facts), seconds=0.5, seed=4).samples)
    assert len(learner.generate(asked(facts), seed=3)) > 0


@generators("image")
def test_generates_images_by_seed(facts):
    learner = once(facts)
    one = learner.generate(asked(facts), seed=3)
    assert isinstance(one, Image)
    np.testing.assert_array_equal(one.pixels, learner.generate(asked(facts), seed=3).pixels)
    assert not np.array_equal(one.pixels, learner.generate(asked(facts), seed=4).pixels)
    with pytest.raises(ParameterError, match="an image has no length"):
        learner.generate(asked(facts), seconds=1.0, seed=3)


@by_words
def test_knows_how_what_it_learned_from_was_rated(facts):
    learner = once(facts)
    assert learner.rated_means
    for means in learner.rated_means.values():
        assert means.shape == (len(WORDS),)
        assert means.min() >= 0
        assert means.max() <= 1


@with_task("generation")
def test_refuses_a_condition_it_does_not_take(facts):
    learner = once(facts)
    with pytest.raises(ParameterError, match="not one this model takes"):
        learner.generate(asked(facts, **{"no such": 1}), seed=0)
    if "material" in facts.needs:
        with pytest.raises(ParameterError, match="must be one of cork, felt, tile"):
            learner.generate(asked(facts, material="glass"), seed=0)
    for name in facts.needs:
        with pytest.raises(ParameterError, match=f"condition '{name}' is needed"):
            learner.generate({key: value for key, value in asked(facts).items() if key != name}, seed=0)


@with_task("classification")
def test_gives_one_probability_per_material(facts):
    learner = once(facts)
    assert learner.materials == KIND.materials
    for example in UNSEEN:
        shares = learner.probabilities(example.signal)
        assert shares.shape == (3,)
        assert shares.dtype == np.float64
        assert shares.min() >= 0
        assert shares.sum() == pytest.approx(1)


@with_task("classification", "prediction")
def test_judges_each_signal_by_itself(facts):
    learner = once(facts)
    np.testing.assert_array_equal(outputs(learner, facts), outputs(learner, facts))
    judge = learner.probabilities if facts.task == "classification" else learner.predict
    alone = judge(UNSEEN[-1].signal)
    for example in UNSEEN:
        judge(example.signal)
    np.testing.assert_array_equal(judge(UNSEEN[-1].signal), alone)


@with_task("classification", "prediction")
def test_refuses_a_signal_of_another_kind(facts):
    learner = once(facts)
    judge = learner.probabilities if facts.task == "classification" else learner.predict
    with pytest.raises(ParameterError, match="signal must be 1000 Hz"):
        judge(Signal(np.ones((3, 1000)), 500, "m/s^2"))


# -- how models are found -----------------------------------------------------------------------------------

FACTS = """
title = "A model from elsewhere"
authors = ["Nobody N."]
year = 2020
task = "generation"
gives = "signal"
"""

CODE = """
from tactogram.model import ModelConfig
from {name}.learner import Learner

class Config(ModelConfig):
    width: int = 3

build = Learner
"""


def elsewhere(folder, name, facts=FACTS):
    place = folder / name
    (place / "recipes").mkdir(parents=True)
    (place / "model.toml").write_text(facts, encoding="utf-8")
    (place / "__init__.py").write_text(CODE.format(name=name), encoding="utf-8")
    (place / "learner.py").write_text(
        "from tactogram.model import Model\n\nclass Learner(Model):\n    def step(self, stage, batch):\n"
        "        return {}\n",
        encoding="utf-8",
    )
    (place / "recipes" / "wide.toml").write_text(f'model = "{name}"\n[config]\nwidth = 9\n', encoding="utf-8")
    return place


def test_a_folder_is_a_model(tmp_path):
    elsewhere(tmp_path, "model_in_a_folder")
    facts = models.available([tmp_path])["model_in_a_folder"]
    recipe = Recipe.load(facts.recipe("wide"))
    assert facts.build(facts.config(recipe.config), KIND, seed=0).config.width == 9
    assert facts.build(facts.config(), KIND, seed=0).config.width == 3
    assert models.find("model_in_a_folder", [tmp_path / "model_in_a_folder"]) == facts


def test_a_model_without_the_base_classes_is_refused(tmp_path):
    place = elsewhere(tmp_path, "baseless_model")
    facts = models.find("baseless_model", [place])
    (place / "learner.py").write_text("def Learner(config, kind, *, seed, device):\n    return object()\n")
    with pytest.raises(ParameterError, match=r"build must return a tactogram.model.Model, got object"):
        facts.build(facts.config(), KIND, seed=0)
    other = elsewhere(tmp_path, "model_of_another_config")
    (other / "__init__.py").write_text("class Config:\n    pass\n")
    with pytest.raises(ParameterError, match=r"Config must be a subclass of tactogram.model.ModelConfig"):
        models.find("model_of_another_config", [other]).config()


@pytest.mark.parametrize("package", ["", "package_of_slow_models"])
def test_a_model_that_another_thread_imports_is_waited_for(tmp_path, monkeypatch, package):
    gate = SimpleNamespace(entered=Event(), opened=Event())
    monkeypatch.setitem(sys.modules, "gate", gate)
    place = elsewhere(tmp_path / package, "slowly_imported")
    slowly = "import gate\ngate.entered.set()\ngate.opened.wait(60)\n"
    (place / "__init__.py").write_text(
        slowly + CODE.format(name=f"{package}.slowly_imported".lstrip(".")), encoding="utf-8"
    )
    facts = models.available([place])["slowly_imported"]
    if package:
        monkeypatch.syspath_prepend(tmp_path)
        facts = facts.model_copy(update={"package": f"{package}.slowly_imported"})
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(facts.config_class)
        assert gate.entered.wait(60)
        second = pool.submit(facts.config_class)
        try:
            with pytest.raises(FutureTimeout):
                second.result(0.2)
        finally:
            gate.opened.set()
        assert second.result(60) is first.result(60)


def test_environment_names_folders_of_models(tmp_path, monkeypatch):
    elsewhere(tmp_path, "model_of_the_environment")
    monkeypatch.setenv(models.FOLDERS_VARIABLE, str(tmp_path))
    assert "model_of_the_environment" in models.available()


def test_installed_packages_bring_models(tmp_path, monkeypatch):
    (tmp_path / "installed_package").mkdir()
    (tmp_path / "installed_package" / "__init__.py").write_text("raise ImportError('read, not imported')")
    elsewhere(tmp_path / "installed_package", "model_of_a_package")
    facts = tmp_path / "some-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: some\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text("[tactogram.models]\nx = installed_package.model_of_a_package\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert models.available()["model_of_a_package"].folder.parent.name == "installed_package"


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        (FACTS + 'colour = "red"\n', "unknown key 'colour'"),
        (FACTS.replace('"generation"', '"cooking"'), "task"),
        (FACTS + 'needs = ["smell"]\n', "unknown 'smell'"),
        ("title = ", "not readable as TOML"),
        (FACTS.replace("year = 2020", ""), "year"),
    ],
)
def test_broken_facts_are_one_line_that_names_the_file(tmp_path, facts, message):
    place = elsewhere(tmp_path, "broken_model", facts)
    with pytest.raises(TactogramError, match=message) as error:
        models.available([tmp_path])
    assert str(place / "model.toml") in str(error.value)
    assert "\n" not in str(error.value)


def test_two_models_of_one_name_are_refused(tmp_path):
    elsewhere(tmp_path / "a", "twin_model")
    elsewhere(tmp_path / "b", "twin_model")
    with pytest.raises(ParameterError, match="two models are called 'twin_model'"):
        models.available([tmp_path / "a", tmp_path / "b"])


def test_name_of_another_module_is_refused(tmp_path):
    elsewhere(tmp_path, "json")
    with pytest.raises(ParameterError, match="name of another module"):
        models.available([tmp_path])["json"].config_class()


def test_folder_without_models_is_refused(tmp_path):
    with pytest.raises(ParameterError, match=r"found no model\.toml"):
        models.available([tmp_path])


def test_unknown_model_and_recipe_name_what_there_is():
    with pytest.raises(ParameterError, match="must be one of .*ar_texture.*got 'nothing'"):
        models.find("nothing")
    with pytest.raises(ParameterError, match="must be one of paper, quick, tiny"):
        models.find("ar_texture").recipe("huge")


def test_unknown_config_key_is_refused():
    with pytest.raises(ParameterError, match="unknown key 'depth'"):
        models.find("ar_texture").config({"depth": 3})


def _array(value):
    if isinstance(value, Example | ImageExample):
        return value.signal.samples if isinstance(value, Example) else value.image.pixels
    return np.asarray(value)


# -- networks in another runtime -----------------------------------------------------------------------------


@pytest.mark.slow
def test_the_classifiers_network_gives_the_same_in_onnxruntime(tmp_path):
    pytest.importorskip("onnxscript", reason="the extra export is not installed")
    from tactogram.workflows.training.export import export_network

    [network] = once(models.find("stroke_cnn")).exported_networks().values()
    described = export_network(network, tmp_path / "network.onnx")
    assert all(difference < 1e-5 for difference in described["difference"].values())
    assert [port["name"] for port in described["inputs"]] == list(network.inputs)
    for port, given in zip(described["inputs"], network.draw(0), strict=True):
        sizes = [n if n is not None else m for n, m in zip(port["shape"], given.shape, strict=True)]
        assert tuple(sizes) == given.shape

"""Table 4: methods in pairs against the proposed one; nothing is trained here."""

from pathlib import Path

import numpy as np
import pytest
import torch
from made_up_pictures import MadeUpWorkflows

from tactogram import models
from tactogram.errors import DataError
from tactogram.model import Example, SignalKind
from tactogram.nn.photo_translation import PhotoTranslation
from tactogram.recipe import Recipe
from tactogram.signal import Signal
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import (
    artifacts,
    picture_cells,
    visual_tactile_gan_table4 as table4,
)
from tactogram_simulate.photo import photographs
from tactogram_simulate.sets import SETS


@pytest.fixture(autouse=True)
def made_up(stand_in):
    return stand_in(MadeUpWorkflows(), picture_cells, artifacts)


@pytest.fixture(autouse=True)
def no_weights(monkeypatch, tmp_path):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))


def test_variants_are_compared_with_the_proposed_and_have_no_published_figure(tmp_path, made_up):
    found = table4.run(tmp_path, paper=False, progress=silent, trainings=2, methods="variants")
    assert list(found["methods"]) == ["proposed", *table4.VARIANTS]
    assert found["methods"]["FM weight 80"]["published_lpips"] is None
    assert {"config.label": "probabilities"}.items() <= made_up.trained[-1][2].items()


def test_missing_weights_are_reported_before_anything_is_trained(tmp_path, made_up):
    seen = []
    table4.run(
        tmp_path, paper=False, progress=lambda *line: seen.append(line), trainings=1, methods="pix2pix"
    )
    first = [note for task, _, _, note in seen[:3] if task.startswith("weights of")]
    assert [note.partition(" (")[0] for note in first] == [
        f"weights of {network}" for network in ("AlexNet", "Inception", "VGG-19")
    ]
    assert "or set vgg19 to the file" in first[2]
    with pytest.raises(DataError, match="DenseNet-201 .* are missing: put densenet201"):
        table4.run(tmp_path, paper=True, progress=silent)
    with pytest.raises(
        DataError, match=r"gone.pth: no weights of VGG-19 there; set vgg19 to vgg19-dcbb9e9d.pth"
    ):
        table4.run(tmp_path, paper=False, progress=silent, vgg19="gone.pth")


def test_given_weights_reach_the_measures_and_losses(tmp_path, made_up):
    files = {}
    for option in picture_cells.WEIGHTS:
        files[option] = str(tmp_path / f"{option}.pth")
        Path(files[option]).touch()
    table4.run(tmp_path, paper=True, progress=silent, trainings=1, **files)
    asked = {model: changes for model, _, changes in made_up.trained}
    assert asked["residue_fusion_gan"]["config.vgg_weights"] == files["vgg19"]
    assert asked["residue_fusion_gan"]["config.predictor.trunk_weights"] == files["densenet201"]
    assert asked["pix2pix"]["config.lpips_weights"] == files["alexnet"]
    assert "config.predictor.trunk_weights" not in asked["pix2pix"]
    assert (made_up.weights.alexnet, made_up.weights.inception) == (files["alexnet"], files["inception"])


def test_table_4_pairs_seeds_against_the_proposed(tmp_path):
    found = table4.run(tmp_path, paper=False, progress=silent, trainings=3)
    rows = found["methods"]
    assert rows["pix2pix"]["test"]["l1"]["mean"] == pytest.approx(0.5, abs=0.01)
    assert rows["proposed"]["p"]["l1"] is None
    assert rows["pix2pix"]["p"]["l1"] < 1e-3
    assert rows["without FM"]["p"]["l1"] is None  # nothing differs
    assert rows["pix2pix"]["published_fid"] == (52.23, 2.01)
    assert found["missing"]["lpips"] == "no weights"
    assert "lpips: no weights" in found["text"]


def test_what_is_simulated_for_paper_has_the_published_pairs(tmp_path, made_up):
    densenet = tmp_path / "densenet.pth"
    densenet.touch()
    table4.run(tmp_path, paper=True, progress=silent, trainings=1, densenet201=str(densenet))
    assert made_up.most == 900
    assert made_up.split == "all"  # the paper splits crops
    asked, simulated = made_up.simulated, SETS[made_up.simulated["name"]]
    surface, length = simulated.surfaces[0], round(asked["seconds"] * asked["rate"])
    noise, shown = np.random.default_rng(0), tuple(photographs(surface, asked["photographs"]))
    signals = [
        Signal(noise.standard_normal((1, length)), asked["rate"], "m/s^2", ("z",))
        for _ in range(asked["per_class"])
    ]
    examples = [Example(f"stroke{n}", x, surface.name, photographs=shown) for n, x in enumerate(signals)]
    kind = SignalKind(asked["rate"], "m/s^2", ("z",), (surface.name,), simulated=True)
    for name in {model for model, _, _ in made_up.trained}:
        changes = next(changes for model, _, changes in made_up.trained if model == name)
        facts = models.find(name)
        config = facts.config(Recipe.load(facts.recipe("paper"), changes=changes).config)
        translation = PhotoTranslation(config.pairs, kind, seed=0)
        translation.fit(examples[:1])
        parts = [translation.pairs(examples, part) for part in ("train", "validation", "test")]
        assert [len(part) for part in parts] == [800, 100, 100]
        assert parts[0].batch([0]).picture.shape == (1, 1, 256, 256)


def test_ablations_are_those_of_the_recipes():
    """Table 4: W/o CBN, W/o L1 loss, W/o FM loss, Single Discriminator, beside three baselines."""
    facts = models.find("visual_tactile_gan")
    rows = {"no-cbn": "without CBN", "no-l1": "without L1", "no-fm": "without FM"}
    for name, row in (rows | {"one-discriminator": "one discriminator"}).items():
        model, changes = table4.METHODS[row]
        recipes = [
            Recipe.load(facts.recipe("paper"), changes=changes),
            Recipe.load(facts.recipe(f"ablation-{name}")),
        ]
        assert model == facts.name
        assert facts.config(recipes[0].config) == facts.config(recipes[1].config)
    others = [model for model, changes in table4.METHODS.values() if not changes]
    assert others == ["pix2pix", "pix2pixhd", "residue_fusion_gan", "visual_tactile_gan"]


def test_finished_cells_are_not_trained_again(tmp_path, made_up):
    first = table4.run(tmp_path, paper=False, progress=silent, trainings=2)
    trained = len(made_up.trained)
    assert trained == 2 * len(table4.METHODS)
    assert table4.run(tmp_path, paper=False, progress=silent, trainings=2) == first
    assert len(made_up.trained) == trained
    assert all(changes["prepare.axes"] == ["z"] for _, _, changes in made_up.trained)

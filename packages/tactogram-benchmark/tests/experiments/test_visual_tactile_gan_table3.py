"""Tables 3 and 4: cells are trained once, compared in pairs, chosen on the validation part."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import torch

from tactogram import models
from tactogram.datasets import Recording, create_store
from tactogram.datasets.simulate.photo import photographs
from tactogram.datasets.simulate.sets import SETS
from tactogram.errors import DataError, ParameterError
from tactogram.model import Example, SignalKind
from tactogram.nn.photo_translation import PhotoTranslation
from tactogram.recipe import Recipe
from tactogram.signal import Signal
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import (
    artifacts,
    picture_cells,
    visual_tactile_gan_table3 as table3,
    visual_tactile_gan_table4 as table4,
)
from tactogram_benchmark.experiments.picture_cells import against


class MadeUpWorkflows:
    """Trains nothing: what a cell finds is a formula of what was asked."""

    def __init__(self):
        self.trained = []

    def simulate_to_store(self, name, out, *, seed, photographs, progress, **options):
        self.simulated = {"name": name, "photographs": photographs, **options}
        strokes = (
            Recording(
                streams={
                    "acceleration": Signal(np.random.default_rng(k).standard_normal((3, 50)), 100, "m/s^2")
                },
                material="cork",
                simulated=True,
            )
            for k in range(2)
        )
        create_store(out, strokes, name="made up", licence="-", simulated=True)

    def train(self, model, data, *, recipe, changes, split, out, resume, progress):
        self.trained.append((model, recipe, dict(changes)))
        self.split = split
        out.mkdir(parents=True)
        d, layers = (changes.get(f"config.{key}", 3) for key in ("discriminators", "layers"))
        validation = {"row_statistics_unseen": abs(d - 3) + abs(layers - 1), "label_accuracy_unseen": 1.0}
        figure = {"pix2pix": 0.5, "pix2pixhd": 0.4, "residue_fusion_gan": 0.3}.get(model, 0.2)
        noise = np.random.default_rng([changes["seed"], *model.encode()]).normal()
        changed = abs(d - 3) + abs(layers - 3) + (changes.get("config.l1") == 0.0)
        figure += 0.001 * noise + 0.1 * changed * (1 + 0.1 * changes["seed"])
        (out / "found.json").write_text(json.dumps(figure))
        return SimpleNamespace(read_json=lambda name: {"validation": validation})

    def evaluate_pictures(self, run, *, weights, most, progress):
        self.weights, self.most = weights, most
        figure = json.loads((run / "found.json").read_text())
        values = {"l1": figure, "log_spectral_distance_db": 10 * figure}
        return {"values": values, "missing": {"lpips": "no weights"}, "pictures": 8}


@pytest.fixture(autouse=True)
def made_up(stand_in):
    return stand_in(MadeUpWorkflows(), picture_cells, artifacts)


@pytest.fixture(autouse=True)
def no_weights(monkeypatch, tmp_path):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))


def test_table_3_is_chosen_on_the_validation_part_and_tested_against_the_chosen_cell(tmp_path):
    found = table3.run(tmp_path, paper=False, progress=silent, trainings=3)
    assert len(found["cells"]) == 16
    assert found["chosen"] == "3x1"
    assert found["cells"]["3x1"]["p"]["l1"] is None
    assert found["cells"]["1x1"]["p"]["l1"] < 0.05
    assert "3x1*" in found["text"]
    assert "0.3113 ± 0.0087" in found["text"]
    assert "simulated" in found["text"]
    assert (tmp_path / "figure2.png").read_bytes().startswith(b"\x89PNG")


def test_some_cells_of_table_3_are_a_table_without_a_surface(tmp_path, made_up):
    found = table3.run(tmp_path, paper=False, progress=silent, trainings=1, cells="1x4, 2x2")
    assert list(found["cells"]) == ["1x4", "2x2"]
    assert found["figure"] is None
    assert len(made_up.trained) == 2
    with pytest.raises(ParameterError, match="cells must be some of 1x1.*got '5x1'"):
        table3.run(tmp_path, paper=False, progress=silent, cells="5x1")


def test_variants_are_compared_with_the_proposed_and_have_no_published_figure(tmp_path, made_up):
    found = table4.run(tmp_path, paper=False, progress=silent, trainings=2, methods="variants")
    assert list(found["methods"]) == ["proposed", *table4.VARIANTS]
    assert found["methods"]["FM weight 80"]["published_lpips"] is None
    assert {"config.label": "probabilities"}.items() <= made_up.trained[-1][2].items()


def test_crop_split_trains_on_all_recordings_in_runs_of_its_own(tmp_path, made_up):
    table3.run(tmp_path, paper=False, progress=silent, trainings=1, cells="3x3")
    assert made_up.split == ""
    found = table3.run(
        tmp_path, paper=False, progress=silent, trainings=1, cells="3x3", protocol="crop-split"
    )
    assert (found["protocol"], made_up.split) == ("crop-split", "all")
    assert made_up.trained[-1][2]["config.pairs.protocol"] == "crop-split"
    assert (tmp_path / "runs" / "3x3-crop-split-0").is_dir()


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
    assert made_up.split == "last=1"
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
        crops = config.pairs.model_copy(update={"protocol": "crop-split"})
        translation = PhotoTranslation(crops, kind, seed=0)
        translation.fit(examples[:1])
        parts = [translation.pairs(examples, part) for part in ("train", "validation", "test")]
        assert [len(part) for part in parts] == [800, 100, 100]
        assert parts[0].batch([0]).picture.shape == (1, 1, 256, 256)


def test_finished_cells_are_not_trained_again(tmp_path, made_up):
    first = table4.run(tmp_path, paper=False, progress=silent, trainings=2)
    trained = len(made_up.trained)
    assert trained == 2 * len(table4.METHODS)
    assert table4.run(tmp_path, paper=False, progress=silent, trainings=2) == first
    assert len(made_up.trained) == trained
    assert all(changes["prepare.axes"] == ["z"] for _, _, changes in made_up.trained)


def test_the_paired_test_is_scipys():
    assert against([1.0, 2.0, 3.0], [2.0, 3.5, 3.9]) == pytest.approx(0.0256, abs=1e-3)
    assert against([1.0, 2.0], [2.0, 3.0]) is None
    assert against([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]) is None

"""Tables 3 and 4: cells are trained once, compared in pairs, chosen on the validation part."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from tactogram import models
from tactogram.datasets import Recording, create_store
from tactogram.datasets.simulate.photo import photographs
from tactogram.datasets.simulate.sets import SETS
from tactogram.experiments import artifacts, picture_cells
from tactogram.experiments import visual_tactile_gan_table3 as table3
from tactogram.experiments import visual_tactile_gan_table4 as table4
from tactogram.experiments.picture_cells import against
from tactogram.model import Example, SignalKind
from tactogram.nn.photo_translation import PhotoTranslation
from tactogram.recipe import Recipe
from tactogram.signal import Signal
from tactogram.workflows.progress import silent


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

    def train(self, model, data, *, recipe, changes, out, resume, progress):
        self.trained.append((model, recipe, dict(changes)))
        out.mkdir(parents=True)
        d, layers = (changes.get(f"config.{key}", 3) for key in ("discriminators", "layers"))
        validation = {"row_statistics_unseen": abs(d - 3) + abs(layers - 1), "label_accuracy_unseen": 1.0}
        figure = {"pix2pix": 0.5, "pix2pixhd": 0.4, "residue_fusion_gan": 0.3}.get(model, 0.2)
        noise = np.random.default_rng([changes["seed"], *model.encode()]).normal()
        figure += 0.001 * noise + 0.1 * (changes.get("config.l1") == 0.0) * (1 + 0.1 * changes["seed"])
        (out / "found.json").write_text(json.dumps(figure))
        return SimpleNamespace(read_json=lambda name: {"validation": validation})

    def evaluate_pictures(self, run, *, most, progress):
        figure = json.loads((run / "found.json").read_text())
        values = {"l1": figure, "log_spectral_distance_db": 10 * figure}
        return {"values": values, "missing": {"lpips": "no weights"}, "pictures": 8}


@pytest.fixture(autouse=True)
def made_up(stand_in):
    return stand_in(MadeUpWorkflows(), picture_cells, artifacts)


def test_table_3_is_chosen_on_the_validation_part(tmp_path):
    found = table3.run(tmp_path, paper=False, progress=silent, trainings=2)
    assert set(found["cells"]) == {"1x1", "1x3", "3x1", "3x3"}
    assert found["chosen"] == "3x1"
    assert "3x1*" in found["text"]
    assert "0.3113 ± 0.0087" in found["text"]
    assert "simulated" in found["text"]


def test_table_4_pairs_seeds_against_the_proposed(tmp_path):
    found = table4.run(tmp_path, paper=False, progress=silent, trainings=3)
    rows = found["methods"]
    assert rows["pix2pix"]["test"]["l1"]["mean"] == pytest.approx(0.5, abs=0.01)
    assert rows["proposed"]["p"]["l1"] is None
    assert rows["pix2pix"]["p"]["l1"] < 1e-3
    assert rows["without FM"]["p"]["l1"] is None  # nothing differs
    assert rows["pix2pix"]["published_fid"] == (52.23, 2.01)
    assert found["missing"] == {"lpips": "no weights"}
    assert "lpips: no weights" in found["text"]


@pytest.mark.parametrize("table", [table3, table4])
def test_what_is_simulated_for_paper_holds_published_pictures_and_crops(tmp_path, made_up, table):
    table.run(tmp_path, paper=True, progress=silent, trainings=1)
    simulated, rate = SETS[made_up.simulated["name"]], made_up.simulated["rate"]
    surface, length = simulated.surfaces[0], round(simulated.seconds * rate)
    signal = Signal(np.random.default_rng(0).standard_normal((1, length)), rate, "m/s^2", ("z",))
    shown = tuple(photographs(surface, made_up.simulated["photographs"]))
    examples = [Example("stroke", signal, surface.name, photographs=shown)]
    kind = SignalKind(rate, "m/s^2", ("z",), (surface.name,), simulated=True)
    for name in {model for model, _, _ in made_up.trained}:
        changes = next(changes for model, _, changes in made_up.trained if model == name)
        facts = models.find(name)
        config = facts.config(Recipe.load(facts.recipe("paper"), changes=changes).config)
        translation = PhotoTranslation(config.pairs, kind, seed=0)
        translation.check(examples)
        translation.fit(examples)
        assert translation.pairs(examples).batch([0]).picture.shape == (1, 1, 256, 256)


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

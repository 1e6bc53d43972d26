"""Figs. 4 to 6 of Hatori et al. 2025: what is trained, kept and said; nothing is trained here."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest
from benchmarks.experiments import image_label_balance

from tactogram.datasets import Recording, create_store
from tactogram.datasets.ratings.ratings import EVOKED, SEVEN_POINT, Ratings
from tactogram.datasets.ratings.words import WORDS
from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.distances import ImageSpread
from tactogram.model import ImageKind
from tactogram.signal import Image, Signal
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import (
    artifacts,
    cross_modal,
    image_cells,
    tactile_image_cgan_figure4 as figure4,
)

PLATES = ("plate01", "plate02", "plate03")


def rated(items, scale, seed):
    rng = np.random.default_rng(seed)
    rows = [(rater, item, word) for rater in ("ann", "bob") for item in items for word in WORDS]
    scores = rng.integers(scale.low, scale.high + 1, len(rows)).astype(float)
    return Ratings(*(list(column) for column in zip(*rows, strict=True)), scores, scale, words=WORDS)


def loop(seed):
    return Signal(
        0.3 * np.random.default_rng(seed).standard_normal(10000).astype(np.float32), 10000.0, "1", ("drive",)
    )


class Painting:
    """Grey as bright as the mean score; blind ones paint one grey."""

    def __init__(self, blind):
        self.blind = blind

    def generate(self, condition, *, seed):
        grey = 0.5 if self.blind else np.mean(list(condition["words"].values()))
        noise = np.random.default_rng(seed).integers(0, 20, (8, 8, 3))
        return Image((200 * grey + noise).astype(np.uint8))

    def image_spread(self):
        return ImageSpread(0.5, 0.3, 0.0 if self.blind else 0.3)


class MadeUpWorkflows:
    """A generator of weight 1 follows its label; heavier ones are blind."""

    def __init__(self):
        self.trained = []

    def simulate_to_store(self, name, out, *, seed, progress):
        if name == "tactile_images":
            shown = [
                (f"image{n}", Painting(False).generate({"words": {"rough": n / 4}}, seed=n)) for n in range(4)
            ]
            ratings = rated([item for item, _ in shown], EVOKED, 1)
            create_store(out, [], name=name, licence="-", simulated=True, ratings=ratings, photographs=shown)
            return
        surfaces = (
            Recording(streams={"strain": loop(n)}, material=plate, source=plate, simulated=True)
            for n, plate in enumerate(PLATES)
        )
        create_store(
            out, surfaces, name=name, licence="-", simulated=True, ratings=rated(PLATES, SEVEN_POINT, 2)
        )

    def train(self, model, data, *, recipe, out, **options):
        self.trained.append((model, recipe, out.name, options.get("split", ""), options.get("changes", {})))
        out.mkdir(parents=True, exist_ok=True)

    def load_run(self, run):
        weight = run.name.split("-")[1] if "-" in run.name else ""
        lines = [{"step": n, "generator": 2.0, "discriminator": 1.0, "correct": 0.5} for n in range(1, 5)]
        return SimpleNamespace(
            run=SimpleNamespace(data={"run_id": run.name}, metrics=lambda: lines, folder=run),
            any_kind=ImageKind(WORDS, (0.0, 1.0), ("image1",), simulated=True),
            model=Painting(weight != "1"),
            generator=Painting(weight != "1"),
            simulated=True,
        )

    def score(self, judging, image):
        return {"scores": dict.fromkeys(WORDS, float(image.pixels.mean() / 210)), "scale": [0.0, 1.0]}

    def generate_rated_surfaces(self, run, *, seed):
        store_means = rated(PLATES, SEVEN_POINT, 2)
        targets = dict(zip(store_means.items, map(tuple, store_means.means.tolist()), strict=True))
        return SimpleNamespace(
            signals={plate: loop(10 + n) for n, plate in enumerate(PLATES[:2])},
            straight={plate: loop(n) for n, plate in enumerate(PLATES)},
            targets=targets,
            failed={"plate03": "the training of cluster 2 failed"},
            ratings=store_means,
        )


@pytest.fixture(autouse=True)
def made_up(stand_in):
    return stand_in(MadeUpWorkflows(), figure4, cross_modal, image_cells, artifacts)


@pytest.fixture
def quality(monkeypatch):
    class Quality:
        def __init__(self, real):
            self.real, self.missing = real, {"fid": "weights are not here"}

        def __call__(self, made):
            return {"efficientnet_lite0_frechet_distance": float((made.mean() - self.real.mean()).abs())}

    monkeypatch.setattr(image_cells, "ImageQuality", Quality)
    monkeypatch.setattr(image_cells, "of_real_images", lambda images, rater: None)


def test_figure_4_trains_four_weights_and_says_which_follow(tmp_path, quality, made_up):
    found = figure4.run(tmp_path, paper=False, progress=silent)
    painters = [row for row in made_up.trained if row[0] == "tactile_image_cgan"]
    assert [row[4]["config.image_weight"] for row in painters] == [1, 1000, 5000, 10000]
    assert {row[3] for row in painters} == {"all"}
    follows = {weight: row[0]["following"]["correlation"] for weight, row in found["variants"].items()}
    assert follows["weight 1"] > 0.1
    assert follows["weight 5,000"] == pytest.approx(0, abs=1e-9)
    assert found["variants"]["weight 5,000"][0]["collapse"] == "the label makes no difference"
    assert found["variants"]["weight 1,000"][0]["losses"]["discriminator"] == 1.0
    assert "simulated" in found["text"]
    assert "fid: weights are not here" in found["text"]
    assert (tmp_path / "figure4.png").is_file()
    assert (tmp_path / "trade_off.png").is_file()


def test_each_balance_is_trained_with_its_own_configuration(tmp_path, quality, made_up, monkeypatch):
    monkeypatch.setattr(image_label_balance, "FOLDS", 2)
    found = image_label_balance.run(
        tmp_path, paper=False, progress=silent, variants="projection; regression, rated", trainings=2
    )
    changes = [row[4] for row in made_up.trained if row[0] == "tactile_image_cgan"]
    assert [row["seed"] for row in changes] == [0, 1, 0, 1]
    assert changes[0]["config.label_input"] == "projection"
    assert changes[2]["config.fake_scores"] == "rated"
    assert found["trainings"] == {"projection": 2, "regression, rated": 2}
    assert 0 <= found["scores_alone"] <= 1
    with pytest.raises(ParameterError, match="variants must be of weight 1; .*, got attention"):
        image_label_balance.run(tmp_path, paper=False, progress=silent, variants="projection; attention")


def test_figure_4_reads_what_it_judged_before(tmp_path, quality, monkeypatch):
    first = figure4.run(tmp_path, paper=False, progress=silent, weights="1,10")
    assert set(first["variants"]) == {"weight 1", "weight 10"}
    monkeypatch.setattr(image_cells, "score", None)
    assert figure4.run(tmp_path, paper=False, progress=silent, weights="1,10") == first


@pytest.mark.parametrize("weights", ["", "0,1", "heavy", "1,2,3,4,5,6,7,8,9"])
def test_weights_that_are_none_are_refused(tmp_path, weights):
    with pytest.raises(ParameterError, match="weights must be 1 to 8 whole numbers"):
        figure4.run(tmp_path, paper=False, progress=silent, weights=weights)


def test_cross_modal_has_six_conditions_and_two_groups_of_people(tmp_path):
    found = cross_modal.run(tmp_path, paper=False, progress=silent)
    assert list(found["overall"]) == [
        "without models", "without images", "weight 1", "weight 1000", "weight 5000", "weight 10000"
    ]  # fmt: skip
    assert found["told_by"] == "simulated observers"
    assert found["plates"]["judged"] == ["plate01", "plate02"]
    assert "no signal of plate03: the training of their cluster failed" in found["text"]
    assert 0.9 * 20 * 2 * 10 < found["overall"]["weight 1"]["n"] <= 20 * 2 * 10
    assert found["by_person"]["groups"]["weight 1"]["n"] == 20
    assert found["people_in_both_groups"] == []
    with (tmp_path / "items.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6 * 2
    assert {bool(row["image"]) for row in rows if row["item"].startswith("without")} == {False}
    assert all((tmp_path / row["vibration"]).is_file() for row in rows)
    assert (tmp_path / "figure5.png").is_file()
    assert (tmp_path / "figure6.png").is_file()


def test_cross_modal_of_real_answers_says_people(tmp_path, made_up):
    """Answers that repeat the plates' means err by nothing; those of the others by one point."""
    targets = made_up.generate_rated_surfaces(None, seed=0).targets
    lines = ["rater,item,word,score"]
    for condition in ("without models", "without images", *(f"weight {w}" for w in (1, 1000, 5000, 10000))):
        for rater in ("p1", "p2", "p3"):
            for plate in PLATES[:2]:
                for word, mean in zip(WORDS, targets[plate], strict=True):
                    score = round(mean) if condition == "weight 5000" else 1 + (round(mean) % 7)
                    lines.append(f"{rater},{condition}/{plate},{word},{score}")
    (tmp_path / "answers.csv").write_text("\n".join(lines) + "\n")
    found = cross_modal.run(
        tmp_path / "out", paper=False, progress=silent, ratings=str(tmp_path / "answers.csv")
    )
    assert found["told_by"] == "people"
    assert found["people_in_both_groups"] == ["p1", "p2", "p3"]
    assert "3 people are in both groups: p by person treats them as different people" in found["text"]
    assert found["overall"]["weight 5000"]["mean"] < 0.3 < found["overall"]["weight 1"]["mean"]

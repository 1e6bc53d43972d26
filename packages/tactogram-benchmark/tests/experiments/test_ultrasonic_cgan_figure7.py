"""Fig. 7 of Hatori & Takemura 2023: who rates, what failed, and real answers; nothing is trained here."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest

from tactogram.datasets import Ratings, Recording, create_store
from tactogram.datasets.ratings.table import write_table
from tactogram.datasets.ratings.words import WORDS
from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import artifacts, ultrasonic_cgan_figure7, ultrasonic_cgan_selection

PLATES = ("plate01", "plate02", "plate03")


def drive(seed, level):
    time = np.arange(10_000) / 10_000
    return Signal(level * np.sin(2 * np.pi * (60 + 40 * seed) * time), 10_000, "1", ("drive",))


def ratings_of(items, seed=0):
    rng = np.random.default_rng(seed)
    rows = [(f"r{r}", item, word) for r in range(4) for item in items for word in WORDS]
    rater, item, word = zip(*rows, strict=True)
    return Ratings(rater, item, word, rng.integers(1, 8, len(rows)).astype(float), words=WORDS)


class MadeUpWorkflows:
    """Trains nothing: signals are sines, one plate of group B failed, and the rater model draws its scores."""

    def __init__(self):
        self.trained = []

    def simulate_to_store(self, name, out, *, seed, progress):
        assert name == "ultrasonic"
        one = Recording(streams={"drive": drive(0, 1.0)}, labels={"item": "signal01"}, simulated=True)
        create_store(
            out, [one], ratings=ratings_of(["signal01"]), name="made up", licence="-", simulated=True
        )

    def train(self, model, data, *, recipe, changes, out, resume, **more):
        self.trained.append((model, changes.get("config.clusters"), recipe, resume))
        out.mkdir(parents=True, exist_ok=True)
        (out / "recipe.toml").touch()

    def generate_rated_surfaces(self, run, *, seed):
        failed = {"plate02": "the training of cluster 2 failed"} if run.name.startswith("B") else {}
        return SimpleNamespace(
            signals={p: drive(n, 0.5 + 0.1 * seed) for n, p in enumerate(PLATES) if p not in failed},
            failed=failed,
            targets={p: tuple(np.linspace(1, 7, len(WORDS)) * 0 + 2 + n) for n, p in enumerate(PLATES)},
            straight={p: drive(n, 1.0) for n, p in enumerate(PLATES)},
            nearest={p: drive(n, 0.2) for n, p in enumerate(PLATES)},
            ratings=ratings_of([*PLATES, "signal01", "signal02"]),
            recordings="3 of the test part",
        )

    def crossval(self, model, data, **options):
        row = {
            "mae": 0.5,
            "mae_sd": 0.1,
            "constant_mae": 0.9,
            "p_against_constant": 0.01,
            "rank_correlation": 0.7,
        }
        return {
            "mean": row, "per_word": {"rough": row}, "split": "10 folds", "described_by": "levels", "items": 5,
            "options": options,
        }  # fmt: skip

    def predicted_ratings(self, run, signals):
        found = ratings_of(list(signals))
        return found.select(raters=["r0"])


@pytest.fixture(autouse=True)
def made_up(stand_in):
    return stand_in(MadeUpWorkflows(), ultrasonic_cgan_figure7, artifacts)


def test_figure_7_is_told_by_simulated_raters_and_a_rater_model_and_says_what_failed(tmp_path, made_up):
    found = ultrasonic_cgan_figure7.run(tmp_path, paper=False, progress=silent, groups="A,B", trainings=2)
    told = found["told_by"]
    assert list(told) == ["simulated raters", "a rater model of simulated raters"]
    people = told["simulated raters"]
    assert list(people["conditions"]) == ["sensor", "nearest", "A", "B"]
    assert people["conditions"]["A"]["n"] > 0.95 * 20 * 3 * 10
    assert people["incomplete"] == ["B"]
    assert found["failed"] == {"B": {"plate02": "the training of cluster 2 failed"}}
    assert "group B, plate02: the training of cluster 2 failed" in found["text"]
    assert found["spread_over_trainings"]["A"]["sd"] is not None
    assert found["text"].count("rater model was trained on the display signals") == 1
    assert set(found["word_map"]["distance_to_target"]) >= {"sensor/plate01", "A/plate03", "B/plate01"}
    for file in (found["word_map"]["figure"], people["figure"], tmp_path / "items.csv"):
        assert (tmp_path / file).is_file()
    assert [run[1] for run in made_up.trained if run[0] == "ultrasonic_cgan"] == [1, 1, 2, 2]


def test_figure_7_of_real_answers_is_made_by_the_same_command(tmp_path, made_up):
    items = [f"{name}/{plate}" for name in ("sensor", "nearest", "A") for plate in PLATES]
    for run in ("A-0", "rater"):
        (tmp_path / "runs" / run).mkdir(parents=True)
        (tmp_path / "runs" / run / "recipe.toml").touch()
    write_table(tmp_path / "answers.csv", ratings_of(items, seed=3))
    found = ultrasonic_cgan_figure7.run(
        tmp_path, paper=False, progress=silent, groups="A", ratings=str(tmp_path / "answers.csv")
    )
    assert found["told_by"]["people"]["raters"] == 4
    assert found["told_by"]["people"]["conditions"]["A"]["n"] == 4 * 3 * 10
    assert found["word_map"]["told_by"] == "people"
    with (tmp_path / "items.csv").open(newline="") as file:
        assert [row["item"] for row in csv.DictReader(file)] == items
    assert all(run[3] for run in made_up.trained), "finished runs are continued, not made again"


@pytest.mark.parametrize("groups", ["", "A,F", "a"])
def test_groups_that_are_none_are_refused(tmp_path, groups):
    with pytest.raises(ParameterError, match="groups must be some of A, B, C, D, E"):
        ultrasonic_cgan_figure7.run(tmp_path, paper=False, progress=silent, groups=groups)


class MadeUpClusters:
    """Three plates, the first two alike; the rate of plates 1 and 2 dips for one iteration, that of 3 for 100."""

    def __init__(self):
        self.trained = []

    def find_or_simulate(self, path, name, *, given, progress):
        scores = {"plate01": 2, "plate02": 3, "plate03": 6, "signal01": 4}
        rows = [(f"r{r}", item, word, scores[item]) for r in range(3) for item in scores for word in WORDS]
        rater, item, word, score = zip(*rows, strict=True)
        made = [
            Recording(streams={"drive": drive(n, 1.0)}, material=name, simulated=True)
            for n, name in enumerate(PLATES)
        ]
        made.append(Recording(streams={"drive": drive(3, 1.0)}, labels={"item": "signal01"}, simulated=True))
        ratings = Ratings(rater, item, word, np.array(score, float), words=WORDS)
        return create_store(path, made, ratings=ratings, name="made up", licence="-", simulated=True)

    def trained_run(self, model, store, out, *, where, changes, split, **more):
        self.trained.append((out.name, where, changes["config.smooth"], split))

    def load_run(self, out):
        curves = np.ones((3, 300), np.float32)
        curves[2, slice(99, 100) if out.name == "plates-01-02-0" else slice(50, 150)] = 0.5
        if out.name == "plates-01-02-03-0":
            curves[2] = 1
        config = SimpleNamespace(choose_after=0)
        return SimpleNamespace(model=SimpleNamespace(config=config, trained=[SimpleNamespace(curves=curves)]))

    def generate_rated_surfaces(self, out):
        plates = [f"plate{n}" for n in out.name.split("-")[1:-1]]
        return SimpleNamespace(
            signals={} if len(plates) == 3 else {p: drive(n, 0.5) for n, p in enumerate(plates)},
            targets={p: (3.0,) * len(WORDS) for p in plates},
            straight={p: drive(n, 1.0) for n, p in enumerate(plates)},
            nearest={p: drive(n, 0.2) for n, p in enumerate(plates)},
            ratings=SimpleNamespace(words=WORDS),
        )


def test_each_rule_selects_from_the_curves_of_clusters_that_groups_share(tmp_path, stand_in):
    made_up = stand_in(MadeUpClusters(), ultrasonic_cgan_selection)
    found = ultrasonic_cgan_selection.run(tmp_path, paper=True, progress=silent, groups="A,B")
    assert made_up.trained == [
        ("plates-01-02-03-0", None, 1, "all"),
        ("plates-01-02-0", {"material": "!plate03"}, 1, "all"),
        ("plates-03-0", {"material": "!plate01|plate02"}, 1, "all"),
    ]
    failed, dip, half = found["clusters"]
    assert (failed["as printed"], failed["ours"]) == (None, None)
    assert (dip["as printed"]["iteration"], dip["ours"]) == (100, None)
    assert dip["lowest_smoothed"] == pytest.approx(0.995)
    assert half["ours"]["iteration"] == 130, "the first whose last 100 are correct in at most 60 %"
    assert found["groups"]["A"] == {
        "published": True,
        "clusters": 1,
        "finished": 1,
        "as printed": 0,
        "ours": 0,
    }
    assert found["groups"]["B"] == {
        "published": True,
        "clusters": 2,
        "finished": 2,
        "as printed": 2,
        "ours": 1,
    }
    assert found["told_by"]["conditions"]["B"]["targets"] == 3
    assert "A" not in found["told_by"]["conditions"]


def test_only_finished_trainings_are_reported_on_request(tmp_path, stand_in):
    made_up = stand_in(MadeUpClusters(), ultrasonic_cgan_selection)
    (tmp_path / "runs" / "plates-03-0").mkdir(parents=True)
    (tmp_path / "runs" / "plates-03-0" / "model.json").touch()
    found = ultrasonic_cgan_selection.run(tmp_path, paper=True, progress=silent, groups="A,B", finished=True)
    assert [name for name, *_ in made_up.trained] == ["plates-03-0"]
    assert [group["finished"] for group in found["groups"].values()] == [0, 1]

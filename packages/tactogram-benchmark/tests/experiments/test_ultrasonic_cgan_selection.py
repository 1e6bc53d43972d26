"""Rules that select an iteration: each from the curves of clusters; nothing is trained here."""

from types import SimpleNamespace

import numpy as np
import pytest
from made_up_signals import PLATES, MadeUpWorkflows, drive

from tactogram.datasets import Ratings, Recording, create_store
from tactogram.datasets.ratings.words import WORDS
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import artifacts, ultrasonic_cgan_figure7, ultrasonic_cgan_selection


@pytest.fixture(autouse=True)
def made_up(stand_in):
    return stand_in(MadeUpWorkflows(), ultrasonic_cgan_figure7, artifacts)


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
    made_up = stand_in(MadeUpClusters(), ultrasonic_cgan_selection, artifacts)
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
    made_up = stand_in(MadeUpClusters(), ultrasonic_cgan_selection, artifacts)
    (tmp_path / "runs" / "plates-03-0").mkdir(parents=True)
    (tmp_path / "runs" / "plates-03-0" / "model.json").touch()
    found = ultrasonic_cgan_selection.run(tmp_path, paper=True, progress=silent, groups="A,B", finished=True)
    assert [name for name, *_ in made_up.trained] == ["plates-03-0"]
    assert [group["finished"] for group in found["groups"].values()] == [0, 1]

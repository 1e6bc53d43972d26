"""Trainings of signal generators that train nothing: made-up workflows."""

from types import SimpleNamespace

import numpy as np

from tactogram.datasets import Ratings, Recording, create_store
from tactogram.datasets.ratings.words import WORDS
from tactogram.signal import Signal
from tactogram_benchmark.experiments.stroke_gan_mixing import END, SEEN

MATERIALS = sorted((*SEEN, END))
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

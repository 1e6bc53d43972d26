"""Trainings of image generators that train nothing: made-up workflows."""

from types import SimpleNamespace

import numpy as np

from tactogram.datasets import Recording, create_store
from tactogram.datasets.ratings.ratings import EVOKED, SEVEN_POINT, Ratings
from tactogram.datasets.ratings.words import WORDS
from tactogram.evaluation.pictures.distances import ImageSpread
from tactogram.model import ImageKind
from tactogram.signal import Image, Signal

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

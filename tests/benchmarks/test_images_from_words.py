"""Images from words: the nearest image that was trained on, other settings, and what is reported."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from benchmarks.experiments import images_from_words
from benchmarks.experiments.images_from_words import NearestImage, with_config

from tactogram.datasets import Recording, create_store
from tactogram.datasets.ratings.ratings import EVOKED, SEVEN_POINT, Ratings
from tactogram.datasets.ratings.words import WORDS
from tactogram.evaluation.pictures.networks import TrunkDistance
from tactogram.signal import Image, Signal
from tactogram.workflows.progress import silent
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train

SMALL = """
model = "texture_flow"
[config]
widths = [8, 8]
embedding = 16
batch_size = 2
steps = 2
solver_steps = 1
"""


def rated(items, scale):
    rng = np.random.default_rng(0)
    rows = [(rater, item, word) for rater in ("ann", "bob") for item in items for word in WORDS]
    scores = rng.integers(scale.low, scale.high + 1, len(rows)).astype(float)
    return Ratings(*(list(column) for column in zip(*rows, strict=True)), scores, scale, words=WORDS)


def image_store(folder, seed):
    rng = np.random.default_rng(seed)
    shown = [(f"i{n}", Image(rng.integers(0, 256, (64, 64, 3), np.uint8))) for n in range(10)]
    ratings = rated([item for item, _ in shown], EVOKED)
    create_store(folder, [], name="i", licence="-", simulated=True, ratings=ratings, photographs=shown)
    return str(folder)


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stores")
    plates = ("plate01", "plate02", "plate03")
    loops = np.random.default_rng(0).standard_normal((3, 2000)).astype(np.float32)
    surfaces = [
        Recording(
            streams={"strain": Signal(loop[None], 1000.0, "1", ("drive",))}, material=name, simulated=True
        )
        for name, loop in zip(plates, loops, strict=True)
    ]
    create_store(
        folder / "plates",
        surfaces,
        name="p",
        licence="-",
        simulated=True,
        ratings=rated(plates, SEVEN_POINT),
    )
    return {
        "images": image_store(folder / "images", 1),
        "unseen": image_store(folder / "unseen", 2),
        "plates": str(folder / "plates"),
    }


def test_the_nearest_image_is_found_in_pixels_and_features():
    trunk = SimpleNamespace(features=lambda images: images.mean((2, 3)).double().numpy())
    known = torch.stack([torch.full((3, 4, 4), value) for value in (-0.5, 0.5)])
    nearest = NearestImage(known.flatten(1).double().numpy(), trunk.features(known), trunk)
    found = nearest(torch.stack([torch.full((3, 4, 4), value) for value in (-0.5, 0.4, 1.0)]))
    np.testing.assert_allclose(found.pixels, [0, 0.1, 0.5], atol=1e-6)
    np.testing.assert_allclose(found.features, np.sqrt(3) * np.array([0, 0.1, 0.5]), atol=1e-6)
    real = nearest(torch.full((1, 3, 4, 4), 0.2))
    assert found.compared_with(real)["nearer_in_pixels"] == pytest.approx(2 / 3)
    assert found.as_dict()["pixels"] == pytest.approx(0.2)


def test_every_training_and_setting_is_reported(tmp_path, stores, monkeypatch):
    # Colours in place of EfficientNet's maps, which take most of the time.
    monkeypatch.setattr(TrunkDistance, "_maps", lambda _, pictures: F.adaptive_avg_pool2d(pictures, 8))
    monkeypatch.setattr(images_from_words, "STEPS", (2,))
    monkeypatch.setattr(images_from_words, "GUIDANCE", (1.5,))
    rater = train("rater", stores["images"], recipe="tiny", out=tmp_path / "rater", accelerator="cpu").folder
    recipe = tmp_path / "small.toml"
    recipe.write_text(SMALL, encoding="utf-8")
    found = images_from_words.run(
        tmp_path / "out",
        paper=False,
        progress=silent,
        rater=str(rater),
        trainings=2,
        recipe=str(recipe),
        **stores,
    )
    assert len(found["runs"]) == 2
    values = [run["following"]["correlation"] for run in found["runs"]]
    assert found["summary"]["correlation"]["mean"] == pytest.approx(np.mean(values))
    assert set(found["settings"]) == {"solver_steps 2", "guidance 1.5"}
    assert found["real"]["nearest"]["pixels"] > 0.5, "noise is far from other noise"
    assert found["simulated"]
    assert str(tmp_path) not in json.dumps(found)
    run = load_run(tmp_path / "out" / "runs" / "0")
    free = with_config(run, guidance=0.0).generator
    one, other = (free.generate({"words": {WORDS[0]: score}}, seed=0).pixels for score in (0.0, 1.0))
    np.testing.assert_array_equal(one, other)
    assert run.config.guidance != 0

"""Vibrations from words: who trains what, and how errors are counted."""

import json

import numpy as np
import pytest
from benchmarks.experiments import words_plates, words_vibviz

from tactogram.datasets import Ratings, Recording, Scale, create_store
from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments.artifacts import trained_run

RATE = 2000.0
SMALL = {
    "texture_flow": {
        "config.steps": 2, "config.widths": [8], "config.embedding": 16, "config.frames": 8,
        "config.window_s": 0.03, "config.solver_steps": 2, "config.iterations": 2,
    },
    "rater": {"config.folds": 2, "config.penalties": [0.1], "config.widths": [0.3]},
}  # fmt: skip


@pytest.fixture
def effects(tmp_path):
    """Simulated: effects of which only the level differs, rated by its logarithm; the last is too short."""
    levels = {f"e{n:02d}": 10 ** (n / 12 - 2) for n in range(19)}
    noise = np.random.default_rng(0).standard_normal((len(levels), 1, 800))
    recordings = [
        Recording(
            streams={
                "vibration": Signal(level * x[:, : 800 if n < 18 else 200], RATE, "1", ("drive",)),
            },
            labels={"item": item},
            source=item,
            simulated=True,
        )
        for n, ((item, level), x) in enumerate(zip(levels.items(), noise, strict=True))
    ]
    scores = np.array([4 * np.log10(level) + 5 for level in levels.values()])
    ratings = Ratings(
        ("mean",) * 19, tuple(levels), ("energy",) * 19, scores, Scale("-3:3", -3.0, 3.0), words=("energy",)
    )
    return create_store(
        tmp_path / "store", recordings, name="made up", licence="-", simulated=True, ratings=ratings
    ).path


def test_no_effect_trains_two_of_generator_rater_and_request(tmp_path, effects, monkeypatch):
    known = {}

    def train(model, store, run, *, where, changes, **options):
        known[run.parent.name, run.name] = set(where["item"].split("|"))
        return trained_run(model, store, run, where=where, changes=changes | SMALL[model], **options)

    monkeypatch.setattr(words_vibviz, "trained_run", train)
    found = words_vibviz.run(tmp_path / "out", paper=False, progress=silent, data=str(effects), drawings=1)
    everything = {f"e{n:02d}" for n in range(18)}
    asked = [everything - known[part, "both"] for part in ("0-0", "0-1", "0-2")]
    assert sorted(item for items in asked for item in items) == sorted(everything)
    for part in ("0-0", "0-1", "0-2"):
        assert not known[part, "generator"] & known[part, "other"]
        assert known[part, "both"] == known[part, "generator"] | known[part, "other"]
    for kinds in found["by"].values():
        assert kinds["itself"]["correlation"]["mean"] > 0.9
        assert kinds["nearest"]["correlation"]["mean"] > 0.9
        assert kinds["generated"]["correlation"]["mean"] > 0.9
    json.dumps(found)


def test_vibviz_is_needed(tmp_path):
    with pytest.raises(ParameterError, match="data must be a store of VibViz"):
        words_vibviz.run(tmp_path, paper=False, progress=silent)


def test_errors_on_plates_are_those_of_all_answers_and_of_clusters():
    """Plate 1 is rated 2 points off, all others exactly."""
    plates = [f"plate{number:02d}" for number in range(1, 13)]
    targets = {plate: np.array([1.0 + number % 5]) for number, plate in enumerate(plates)}
    rows = [
        (rater, f"nearest/{plate}", float(scores[0] + 2 * (plate == "plate01")))
        for plate, scores in targets.items()
        for rater in ("a", "b")
    ]
    raters, items, given = zip(*rows, strict=True)
    said = Ratings(raters, items, ("rough",) * 24, np.array(given), words=("rough",))
    found = words_plates._figures(targets, said, "nearest")
    assert found["error"] == pytest.approx(2 / 12)
    assert found["error_by_cluster"] == {"1": 1.0, "2": 0.0, "3": 0.0, "4": 0.0}

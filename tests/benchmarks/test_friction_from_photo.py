"""Friction from photographs: what is trained on is of other regions than what is judged."""

import json

import numpy as np
import pytest
from benchmarks.experiments import friction_from_photo

from tactogram.datasets import open_store
from tactogram.models.frictgan.tests.test_learner import EXAMPLES, PERIOD_MM, fabric_store, learner
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments.artifacts import trained_run

SHARES = (0.4, 0.25, 0.35)


@pytest.fixture
def fabrics(tmp_path):
    return fabric_store(tmp_path / "fabrics")


def test_windows_that_are_judged_were_not_trained_on(tmp_path, fabrics, monkeypatch):
    def train(model, store, run, *, recipe, changes, **options):
        small = {"config.window_samples": 32, "config.steps": 10, "prepare.stream": "friction"}
        return trained_run(model, store, run, recipe="tiny", changes=small | changes, **options)

    monkeypatch.setattr(friction_from_photo, "trained_run", train)
    monkeypatch.setattr(
        friction_from_photo, "untrained_frictgan", lambda *_: learner(offset=1, shares=SHARES)
    )
    found = friction_from_photo.run(
        tmp_path / "out", paper=False, progress=silent, data=str(fabrics), trainings=1
    )
    known = open_store(tmp_path / "out" / "regions")
    whole = open_store(fabrics)
    for info in known.index:
        [recorded] = [
            whole.signal(other.id, "friction").samples[0]
            for other in whole.index
            if other.material == info.material
            and np.array_equal(known.image(info.id).pixels, whole.image(other.id).pixels[:, :51])
        ]
        # 0.4 of 128 columns and of 12.8 mm at 20 samples per mm; test windows begin at 0.65.
        np.testing.assert_array_equal(known.signal(info.id, "friction").samples[0], recorded[:102])
    assert len(known) == len(EXAMPLES)
    assert set(found["fabrics"]) == set(PERIOD_MM)
    assert found["mean"]["level_error"]["mean"] < 0.05
    assert 0 <= found["named"]["mean"] <= 1
    assert found["simulated"]
    json.dumps(found)

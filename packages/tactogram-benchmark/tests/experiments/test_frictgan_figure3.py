"""Figure 3 of Cai et al. 2020 on tiny networks: each training once, baselines and mixes beside it."""

import json

import numpy as np
import pytest
from frictgan_windows import friction_of, write_window

from tactogram.datasets import open_store
from tactogram.datasets.importing import import_dataset
from tactogram.errors import ParameterError
from tactogram.models.frictgan.tests.test_learner import config, fabric_store
from tactogram.workflows.progress import silent
from tactogram_benchmark.experiments import artifacts, frictgan_figure3 as figure3
from tactogram_benchmark.experiments.artifacts import trained_run


@pytest.fixture
def fabrics(tmp_path):
    return fabric_store(tmp_path / "fabrics")


@pytest.fixture
def asked(monkeypatch):
    """Train tiny networks instead, and return what was asked for."""
    found = []
    small = config(offset=1, shares=(0.4, 0.25, 0.35)).model_dump(exclude_unset=True)
    tiny = {f"config.{key}": value for key, value in small.items()}

    def train(model, store, run, *, recipe, changes, **options):
        found.append((run.name, recipe, options["split"]))
        return trained_run(model, store, run, recipe="tiny", changes={**tiny, **changes}, **options)

    monkeypatch.setattr(artifacts, "trained_run", train)
    monkeypatch.setattr(
        figure3, "geometry_score", lambda one, other, *, seed: float(np.abs(one - other).mean())
    )
    return found


def test_every_method_has_every_measure_and_mixes_lie_between(tmp_path, fabrics, asked):
    """Cai et al. 2020, Sec. 4, Fig. 3; 5: "conduct ablation studies among different generative models"."""
    found = figure3.run(tmp_path / "out", paper=False, progress=silent, data=str(fabrics), trainings=1)
    assert asked == [(f"{name}-0", "quick", "all") for name in ("frictgan", "without-critic", "without-L1")]
    methods = found["methods"]
    assert list(methods) == [
        "frictgan",
        "constant",
        "autoregressive",
        "replay",
        "without critic",
        "without L1",
    ]
    # Recorded windows of the same fabrics: their level and ripple, but not the phase at the place.
    assert methods["replay"]["level_error"]["mean"] < 0.02
    assert methods["replay"]["ripple_ratio"]["mean"] == pytest.approx(1, abs=0.05)
    assert methods["replay"]["mse_recording"]["mean"] > found["reference"]["mse_flat"]
    assert methods["constant"]["ripple_ratio"]["mean"] < 1e-4
    assert methods["constant"]["mse_recording"]["mean"] == pytest.approx(
        found["reference"]["mse_flat"], rel=0.1
    )
    assert methods["autoregressive"]["ripple_ratio"]["mean"] == pytest.approx(1, abs=0.2)
    assert methods["replay"]["geometry_score"]["mean"] < methods["constant"]["geometry_score"]["mean"]
    assert found["fabrics"]["coarse"]["mse"]["mean"] > 0
    assert len(found["mixes"]) == 2
    assert "0.006" in found["text"]
    assert (found["simulated"], found["data"]) == (True, "two fabrics")
    for name in found["figures"]:
        assert (tmp_path / "out" / name).stat().st_size > 10_000
    json.dumps(found)


def test_fabrics_are_those_of_the_store(tmp_path, fabrics, asked):
    for names, message in (
        ("coarse", "at least two of coarse, fine"),
        ("coarse,felt", "some of coarse, fine"),
    ):
        with pytest.raises(ParameterError, match=f"fabrics must be {message}"):
            figure3.run(tmp_path / "out", paper=False, progress=silent, data=str(fabrics), fabrics=names)
    with pytest.raises(ParameterError, match="ablations must be some of without critic, without L1"):
        figure3.run(tmp_path / "out", paper=False, progress=silent, data=str(fabrics), ablations="noise")


def test_the_authors_own_windows_keep_their_parts(tmp_path, asked):
    """Their layout: one window per file, `{train,valid,test}/FABRIC/{image,output_data}`."""
    for part, numbers in (("train", range(6)), ("valid", range(6, 8)), ("test", range(8, 12))):
        for fabric in (2, 8):
            for number in numbers:
                write_window(
                    tmp_path / "dataset" / part / str(fabric), number, friction_of(100 * fabric + number)
                )
    import_dataset("frictgan", tmp_path / "dataset", tmp_path / "s", workers=1)
    found = figure3.run(
        tmp_path / "out", paper=False, progress=silent, data=str(tmp_path / "s"), trainings=1, ablations=""
    )
    learner, trained, tested = figure3._loaded(tmp_path / "out" / "runs" / "frictgan-0")
    assert learner.config.protocol == "examples"
    assert [len(trained), len(tested)] == [16, 8]
    store = open_store(tmp_path / "s")
    assert {store.info(example.id).labels["part"] for example in tested} == {"test"}
    assert {store.info(example.id).labels["part"] for example in trained} == {"train", "valid"}
    assert found["protocol"] == "published parts"
    # What is replayed are windows of the same fabrics from the training part: alike, but none of the tested ones.
    assert found["methods"]["replay"]["mse_recording"]["mean"] > 1e-5
    assert found["methods"]["replay"]["level_error"]["mean"] < 0.02

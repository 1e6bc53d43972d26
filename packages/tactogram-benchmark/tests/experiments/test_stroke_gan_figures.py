"""Figures of recordings beside generated strokes, of trainings on workers."""

import shutil

import numpy as np
import pytest
from made_up_signals import MATERIALS

from tactogram.datasets import Recording, create_store
from tactogram.errors import DataError
from tactogram.signal import Signal
from tactogram_benchmark.experiments import stroke_gan_figures
from tactogram_benchmark.experiments.catalogue import reproduce


def test_figures_show_recordings_beside_what_is_generated(folder, monkeypatch):
    monkeypatch.setattr(stroke_gan_figures, "FIGURES", {"figure-7": ("carpet",)})  # drawing all takes seconds
    found = reproduce(
        "stroke_gan_figures", out=folder, options={"model": "ar_texture", "recipes": "quick,tiny"}
    )
    training = "ar_texture-quick"
    assert set(found["figures"]) == {
        f"ar_texture-{r}-figure-7-{s}" for r in ("quick", "tiny") for s in ("0-1", "dB")
    }
    assert (folder / f"{training}-figure-7-dB.png").is_file()
    distances = found["trainings"][training]["distances_db"]
    assert set(distances) == set(MATERIALS)
    for name, distance in distances.items():
        assert distance < found["ceiling_db"][name]
    nearest = found["trainings"][training]["nearest"]
    assert sum(one == other for one, other in nearest.items()) >= 7  # two are alike
    assert found["header"]["data"][0]["name"] == "made up"
    assert found["simulated"] is True
    assert "simulated" in found["text"].lower()


@pytest.mark.slow
def test_independent_trainings_run_on_workers(folder, monkeypatch):
    monkeypatch.setattr(stroke_gan_figures, "FIGURES", {"figure-7": ("carpet",)})
    options = {"model": "ar_texture", "recipes": "quick,tiny"}
    workers = reproduce("stroke_gan_figures", out=folder, options=options, processes=2)
    for name in ("ar_texture-quick", "ar_texture-tiny"):
        shutil.rmtree(folder / name)
    alone = reproduce("stroke_gan_figures", out=folder, options=options)
    assert alone["trainings"] == workers["trainings"]


def test_too_few_strokes_are_refused_before_any_training(tmp_path):
    noise = np.random.default_rng(0).standard_normal((len(MATERIALS), 7, 3, 400))
    strokes = (
        Recording(
            streams={"acceleration": Signal(x, 1000, "m/s^2")}, material=name, source=f"{name}/{number}"
        )
        for name, takes in zip(MATERIALS, noise, strict=True)
        for number, x in enumerate(takes)
    )
    store = create_store(tmp_path / "few", strokes, name="few", licence="-", simulated=True)
    with pytest.raises(DataError, match="must have 8 strokes of each texture, .* got 7 of one"):
        reproduce(
            "stroke_gan_figures", out=tmp_path / "out", options={"model": "ar_texture"}, data=store.path
        )
    assert not list(tmp_path.glob("out/*ar_texture*"))

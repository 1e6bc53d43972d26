"""Figures of recordings beside generated strokes, of trainings on workers."""

import shutil

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.datasets import Recording, create_store
from tactogram.signal import Signal
from tactogram_benchmark.experiments import stroke_gan_figures
from tactogram_benchmark.experiments.catalogue import reproduce
from tactogram_benchmark.experiments.stroke_gan_mixing import END, SEEN

MATERIALS = sorted((*SEEN, END))


@pytest.fixture
def folder(tmp_path):
    """A folder with strokes of nine made-up textures where the simulated ones would be."""

    def strokes():
        for number in range(8):
            for place, name in enumerate(MATERIALS):
                noise = np.random.default_rng([place, number]).standard_normal((3, 1200))
                # The last two are so alike that nothing can be mixed of them.
                pole, gain = 0.95 - 0.2 * min(place, 7), 1.6 ** min(place, 7)
                yield Recording(
                    streams={"acceleration": Signal(gain * lfilter([1], [1, -pole], noise), 600, "m/s^2")},
                    material=name,
                    source=f"{name}/{number}",
                    simulated=True,
                )

    create_store(tmp_path / "data", strokes(), name="made up", licence="-", simulated=True)
    return tmp_path


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

"""The experiments of the stroking GAN with a model that needs no training, on made-up strokes."""

import json
import shutil

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.datasets import Recording, create_store, open_store
from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.signal import Signal
from tactogram_benchmark.experiments import stroke_gan_figures, stroke_gan_mixing
from tactogram_benchmark.experiments.artifacts import IN_RECORDINGS, materials_of, spread
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


def test_the_textures_are_those_of_the_simulated_set():
    from tactogram.datasets.simulate.materials import STROKING_9

    names = {surface.name for surface in STROKING_9}
    assert set(MATERIALS) == names
    assert {name for three in stroke_gan_figures.FIGURES.values() for name in three} == names
    assert stroke_gan_mixing.ADDED_TO in names


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
def test_tile_is_mixed_with_the_others(folder, monkeypatch):
    seen = {name: SEEN[name] for name in ("cloth", "punched-plastic-sheet")}  # drawing all takes seconds
    for name, value in (("SEEN", seen), ("STEPS", 3), ("SIGNALS", {"bench": 3}), ("SECONDS", 1.0)):
        monkeypatch.setattr(stroke_gan_mixing, name, value)
    options = {"model": "ar_texture", "trainings": 2, "baselines": "replay"}
    found = reproduce("stroke_gan_mixing", out=folder, options=options)
    assert json.loads((folder / "result.json").read_text()) == found
    assert set(found["models"]) == {"ar_texture", "replay"}
    rows = found["models"]["ar_texture"]
    assert len(rows) == 3
    assert "indistinguishable ends" in found["text"]
    alike = rows.pop("punched-plastic-sheet (sum)")
    assert (alike["trainings"], alike["measured"]) == (2, 0)
    assert "the two ends must differ" in alike["refused"][0]
    for row in rows.values():
        assert (row["trainings"], row["measured"]) == (2, 2)
        assert row["weights"] == [0, 0.5, 1]
        assert row["position"]["overall"][0]["mean"] == pytest.approx(0, abs=0.2)
    for pair, row in rows.items():
        if pair.endswith("(sum)"):
            assert row["position"]["overall"][2]["mean"] == pytest.approx(1, abs=0.2)
            assert 0.2 < row["half_weight"]["overall"]["mean"] < 0.8
    assert found["models"]["replay"]["cloth (sum)"]["trainings"] == 1
    assert "simulated strokes" in found["text"]
    made = (folder / "ladders").rglob("ladder.json")
    before = {file: file.stat().st_mtime_ns for file in made}
    assert len(before) == 6
    reproduce("stroke_gan_mixing", out=folder, options=options)
    assert before == {file: file.stat().st_mtime_ns for file in before}  # nothing was made again


def test_an_unknown_option_is_refused_before_anything_is_made(tmp_path):
    with pytest.raises(ParameterError, match="option of .* must be one of data, model, .* got 'seed'"):
        reproduce("stroke_gan_figures", out=tmp_path / "x", options={"seed": 1})
    assert not (tmp_path / "x").exists()


def test_what_is_not_known_is_not_averaged():
    found = spread([0.2, None, 0.4])
    assert found["mean"] == pytest.approx(0.3)
    assert (found["known"], found["values"]) == (2, [0.2, None, 0.4])
    assert spread([None]) == {"mean": None, "sd": None, "known": 0, "values": [None]}


def test_the_nine_textures_are_found_by_the_names_of_the_recordings(tmp_path):
    def strokes(names):
        for place, name in enumerate(names):
            signal = Signal(np.full((3, 10), place), 1000, "m/s^2")
            yield Recording(streams={"acceleration": signal}, material=name, source=name, simulated=True)

    def store(names, place):
        create_store(tmp_path / place, strokes(names), name="s", licence="-", simulated=True)
        return open_store(tmp_path / place)

    names = sorted(IN_RECORDINGS.values())
    assert materials_of(store(names, "all")) == IN_RECORDINGS
    with pytest.raises(DataError, match="found none called tile or GreenTile"):
        materials_of(store([name for name in names if name != "GreenTile"], "some"))


@pytest.mark.slow
def test_independent_trainings_run_on_workers(folder, monkeypatch):
    monkeypatch.setattr(stroke_gan_figures, "FIGURES", {"figure-7": ("carpet",)})
    options = {"model": "ar_texture", "recipes": "quick,tiny"}
    workers = reproduce("stroke_gan_figures", out=folder, options=options, processes=2)
    for name in ("ar_texture-quick", "ar_texture-tiny"):
        shutil.rmtree(folder / name)
    alone = reproduce("stroke_gan_figures", out=folder, options=options)
    assert alone["trainings"] == workers["trainings"]


def test_an_experiment_without_independent_trainings_refuses_workers(folder):
    with pytest.raises(ParameterError, match="cross_modal has no independent trainings for workers"):
        reproduce("cross_modal", out=folder, on="ray")


def test_failed_trainings_are_named_after_the_others_have_finished(folder):
    options = {"model": "ar_texture", "recipes": "tiny,none"}
    with pytest.raises(
        TactogramError, match="1 of 2 trainings failed; ar_texture-none: recipe of ar_texture must be"
    ):
        reproduce("stroke_gan_figures", out=folder, options=options, processes=1)
    assert (folder / "ar_texture-tiny" / "model.json").is_file()

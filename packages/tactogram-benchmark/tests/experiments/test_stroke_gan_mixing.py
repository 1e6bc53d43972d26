"""The experiments of the stroking GAN with a model that needs no training, on made-up strokes."""

import json

import pytest
from made_up_signals import MATERIALS

from tactogram.errors import ParameterError, TactogramError
from tactogram_benchmark.experiments import stroke_gan_figures, stroke_gan_mixing
from tactogram_benchmark.experiments.catalogue import reproduce
from tactogram_benchmark.experiments.stroke_gan_mixing import SEEN


def test_the_textures_are_those_of_the_simulated_set():
    """Saga et al., Sec. III-B: "nine types of textures", Figs. 7 to 9."""
    from tactogram_simulate.materials import STROKING_9

    names = {surface.name for surface in STROKING_9}
    assert set(MATERIALS) == names
    assert {name for three in stroke_gan_figures.FIGURES.values() for name in three} == names
    assert stroke_gan_mixing.ADDED_TO in names


def test_pairs_and_what_was_seen_are_those_of_the_paper():
    """Sec. V: Tile's feature appears "over 0.4 in all the results except the “Cloth” and “Carpet” results"."""
    assert (stroke_gan_mixing.END, stroke_gan_mixing.ADDED_TO) == ("tile", "luncheon-mat-03")
    assert set(SEEN) == set(MATERIALS) - {"tile"}
    late = {name for name, seen in SEEN.items() if "over 0.4" not in seen}
    assert late == {"cloth", "carpet"}


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

"""Loaded runs: the trained model again, or refused in one line."""

import shutil

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.errors import RunError
from tactogram.workflows.recognition.search import search
from tactogram.workflows.training.hub_folder import export_run, import_run
from tactogram.workflows.training.loaded_run import load_run


@pytest.mark.parametrize(
    "name", ["search-vectors.npy", "search-whitening.npy", "model.safetensors", "model.json", "data.json"]
)
def test_a_broken_run_is_refused_in_one_line(run, store, texture, tmp_path, name):
    export_run(run.folder, tmp_path / "run.zip")
    import_run(tmp_path / "run.zip", tmp_path / "run")
    (tmp_path / "run" / name).write_bytes(b"[1, 2]")
    with pytest.raises(RunError, match=name) as raised:
        search(tmp_path / "run", texture("foam", 1), data=store)
    assert "\n" not in str(raised.value)


def test_weights_of_another_network_are_refused(run, tmp_path):
    export_run(run.folder, tmp_path / "run.zip")
    import_run(tmp_path / "run.zip", tmp_path / "run")
    recipe = tmp_path / "run" / "recipe.toml"
    recipe.write_text(recipe.read_text().replace("window = 32", "window = 48"))
    with pytest.raises(RunError, match="weights do not fit the recipe"):
        load_run(tmp_path / "run")


def test_a_loaded_run_says_what_the_trained_one_said(run, texture):
    one, two = load_run(run.folder), load_run(run.folder)
    prepared = one.prepare(texture("cork", 99))
    np.testing.assert_array_equal(one.model.probabilities(prepared), two.model.probabilities(prepared))


def test_a_folder_comes_before_the_model_of_its_name(tmp_path, monkeypatch):
    assert len(load_run("texture_flow").kind.materials) == 84
    monkeypatch.chdir(tmp_path)
    (tmp_path / "texture_flow").mkdir()
    with pytest.raises(RunError, match="not a run"):
        load_run("texture_flow")


@pytest.mark.parametrize(
    ("model", "gone"),
    [
        ("ultrasonic_cgan", "discriminator"),
        ("ultrasonic_cgan", "fakes_scored_as"),
        ("tactile_image_cgan", "label_input"),
        ("tactile_image_cgan", "regression_weight"),
        ("tactile_image_cgan", "fake_scores"),
    ],
)
def test_a_run_with_an_option_that_its_model_no_longer_has_says_what_to_do(
    run, model, gone, tmp_path, capsys
):
    old = tmp_path / "old"
    shutil.copytree(run.folder, old)
    recipe = (old / "recipe.toml").read_text().partition("[config]")[0].replace("stroke_cnn", model)
    (old / "recipe.toml").write_text(f'{recipe}[config]\n{gone} = "x"\n')
    assert main(["generate", str(old), "--words", "rough=6", "--out", str(tmp_path / "made")]) == 1
    said = f"{old}: config of {model}: unknown key '{gone}'; train it again, or use the tactogram that trained it"
    assert capsys.readouterr().err == f"tactogram: {said}\n"
    assert not (tmp_path / "made").exists()

"""From a photograph to a signal through the jobs: train, judge, generate; surfaces that were never touched too."""

import json
import shutil
from functools import partial

import numpy as np
import pytest
import torch
from scipy.ndimage import gaussian_filter
from scipy.signal import lfilter

from tactogram.cli import main
from tactogram.datasets import Recording, Split, create_store
from tactogram.datasets.store.photographs import photograph_of
from tactogram.errors import LeakError, ParameterError, RunError
from tactogram.features.photo_descriptor import UNLIKE
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_metadata, read_signal, write_signal
from tactogram.signal.resampling import resample
from tactogram.training.run import Run
from tactogram.workflows.evaluation import generator
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.evaluation.pictures import evaluate_pictures, evaluate_run_pictures
from tactogram.workflows.evaluation.run_evaluation import evaluate_run
from tactogram.workflows.generation.generate import generate_files
from tactogram.workflows.training.known_photographs import FILE
from tactogram.workflows.training.plan import plan_of
from tactogram.workflows.training.train import train

RATE = 1000.0
LOOKS = {"cork": (4.0, 0.3), "felt": (1.0, 0.3), "slate": (1.0, 0.8), "tile": (4.0, 0.8)}
"""Simulated: coarseness in pixels, and brightness."""
TOUCHES = {"cork": [1, -1.6, 0.9], "felt": [1, -0.9], "slate": [1, 0.9], "tile": [1, 0.3, 0.8]}
HASTY = {"steps": 4, "most": 2}


def photograph(material, seed, size=64):
    grain, bright = LOOKS[material]
    noise = gaussian_filter(np.random.default_rng(seed).standard_normal((size, size)), grain)
    grey = np.clip(bright + 0.08 * noise / noise.std(), 0, 1)
    return Image(np.uint8(255 * np.repeat(grey[..., None], 3, axis=2)))


def recording(material, seed):
    noise = np.random.default_rng(seed).standard_normal(3000)
    x = lfilter([1], TOUCHES[material], noise)
    return Recording(
        streams={"acceleration": Signal(0.2 * x / x.std(), RATE, "m/s^2", ("z",))},
        material=material,
        simulated=True,
    )


def made_store(folder, first=0, recordings=8, photographs=10):
    return create_store(
        folder,
        [
            recording(name, first + 100 * k + seed)
            for k, name in enumerate(LOOKS)
            for seed in range(recordings)
        ],
        name="looks",
        licence="none",
        simulated=True,
        photographs=[(name, photograph(name, first + k)) for name in LOOKS for k in range(photographs)],
    ).path


@pytest.fixture(scope="module")
def looks(tmp_path_factory):
    return made_store(tmp_path_factory.mktemp("looks") / "store")


def trained(looks, out, **options):
    return train("nearest_photo", looks, recipe="tiny", out=out, accelerator="cpu", **options)


@pytest.fixture(scope="module")
def run(looks, tmp_path_factory):
    return trained(looks, tmp_path_factory.mktemp("runs") / "run")


def test_photographs_are_split_and_written_down(run):
    assert plan_of(run).identity == run.data["run_id"]  # it can go on by its folder alone
    split = Split.load(run.folder / "split.json")
    assert {part: len(held) for part, held in split.photographs.items()} == {
        "train": 32,
        "validation": 4,
        "test": 4,
    }
    assert "held out whole" in run.data["photographs"]["note"]


def test_is_judged_with_photographs_it_never_saw_beside_three_baselines(run):
    found, _ = evaluate_run(run.folder, evaluation=HASTY)
    assert set(found["measures"]["log_spectral_distance_db"]) == {
        "model",
        "floor",
        "ceiling",
        "nearest_other",
        "ar_texture",
        "replay",
        "nearest_photo",
    }
    spectra = found["measures"]["log_spectral_distance_db"]
    assert spectra["model"] == spectra["nearest_photo"] < (spectra["floor"] + spectra["ceiling"]) / 2
    assert "photographs were held out whole" in found["data"]["split"]


def test_a_surface_never_touched_has_its_floor_in_its_own_recordings(looks, tmp_path):
    by_material = trained(looks, tmp_path / "run", by="material")
    found, _ = evaluate_run(by_material.folder, evaluation=HASTY)
    assert any(note.startswith("Not trained on: ") for note in found["notes"])
    assert any(note.startswith("replay does not know every material") for note in found["notes"])
    (material,) = found["per_material"]
    row = found["per_material"][material]["log_spectral_distance_db"]
    assert row["floor"] < 3 < row["model"]
    assert "recognised_accuracy" not in found["measures"]
    assert "memorised_share" not in found["measures"]


def test_other_data_is_judged_unless_a_photograph_of_it_was_trained_on(run, tmp_path):
    fresh = made_store(tmp_path / "fresh", first=1000, recordings=2, photographs=2)
    found, _ = evaluate_run(run.folder, data=fresh, evaluation=HASTY)
    assert found["data"]["split"] == "all 8 recordings"
    mixed = create_store(
        tmp_path / "mixed",
        [recording("cork", 5000 + seed) for seed in range(2)],
        name="mixed",
        licence="none",
        photographs=[("cork", photograph("cork", k)) for k in range(10)],
    )
    with pytest.raises(LeakError, match="of its 10 photographs were trained on"):
        evaluate_run(run.folder, data=mixed.path, evaluation=HASTY)


def test_a_picture_file_becomes_a_signal_file(run, tmp_path):
    (tmp_path / "photo.png").write_bytes(photograph_of(photograph("tile", 77)).data)
    (row,) = generate_files(
        run.folder, {}, tmp_path / "x.wav", seconds=1.5, seed=1, options={"image": tmp_path / "photo.png"}
    )
    assert row["classified_as"] == "tile"
    assert (row["seconds"], row["unit"], row["simulated"]) == (1.5, "m/s^2", True)
    file = read_signal(tmp_path / "x.wav")
    assert (file.seconds, file.unit) == (1.5, "m/s^2")


@pytest.mark.parametrize(("of", "unlike"), [("tile", False), ("checkerboard", True)])
def test_a_photograph_unlike_all_training_photographs_is_reported(of, unlike, run, tmp_path, capsys):
    y, x = np.mgrid[:64, :64]
    board = Image(np.repeat(255 * ((x // 8 + y // 8) % 2)[..., None], 3, axis=2).astype(np.uint8))
    picture = board if unlike else photograph(of, 77)
    (tmp_path / "photo.png").write_bytes(photograph_of(picture).data)
    asked = ["generate", str(run.folder), "--image", str(tmp_path / "photo.png"), "--seconds", "1"]
    assert main([*asked, "--out", str(tmp_path / "x.wav")]) == 0
    printed = capsys.readouterr().out
    if unlike:
        assert "photograph unlike anything the run was trained on: it is farther" in printed
        assert "100 % of these are from one of another material; classified as" in printed
    else:
        assert "photograph classified as tile\n" in printed
    assert (read_metadata(tmp_path / "x.wav")["novelty"] >= UNLIKE) == unlike


def test_a_damaged_description_of_photographs_is_one_line(run, tmp_path):
    shutil.copytree(run.folder, tmp_path / "run")
    (tmp_path / "run" / FILE).write_text('{"materials": ["a"]}')
    (tmp_path / "photo.png").write_bytes(photograph_of(photograph("tile", 77)).data)
    with pytest.raises(RunError, match=r"photographs.json: lacks or misspells 'descriptors'"):
        generate_files(tmp_path / "run", {}, tmp_path / "x.wav", options={"image": tmp_path / "photo.png"})


def test_what_cannot_be_asked_says_so(run, looks, tmp_path):
    with pytest.raises(ParameterError, match="condition 'image' is needed"):
        generate_files(run.folder, {"material": "cork"}, tmp_path / "x.wav")
    bare = create_store(
        tmp_path / "bare", [recording("cork", seed) for seed in range(8)], name="bare", licence="none"
    )
    with pytest.raises(ParameterError, match="each material must have a photograph, got none of cork"):
        trained(bare.path, tmp_path / "nothing")
    assert not (tmp_path / "nothing").exists()
    assert json.loads((run.folder / "data.json").read_text())["photographs"]["train"] == 32


def test_pictures_are_judged_beside_signals_and_the_loss_is_divided(looks, run, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "tactogram.workflows.evaluation.run_evaluation.evaluate_run_pictures",
        partial(evaluate_run_pictures, most=8),
    )
    longer = {"config.pairs.hop": 16, "config.pairs.frames": 32}  # half a second
    sight = train(
        "visual_tactile_gan", looks, recipe="tiny", changes=longer, out=tmp_path / "run", accelerator="cpu"
    )
    found = evaluate(sight.folder, evaluation=HASTY)
    pictures = found["pictures"]
    assert {"l1", "log_spectral_distance_db", "level_difference_db"} <= set(pictures["values"])
    assert set(pictures["missing"]) <= {
        "lpips",
        "fid",
        "efficientnet_lite0_distance",
        "efficientnet_lite0_frechet_distance",
        "psnr_db",
        "ssim",
    }
    assert set(pictures["per_material"]) == set(LOOKS)
    assert 0 <= pictures["label_accuracy"] <= 1
    loss = pictures["inversion"]["level_difference_db"]
    assert loss["network"] == pytest.approx(loss["total"] - loss["inversion"])
    assert loss["inversion"] < loss["total"]
    page = (sight.folder / "report.html").read_text()
    assert "From pictures back to vibration" in page
    with pytest.raises(ParameterError, match="nearest_photo makes no spectrogram pictures"):
        evaluate_pictures(run.folder)


def test_a_training_without_the_weights_of_lpips_says_what_it_chooses_by(
    looks, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(torch.hub, "get_dir", lambda: str(tmp_path))
    asked = ["train", "pix2pix", "--data", str(looks), "--recipe", "tiny", "--out", str(tmp_path / "run")]
    assert main([*asked, "--accelerator", "cpu", "--set", "config.choose_by=lpips"]) == 0
    printed = capsys.readouterr()
    (note,) = Run.open(tmp_path / "run").facts()["notes"]
    assert note.startswith("weights are chosen by row_statistics in place of LPIPS")
    assert f"note: {note}" in printed.out
    assert f"choose weights: 1/1 {note}" in printed.err


def test_crops_of_the_recordings_trained_on_have_no_floor(looks, tmp_path):
    changes = {"config.pairs.hop": 16, "config.pairs.frames": 32, "config.pairs.protocol": "crop-split"}
    sight = train(
        "visual_tactile_gan",
        looks,
        recipe="tiny",
        changes=changes,
        split="all",
        out=tmp_path / "run",
        accelerator="cpu",
    )
    losses = evaluate_pictures(sight.folder, most=4)["inversion"]
    assert losses
    assert {loss["floor"] for loss in losses.values()} == {None}


@pytest.fixture(scope="module")
def described(looks, tmp_path_factory):
    """A run that is given a material, a photograph or a recording."""
    out = tmp_path_factory.mktemp("runs") / "described"
    return train("texture_flow", looks, recipe="tiny", out=out, accelerator="cpu")


@pytest.mark.parametrize(("given", "baseline"), [("image", True), ("vibration", False), ("material", False)])
def test_a_run_is_judged_by_each_description_it_takes(described, given, baseline):
    found, _ = evaluate_run(described.folder, given=given, evaluation=HASTY)
    spectra = found["measures"]["log_spectral_distance_db"]
    assert ("nearest_photo" in spectra) == baseline
    assert spectra["model"] < spectra["ceiling"] - 2  # spectra are closed forms: the network hardly trained


def test_a_description_that_it_does_not_take_is_refused_before_anything_is_trained(
    described, run, monkeypatch
):
    monkeypatch.setattr(generator, "classifier_of", None)
    with pytest.raises(
        ParameterError, match="texture_flow is given material, image, vibration, words, got 'speed"
    ):
        evaluate_run(described.folder, given="speed_mm_s")
    with pytest.raises(ParameterError, match="needs ratings, and there are none of"):
        evaluate_run(described.folder, given="words")
    with pytest.raises(ParameterError, match="nearest_photo is given image, got 'material'"):
        evaluate_run(run.folder, given="material")


def test_a_surface_never_touched_is_described_by_one_recording_or_photograph(looks, tmp_path):
    out = train("texture_flow", looks, recipe="tiny", by="material", out=tmp_path / "run", accelerator="cpu")
    spectra = {}
    for given in ("vibration", "image"):
        found, _ = evaluate_run(out.folder, given=given, evaluation=HASTY)
        (material,) = found["per_material"]
        spectra[given] = found["per_material"][material]["log_spectral_distance_db"]["model"]
    assert spectra["vibration"] < 3 < spectra["image"]


def test_a_picture_or_recording_file_describes_the_surface(described, tmp_path, capsys):
    (tmp_path / "photo.png").write_bytes(photograph_of(photograph("tile", 77)).data)
    made = [str(described.folder), "--seconds", "1", "--seed", "3"]
    assert not main(
        ["generate", *made, "--image", str(tmp_path / "photo.png"), "--out", str(tmp_path / "a.wav")]
    )
    assert "photograph classified as tile, confidence" in capsys.readouterr().out
    stroke = recording("felt", 99).streams["acceleration"]
    write_signal(tmp_path / "felt.csv", resample(stroke, 2000.0))
    assert not main(
        ["generate", *made, "--vibration", str(tmp_path / "felt.csv"), "--out", str(tmp_path / "b.wav")]
    )
    found = read_signal(tmp_path / "b.wav")
    assert (found.rate, found.unit) == (RATE, "m/s^2")
    assert np.std(found.samples) == pytest.approx(np.std(stroke.samples), rel=0.3)
    assert read_metadata(tmp_path / "b.wav")["vibration_from"] == "felt.csv"
    main(
        [
            "generate",
            *made,
            "--material",
            "tile",
            "--image",
            str(tmp_path / "photo.png"),
            "--out",
            str(tmp_path / "c.wav"),
        ]
    )
    assert "material and image describe the surface twice" in capsys.readouterr().err
    assert not (tmp_path / "c.wav").exists()

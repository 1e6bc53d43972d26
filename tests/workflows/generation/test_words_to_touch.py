"""Words to an image and a vibration: what is asked, filled, refused and written."""

import json

import numpy as np
import pytest
from made_up_runs import WORDS, pictures, rater, vibrations

from tactogram.cli import main
from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_image, read_image_metadata, read_metadata, read_signal, write_signal
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.evaluation.mixing_ladder import mixing_ladder
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.generation.word_scores import ask
from tactogram.workflows.generation.words_to_touch import generate_from_words
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train


def test_a_pair_comes_from_the_same_scores_by_seed(tmp_path):
    runs = [vibrations(), pictures()]
    made = generate_from_words(runs, tmp_path / "pair", words={"rough": 6}, rest="mean", seed=3)
    note = json.loads((tmp_path / "pair" / "scores.json").read_text())
    assert note == made["scores"][0]
    assert note["asked"] == {"rough": 6.0}
    assert note["filled"] == {"sleek": 1.0, "sticky": 4.0}
    assert note["simulated"] is True
    assert note["made"]["vibration"]["taken"] == {"cluster": 2, "plate": "plate01"}
    assert note["made"]["vibration"]["scores"] == note["scores"]
    assert note["made"]["image"]["scores"] == pytest.approx(
        {"rough": 5 / 6, "sleek": 0, "sticky": 0.5}, abs=1e-4
    )
    (again,) = generate(pictures(), {"words": note["made"]["image"]["scores"]}, seed=3)
    np.testing.assert_array_equal(read_image(tmp_path / "pair" / "image.png").pixels, again.pixels)
    facts = read_image_metadata(tmp_path / "pair" / "image.png")
    assert (facts["simulated"], facts["seed"], facts["run"], facts["asked"]) == (
        True,
        3,
        "sight-id",
        {"rough": 6.0},
    )
    assert read_metadata(tmp_path / "pair" / "vibration.wav")["taken"]["plate"] == "plate01"
    other = generate_from_words(runs, tmp_path / "other", words={"rough": 6}, rest="mean", seed=4)
    assert other["scores"][0]["scores"] == note["scores"]
    assert (tmp_path / "other" / "image.png").read_bytes() != (tmp_path / "pair" / "image.png").read_bytes()


def test_several_are_numbered_and_differ(tmp_path):
    made = generate_from_words([pictures()], tmp_path, words={"rough": 6}, rest="mean", count=2)
    assert sorted(f.name for f in tmp_path.iterdir()) == [
        "image-1.png", "image-2.png", "scores-1.json", "scores-2.json"
    ]  # fmt: skip
    one, two = (read_image(row["file"]).pixels for row in made["files"])
    assert not np.array_equal(one, two)


def test_a_recording_goes_to_the_run_that_starts_from_one(tmp_path):
    write_signal(tmp_path / "sensor.wav", Signal(np.ones(50, np.float32), 100.0, "V"))
    touch, sight = vibrations(), pictures()
    made = generate_from_words(
        [touch, sight], tmp_path / "pair", rest="mean", vibration=tmp_path / "sensor.wav"
    )
    assert touch.model.asked[0]["vibration"].unit == "V"
    assert "vibration" not in sight.model.asked[0]
    assert made["scores"][0]["vibration_from"] == "sensor.wav"
    with pytest.raises(ParameterError, match="vibration must be omitted: no run starts from one"):
        generate_from_words([sight], tmp_path / "x", rest="mean", vibration=tmp_path / "sensor.wav")


def test_a_rater_scores_what_it_knows(tmp_path):
    made = generate_from_words([vibrations(), pictures()], tmp_path / "pair", rest="mean", raters=[rater()])
    said = made["scores"][0]["predicted"]
    assert list(said) == ["vibration"]
    assert said["vibration"]["by"] == "a rater model of simulated raters"
    assert said["vibration"]["scores"] == dict.fromkeys(WORDS, 6.0)
    with pytest.raises(ParameterError, match="raters can score none of the results: judge"):
        generate_from_words([pictures()], tmp_path / "x", rest="mean", raters=[rater()])
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    ("runs", "out", "message"),
    [
        (
            [pictures(), pictures()],
            "pair",
            "runs must give one image and one vibration, got 'image and image'",
        ),
        ([pictures(), vibrations()], "pair.png", "out must be a folder for 2 runs"),
        ([pictures()], "x.wav", "out for images must be a folder or end in .png"),
        ([vibrations()], "x.png", "out for signals must be a folder or end in .wav"),
        ([pictures(), vibrations(("rough", "dry"))], "pair", "runs must be of the same words: sight has"),
        ([rater()], "pair", "judge: judge_model is not conditioned on words"),
    ],
)
def test_what_makes_no_pair_is_refused_and_nothing_written(tmp_path, runs, out, message):
    with pytest.raises(ParameterError, match=message):
        generate_from_words(runs, tmp_path / out, rest="mean")
    assert not any(tmp_path.iterdir())


@pytest.fixture(scope="module")
def flow_run(image_run):
    store = load_run(image_run).run.data["path"]
    return train(
        "texture_flow", store, recipe="tiny", out=image_run.parent / "flow", accelerator="cpu"
    ).folder  # fmt: skip


def test_words_that_no_run_needs_stay_open(flow_run, image_run, tmp_path, capsys):
    out = str(tmp_path / "x.png")
    assert main(["generate", str(flow_run), "--words", "rough=6", "--seed", "1", "--out", out]) == 0
    assert "filled" not in capsys.readouterr().out
    assert read_image(out).size == (16, 16)
    flow = load_run(flow_run)
    [same] = generate(flow, {"words": {"rough": 5 / 6}}, seed=1)  # 6 of 1 to 7, on the scale of yes and no
    np.testing.assert_array_equal(read_image(out).pixels, same.pixels)
    asked = ask([flow, vibrations()], {"rough": 6, "sleek": 1, "sticky": 1})
    assert asked.on_scale_of(flow) == pytest.approx({"rough": 5 / 6, "sleek": 0, "sticky": 0})
    assert ask([flow], {"rough": 6}).on_scale_of(flow) == pytest.approx({"rough": 5 / 6})
    with pytest.raises(ParameterError, match="scores are missing for sleek, sticky"):
        ask([flow, load_run(image_run)], {"rough": 6})


def test_a_run_of_images_has_the_facts_of_its_data(flow_run, image_rater):
    assert load_run(flow_run).facts.gives == "image"
    assert load_run("texture_flow").facts.gives == "signal"
    found = evaluate(flow_run, rater=image_rater)
    assert found["spread"]["noise_share"] > 0
    assert "correlation" in found["following"]
    with pytest.raises(ParameterError, match="mixes are of materials; texture_flow is conditioned on words"):
        mixing_ladder(flow_run, "a", "b", out=flow_run.parent / "ladder")


def test_the_command_gives_an_image_and_says_what_it_filled(image_run, tmp_path, capsys):
    out = str(tmp_path / "x.png")
    assert (
        main(
            ["generate", str(image_run), "--words", "rough=6", "--rest", "mean", "--seed", "1", "--out", out]
        )
        == 0
    )
    said = capsys.readouterr().out
    assert "requested: rough 6" in said
    assert "filled with the mean over the 5 rated items of run (simulated raters): " in said
    assert "trained on simulated data" in said
    assert read_image(out).size == (16, 16)
    assert read_image_metadata(out)["scores"]["rough"] == 6.0
    assert main(["generate", str(image_run), "--words", "rough=6", "--out", out]) == 1
    assert "scores are missing for sleek, sticky" in capsys.readouterr().err
    assert main(["generate", str(image_run), "--rest", "mean", "--speed", "10", "--out", out]) == 1
    assert "--speed is not for models conditioned on words" in capsys.readouterr().err


def test_python_takes_words_on_the_scale_of_the_run(image_run):
    loaded = load_run(image_run)
    (image,) = generate(loaded, {"words": {"rough": 1.0, "sleek": 0.0, "sticky": 0.5}}, seed=2)
    assert isinstance(image, Image)
    with pytest.raises(ParameterError, match="rough must be 0 to 1, got 6"):
        next(generate(loaded, {"words": {"rough": 6.0, "sleek": 0.0, "sticky": 0.5}}))


def test_signals_come_back_as_they_were_made(tmp_path):
    touch = vibrations()
    generate_from_words([touch], tmp_path / "x.wav", words={"rough": 6}, rest="mean", seed=5)
    (signal,) = generate(touch, {"words": touch.model.asked[0]["words"]}, seed=5)
    np.testing.assert_array_equal(read_signal(tmp_path / "x.wav").samples, signal.samples)


@pytest.mark.parametrize("out", ["x.jpg", "x.mp3", "file", "file/pair"])
def test_no_folder_is_made_of_what_looks_like_a_file(tmp_path, out):
    (tmp_path / "file").write_text("taken")
    with pytest.raises(ParameterError, match=r"out must be a folder, or a file that ends in \.png; got"):
        generate_from_words([pictures()], tmp_path / out, rest="mean")
    assert [place.name for place in tmp_path.iterdir()] == ["file"]


def test_a_length_is_not_for_images_alone(tmp_path):
    with pytest.raises(ParameterError, match="seconds is for signals"):
        generate_from_words([pictures()], tmp_path / "x", rest="mean", seconds=2.0)
    generate_from_words([vibrations(), pictures()], tmp_path / "pair", rest="mean", seconds=2.0)

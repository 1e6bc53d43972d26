import json
import os
import re
import shutil
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import tactogram.workflows.evaluation.classifier_crossval as crossval_module
from tactogram.cli import main
from tactogram.datasets import Split, add_recordings, create_store, open_store
from tactogram.datasets.store.pending import part_folder
from tactogram.errors import LeakError, ParameterError, RunError, StoppedError
from tactogram.signal.io import read_metadata, read_signal, write_signal
from tactogram.training import load_state
from tactogram.training.loop import run_training
from tactogram.workflows.data.stores import add_signal
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.generation.generate import generate, generate_files
from tactogram.workflows.recognition.classify import classify
from tactogram.workflows.recognition.search import search
from tactogram.workflows.training.execution import resume
from tactogram.workflows.training.hub_folder import export_run, import_run
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.plan import select
from tactogram.workflows.training.train import train


def test_a_run_holds_what_made_it(run, store, tiny):
    assert run.recipe.model == "stroke_cnn"
    assert run.data["simulated"] is True
    assert run.kind().materials == ("cork", "foam", "tile")
    assert run.facts()["validation"]["recording_accuracy"] > 0.6
    split = Split.load(run.folder / "split.json")
    assert not {s.id for s in split.train} & {s.id for s in split.test}
    steps = [(m["stage"], m["step"]) for m in run.metrics()]
    assert steps == sorted(set(steps))
    assert steps[-1] == (1, tiny["config.steps"])


def test_a_training_that_was_asked_to_stop_goes_on_to_the_same_weights(run, store, tmp_path, tiny):
    """Every step that was done is kept, whatever ``checkpoint_every``, and the logs are those of one training."""
    asked = iter(range(1000))
    known = {"recipe": "tiny", "changes": tiny, "where": {"material": "!wool"}, "accelerator": "cpu"}
    out = tmp_path / "stopped"
    with pytest.raises(StoppedError, match=r"prepared; the run is as it was"):
        train("stroke_cnn", store, **known, out=out, stop=lambda: True)
    assert not out.exists()
    prepared = len(Split.load(run.folder / "split.json").train)
    with pytest.raises(StoppedError, match=r"after step 37 of 60 of classify; all of it is in .* --resume"):
        train("stroke_cnn", store, **known, out=out, stop=lambda: next(asked) == prepared + 37)
    assert load_state(out / "checkpoint.safetensors")[1] == {"stage": 1, "step": 37}
    resume(out, accelerator="cpu")  # recordings, class and split are in the run
    for name in ("model.safetensors", "metrics.jsonl"):
        assert (out / name).read_bytes() == (run.folder / name).read_bytes()


def test_a_loaded_run_says_what_the_trained_one_said(run, texture):
    one, two = load_run(run.folder), load_run(run.folder)
    prepared = one.prepare(texture("cork", 99))
    np.testing.assert_array_equal(one.model.probabilities(prepared), two.model.probabilities(prepared))


def test_it_names_and_finds_what_it_was_trained_on(run, texture):
    for material in ("cork", "foam", "tile"):
        said = classify(run.folder, texture(material, 77))
        assert said["material"] == material
        assert sum(said["probabilities"].values()) == pytest.approx(1)
        assert search(run.folder, texture(material, 77))["nearest"][0]["material"] == material


def test_evaluation_names_split_and_floor(run):
    figures = evaluate(run.folder, unknown=True)
    assert figures["recording_accuracy"] >= 0.8
    assert figures["recordings"] == 6
    assert figures["none_of_these"]["unknown"] == 10
    assert figures["none_of_these"]["unknown_materials"] == ["wool"]
    assert 0 <= figures["none_of_these"]["auroc"] <= 1
    assert figures["data"]["simulated"] is True
    page = (run.folder / "report.html").read_text()
    assert "Simulated data" in page
    assert json.loads((run.folder / "evaluation.json").read_text()) == figures


def test_other_data_is_matched_by_name_and_what_was_trained_on_is_refused(run, store, tmp_path, recordings):
    create_store(
        tmp_path / "new", recordings(("tile", "cork"), 2, first=50), name="new", licence="-", simulated=True
    )
    figures = evaluate(run.folder, data=tmp_path / "new")
    assert figures["recordings"] == 4
    with pytest.raises(LeakError, match="of its 40 recordings were trained on"):
        evaluate(run.folder, data=store)


def test_search_in_another_store(run, store, texture):
    found = search(run.folder, texture("wool", 5), data=store, count=3)
    assert found["nearest"][0]["material"] == "wool"
    assert len(found["nearest"]) == 3
    again = search(run.folder, texture("wool", 5), data=store, count=3)
    assert again == found


def test_folds_are_by_recording_and_cover_everything(store, tmp_path, tiny):
    options = {"folds": 2, "recipe": "tiny", "changes": tiny, "accelerator": "cpu"}
    figures = crossval("stroke_cnn", store, out=tmp_path / "cv", processes=1, **options)
    assert figures["recordings"] == 40
    assert figures["split"] == "2 folds by recording"
    assert len(figures["per_fold"]) == 2
    assert figures["recording_accuracy"] > 0.7
    assert {f.name for f in (tmp_path / "cv").iterdir()} == {"crossval.json", "confusion.png", "report.html"}


def test_a_cross_validation_that_was_stopped_goes_on_after_its_finished_folds(
    store, tmp_path, tiny, monkeypatch
):
    options = {"folds": 3, "recipe": "tiny", "changes": tiny, "accelerator": "cpu", "processes": 1}
    whole = crossval("stroke_cnn", store, out=tmp_path / "whole", **options)
    trained = []

    def training(*args, task, **more):
        trained.append(task)
        if len(trained) == 2:
            raise KeyboardInterrupt
        run_training(*args, task=task, **more)

    monkeypatch.setattr(crossval_module, "run_training", training)
    with pytest.raises(KeyboardInterrupt):
        crossval("stroke_cnn", store, out=tmp_path / "cv", **options)
    again = crossval("stroke_cnn", store, out=tmp_path / "cv", **options)
    assert trained == ["fold 1/3 ", "fold 2/3 ", "fold 2/3 ", "fold 3/3 "]
    assert again | {"report": ""} == whole | {"report": ""}
    assert not (tmp_path / "cv" / "folds").exists()


def test_one_recording_per_material_is_trained_with_the_split_that_is_advised(
    tmp_path, recordings, tiny, capsys
):
    create_store(tmp_path / "s", recordings(("cork", "tile"), 1), name="s", licence="-", simulated=True)
    words = ["train", "stroke_cnn", "--data", str(tmp_path / "s"), "--recipe", "tiny", "--accelerator", "cpu"]
    words += [text for key, value in tiny.items() for text in ("--set", f"{key}={value}")]
    assert main([*words, "--out", str(tmp_path / "run")]) == 1
    advised = re.search("`tactogram [^`]+ (--split [^` ]+)` tests on a part", capsys.readouterr().err)[1]
    assert main([*words, "--out", str(tmp_path / "run"), *advised.split()]) == 0
    parts = Split.load(tmp_path / "run" / "split.json")
    assert all(segment.start_s == pytest.approx(2.4) for segment in parts.test)
    assert all(segment.stop_s == pytest.approx(2.4 - parts.gap_s) for segment in parts.train)
    assert main([*words, "--out", str(tmp_path / "no"), *advised.split(), "--set", "config.window=2000"]) == 1
    assert "5 blocks of a recording need at least" in capsys.readouterr().err


def test_fewer_recordings_than_folds_are_cut_into_blocks(tmp_path, recordings, tiny):
    create_store(tmp_path / "s", recordings(("cork", "tile"), 2), name="s", licence="-", simulated=True)
    options = {"recipe": "tiny", "changes": tiny, "accelerator": "cpu", "out": tmp_path / "cv"}
    figures = crossval("stroke_cnn", tmp_path / "s", folds=5, only_folds=1, **options)
    assert figures["split"].startswith("5 contiguous blocks of each recording, 0.097 s (one window) left out")
    assert figures["split"].endswith("only 1 of the 5 folds were run")
    with pytest.raises(ParameterError, match="50 blocks of a recording .* cork has 2 of the 50 recordings"):
        crossval("stroke_cnn", tmp_path / "s", folds=50, **options)
    add_recordings(open_store(tmp_path / "s"), recordings(("wool",), 1))
    with pytest.raises(
        ParameterError, match="; wool has 1 of .* need: record more of it, or exclude it with `where`"
    ):
        crossval("stroke_cnn", tmp_path / "s", folds=50, **options)


def test_last_recordings_test(store, tmp_path, tiny):
    figures = crossval(
        "stroke_cnn",
        store,
        split="last=3",
        label="material+contactor",
        where={"speed_mm_s": "100"},
        recipe="tiny",
        changes=tiny,
        out=tmp_path / "cv",
        accelerator="cpu",
    )
    assert figures["recordings"] == 12
    assert "cork-finger" in figures["materials"]


def test_select_by_fields_and_labels(store):
    from tactogram.datasets import open_store

    index = open_store(store).index
    assert len(select(index, {"speed_mm_s": "100.0", "material": "cork|tile"})) == 10
    assert len(select(index, {"material": "!cork|tile"})) == 20
    assert len(select(index, {"recording": "3"})) == 4
    nameless = replace(index[0], material=None)
    assert select([*index, nameless], {"material": ""}) == [nameless]
    assert select([*index, nameless], {"material": "!"}) == list(index)
    with pytest.raises(ParameterError, match="no recording has material=glass"):
        select(index, {"material": "glass"})


def test_a_killed_training_goes_on_to_the_same_weights(run, store, tmp_path, tiny, capsys, until):
    """Killed in a process of its own; to those of the one that ran through, in this process."""
    killed = tmp_path / "killed"
    changes = {**tiny, "training.checkpoint_every": 5}
    command = ["train", "stroke_cnn", "--data", str(store), "--recipe", "tiny", "--where", "material=!wool"]
    for name, value in changes.items():
        command += ["--set", f"{name}={value}"]
    command += ["--accelerator", "cpu", "--out", str(killed)]
    child = subprocess.Popen(
        [sys.executable, "-m", "tactogram", *command],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    until(lambda: (killed / "checkpoint.safetensors").exists() or child.poll() is not None)
    os.kill(child.pid, signal.SIGKILL)
    assert child.wait() == -signal.SIGKILL
    with pytest.raises(RunError, match="training is not finished"):
        load_run(killed)
    assert main(command) == 1
    assert "resume it" in capsys.readouterr().err
    assert main([*command, "--resume", "--set", "seed=5"]) == 1
    assert "begun with another recipe" in capsys.readouterr().err
    assert main([*command, "--resume"]) == 0
    a, b = (load_state(f / "model.safetensors")[0]["network"] for f in (run.folder, killed))
    assert all((a[name] == b[name]).all() for name in a)
    assert (run.folder / "metrics.jsonl").read_text() == (killed / "metrics.jsonl").read_text()


def test_a_run_travels_in_one_file(run, tmp_path, texture):
    export_run(run.folder, tmp_path / "r.zip")
    left = part_folder(tmp_path / "again")
    left = left.with_name(f"{left.name.rpartition('-')[0]}-99999999")  # of a process that is gone
    left.mkdir()
    part_folder(tmp_path / "again").mkdir()  # of one that is gone, whose number this one has got
    import_run(tmp_path / "r.zip", tmp_path / "again")
    assert not left.exists()
    assert classify(tmp_path / "again", texture("cork", 3)) == classify(run.folder, texture("cork", 3))
    with pytest.raises(RunError, match="exists already"):
        import_run(tmp_path / "r.zip", tmp_path / "again")
    (tmp_path / "x.zip").write_text("no zip")
    with pytest.raises(RunError, match="not a packed run"):
        import_run(tmp_path / "x.zip", tmp_path / "other")
    assert not (tmp_path / "other").exists()


def test_a_packed_path_outside_the_run_is_refused(tmp_path):
    import zipfile

    with zipfile.ZipFile(tmp_path / "bad.zip", "w") as packed:
        packed.writestr("../evil", "x")
    with pytest.raises(RunError, match="names a path outside the run"):
        import_run(tmp_path / "bad.zip", tmp_path / "out")
    assert {p.name for p in tmp_path.iterdir()} == {"bad.zip"}


@pytest.fixture(scope="module")
def voice(store, tmp_path_factory, tiny):
    out = tmp_path_factory.mktemp("runs") / "ar"
    return load_run(train("ar_texture", store, recipe="tiny", out=out, accelerator="cpu").folder)


def test_generated_files_say_what_they_are(voice, tmp_path):
    written = generate_files(
        voice, {"material": {"cork": 0.5, "tile": 0.5}}, tmp_path / "x.wav", seconds=2, count=2
    )
    assert [row["seconds"] for row in written] == [2.0, 2.0]
    first = read_signal(tmp_path / "x-1.wav")
    assert (first.rate, first.unit, first.axes) == (330.0, "m/s^2", ("x", "y", "z"))
    said = read_metadata(tmp_path / "x-1.wav")
    assert said["simulated"] is True
    assert written[0]["simulated"] is True
    assert said["material"] == {"cork": 0.5, "tile": 0.5}
    assert (first.samples != read_signal(tmp_path / "x-2.wav").samples).any()
    again = next(generate(voice, {"material": {"cork": 0.5, "tile": 0.5}}, seconds=2))
    np.testing.assert_array_equal(again.samples, first.samples)


@pytest.mark.parametrize(
    ("condition", "options", "message"),
    [
        ({"material": "glass"}, {}, "material must be one of cork, foam, tile, wool, got 'glass'"),
        ({"material": {"cork": 0.0}}, {}, "at least one material needs a weight > 0"),
        ({"material": "cork"}, {"seconds": 36_000.0}, "seconds must be > 0 and at most 3600, got 36000"),
        ({"material": "cork"}, {"count": 0}, "count must be at least 1"),
        (
            {"material": "cork"},
            {"count": 10**11},
            "count must be at least 1 and at most 100000, got 100000000000",
        ),
        ({"material": "cork", "words": {"rough": 1.0}}, {}, "condition 'words' is not one this model takes"),
    ],
)
def test_conditions_that_mean_nothing_are_refused(voice, condition, options, message):
    with pytest.raises(ParameterError, match=message):
        next(generate(voice, condition, **options))


def test_a_file_that_cannot_hold_a_signal_is_refused_before_one_is_made(voice, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "tactogram.workflows.generation.generate.generate",
        lambda *_, **__: pytest.fail("generated all the same"),
    )
    for name, got in (("x.mp3", ".mp3"), ("x.png", ".png"), ("x", "none")):
        with pytest.raises(ParameterError, match=rf"suffix must be one of \.wav, .*, got {got}"):
            generate_files(voice, {"material": "cork"}, tmp_path / name)


def test_an_array_cannot_be_classified_or_searched_without_its_rate_and_unit(run):
    for job in (classify, search):
        with pytest.raises(
            ParameterError, match="signal must be a Signal, .* got ndarray; make one, `Signal"
        ):
            job(run.folder, np.zeros((3, 2000)))


def test_a_classifier_does_not_generate_nor_a_voice_classify(run, voice, texture):
    with pytest.raises(ParameterError, match="stroke_cnn does not generate"):
        next(generate(run.folder, {"material": "cork"}))
    with pytest.raises(ParameterError, match="ar_texture does not classify, it is a model for generation"):
        classify(voice, texture("cork", 0))


def test_what_is_added_to_the_data_later_does_no_harm(store, tmp_path, tiny, texture):
    grown = tmp_path / "grown"
    shutil.copytree(store, grown)
    run = train(
        "stroke_cnn",
        grown,
        recipe="tiny",
        changes=tiny,
        split="last=2",
        out=tmp_path / "r",
        accelerator="cpu",
    )
    assert len(Split.load(run.folder / "split.json").validation) == 4
    before = evaluate(run.folder)
    write_signal(tmp_path / "new.wav", texture("wool", 500))
    add_signal(grown, tmp_path / "new.wav", material="felt")
    assert evaluate(run.folder)["confusion_windows"] == before["confusion_windows"]
    found = search(run.folder, texture("wool", 500), data=grown, count=1)
    assert found["nearest"][0]["material"] == "felt"


def test_the_updates_of_a_gan_are_said_before_its_first_step(store, tmp_path):
    shown = []
    run = train(
        "stroke_gan",
        store,
        recipe="tiny",
        out=tmp_path / "gan",
        accelerator="cpu",
        progress=lambda task, done, total, note="": shown.append((task, note)),
    )
    place = shown.index(("plan", "updates in all: critic 4, generator 8"))
    assert "train" not in [task for task, _ in shown[:place]]
    assert run.facts()["notes"] == ["updates in all: critic 4, generator 8"]

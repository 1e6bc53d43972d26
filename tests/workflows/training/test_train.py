import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile

import numpy as np
import pytest

from tactogram.cli import main
from tactogram.datasets import Split, create_store
from tactogram.datasets.store.pending import part_folder
from tactogram.errors import ParameterError, RunError, StoppedError
from tactogram.signal.io import write_signal
from tactogram.training import load_state
from tactogram.training.run import Run
from tactogram.workflows.data.stores import add_signal
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.generation.generate import generate
from tactogram.workflows.recognition.classify import classify
from tactogram.workflows.recognition.search import search
from tactogram.workflows.training.execution import resume
from tactogram.workflows.training.hub_folder import export_run, import_run
from tactogram.workflows.training.loaded_run import load_run
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


def test_one_recording_per_material_is_trained_with_the_split_that_is_advised(
    tmp_path, recordings, tiny, capsys
):
    create_store(tmp_path / "s", recordings(("cork", "tile"), 1), name="s", licence="-", simulated=True)
    words = ["train", "stroke_cnn", "--data", str(tmp_path / "s"), "--recipe", "tiny", "--accelerator", "cpu"]
    words += [text for key, value in tiny.items() for text in ("--set", f"{key}={value}")]
    assert main([*words, "--out", str(tmp_path / "run")]) == 1
    advised = re.search(
        "test on a part of each instead, `tactogram [^`]+ (--split [^` ]+)`", capsys.readouterr().err
    )[1]
    assert main([*words, "--out", str(tmp_path / "run"), *advised.split()]) == 0
    parts = Split.load(tmp_path / "run" / "split.json")
    assert all(segment.start_s == pytest.approx(2.4) for segment in parts.test)
    assert all(segment.stop_s == pytest.approx(2.4 - parts.gap_s) for segment in parts.train)
    assert main([*words, "--out", str(tmp_path / "no"), *advised.split(), "--set", "config.window=2000"]) == 1
    assert "5 blocks of a recording need at least" in capsys.readouterr().err


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
    packed = (tmp_path / "r.zip").read_bytes()
    os.utime(run.folder / "recipe.toml", (1e9, 1e9))
    export_run(run.folder, tmp_path / "r.zip")
    assert (tmp_path / "r.zip").read_bytes() == packed
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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"accelerator": "nothing"}, "accelerator nothing"),
        ({"devices": 0}, "devices must be >= 1, got 0"),
        ({"where": {"material": "cork"}}, "at least 2 materials"),
        ({"changes": {"prepare.axes": ["q"]}}, "axis must be one of x, y, z"),
        ({"changes": {"prepare.axes": []}}, "prepare.axes.*at least 1 item"),
        ({"changes": {"prepare.rate": 1e12}}, "prepare.rate.*must be less than or equal to 1000000"),
        (
            {"changes": {"config.steps": 10**19}},
            "config of stroke_cnn: steps: must be at most 10000000, got 1000",
        ),
        ({"changes": {"config.filters": [10**10, 8]}}, "filters: must be at most 10000000"),
        ({"changes": {"config.window": 5000}}, "a window needs 5000"),
        ({"changes": {"config.pool": 64}}, "too short for these filters"),
        ({"changes": {"config.filters": [0, 8]}}, "filters.0"),
        ({"changes": {"config.filters": []}}, "filters"),
        ({"changes": {"config.batch_size": 1}}, "batch_size"),
        ({"changes": {"config.learning_rate": float("inf")}}, "learning_rate"),
        ({"split": "last=50"}, "must have more than 50 recordings, got 10"),
        ({"split": "last=-1"}, "have a number of recordings"),
        ({"split": "last=2", "by": "session"}, "cannot keep sessions together"),
    ],
)
def test_a_training_that_cannot_begin_leaves_nothing(options, message, store, tmp_path):
    with pytest.raises(ParameterError, match=message) as raised:
        train("stroke_cnn", store, recipe="tiny", out=tmp_path / "run", **{"accelerator": "cpu", **options})
    assert "\n" not in str(raised.value)
    assert not (tmp_path / "run").exists()


def test_a_network_larger_than_memory_is_refused(store, tmp_path, monkeypatch):
    monkeypatch.setattr("torch.nn.Linear.reset_parameters", lambda layer: None)  # which takes a minute first
    changes = {"config.dense": [10**7, 10**7]}
    with pytest.raises(ParameterError, match="model stroke_cnn needs more memory than there is"):
        train("stroke_cnn", store, recipe="tiny", out=tmp_path / "run", changes=changes, accelerator="cpu")
    assert not (tmp_path / "run").exists()


def test_settings_that_are_refused_leave_no_prepared_folder(store, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    with pytest.raises(ParameterError, match="axis must be one of x, y, z"):
        train("stroke_cnn", store, recipe="tiny", out=tmp_path / "run", changes={"prepare.axes": ["q"]})
    assert list(tmp_path.glob("tactogram-prepared-*")) == []


def test_a_training_that_fails_in_its_first_step_leaves_nothing(store, tmp_path, monkeypatch):
    options = {"recipe": "tiny", "out": tmp_path / "run", "accelerator": "cpu"}

    def failed(*args, **kwargs):
        raise MemoryError("unable to allocate 74 GiB")

    monkeypatch.setattr("tactogram.training.loop.fit", failed)
    with pytest.raises(
        ParameterError, match=r"stroke_cnn needs more memory than there is \(unable to allocate"
    ):
        train("stroke_cnn", store, **options)
    assert not (tmp_path / "run").exists()


def test_a_run_keeps_every_value_of_its_model(run):
    assert run.recipe.config["hop"] == 0.5
    assert run.recipe.config["steps"] == 60


def test_a_run_counts_as_finished_only_when_it_can_be_searched(store, tmp_path, monkeypatch, texture):
    made = {}

    def killed(self, *args, **kwargs):
        made["index"] = (self.folder / "search.json").is_file()
        raise KeyboardInterrupt

    options = {"recipe": "tiny", "out": tmp_path / "run", "accelerator": "cpu"}
    monkeypatch.setattr(Run, "finish", killed)
    with pytest.raises(KeyboardInterrupt):
        train("stroke_cnn", store, **options)
    monkeypatch.undo()
    assert made["index"]
    assert not Run.open(tmp_path / "run").finished
    finished = train("stroke_cnn", store, resume=True, **options)
    assert classify(finished.folder, texture("cork", 5))["none_of_these"] in (True, False)


def test_a_run_has_its_split_as_soon_as_it_is_one(store, tmp_path, monkeypatch):
    def killed(*args, **kwargs):
        raise KeyboardInterrupt

    options = {"recipe": "tiny", "out": tmp_path / "run", "accelerator": "cpu"}
    monkeypatch.setattr(Run, "create", killed)
    with pytest.raises(KeyboardInterrupt):
        train("stroke_cnn", store, **options)
    monkeypatch.undo()
    assert not (tmp_path / "run" / "recipe.toml").exists()
    assert train("stroke_cnn", store, **options).finished

import os
import time

import pytest

from tactogram.errors import DataError, ParameterError
from tactogram.models import find
from tactogram.recipe import parse_changes
from tactogram.workflows.training.plan import TrainingRequest, check_training
from tactogram.workflows.training.recipe_fields import assignments, recipe_fields
from tactogram.workflows.training.train import train
from tactogram_studio.tasks import log as tasks_log
from tactogram_studio.tasks.log import (
    DetachedProcess,
    checkpoint_position,
    read_metrics,
    start,
)
from tactogram_studio.tasks.queue import StudioTask, TaskQueue
from tactogram_studio.workspace.folder import Workspace

STORE = "studio/first/surfaces"


STEPS = 150


ARGUMENTS = ["--set", f"config.steps={STEPS}", "--set", "training.checkpoint_every=100000", "--split", "all"]


def command(out, *more):
    options = ["--recipe", "tiny", *ARGUMENTS, "--accelerator", "cpu"]
    return ["train", "stroke_cnn", "--data", STORE, *options, "--out", out, *more]


def record(about, **values):
    """Return the record of a training."""
    identifier, at = "20260101-000000-abcdef", "2026-01-01T00:00:00+00:00"
    return StudioTask(identifier, "train", ("train",), about, at, **values)


@pytest.fixture(scope="module")
def trainings(workspace, until):
    nice, tasks_log.NICE = tasks_log.NICE, 0  # nothing else has to stay responsive
    queue = TaskQueue(Workspace.at(workspace), max_running=1)
    yield queue
    tasks_log.NICE = nice
    for task in queue.all():
        if task.process is not None:
            task.process.kill()
    until(lambda: not any(task.process and task.process.alive() for task in queue.all()))


@pytest.mark.slow
def test_a_training_is_stopped_found_by_another_server_and_resumed_to_the_same_weights(
    trainings, workspace, until
):
    first = trainings.begin("train", command("runs/one"), "runs/one")
    second = trainings.begin("train", command("runs/two"), "runs/two")
    assert trainings.status(second).state == "waiting"  # one at a time
    with pytest.raises(ParameterError, match="runs/one: in use by a training"):
        trainings.begin("train", command("runs/one"), "runs/one")
    run = workspace / "runs/one"
    until(lambda: len(read_metrics(run)) > 2)
    assert trainings.status(first).state == "running"
    with pytest.raises(ParameterError, match="in use by a training; wait for it, or stop it first"):
        trainings.delete_run(run)
    other = TaskQueue(Workspace.at(workspace), max_running=1)  # as after a restart of the server
    status = other.status(other.get(first.id))
    assert (status.state, status.progress.name, status.progress.total) == ("running", "classify", STEPS)
    other.stop(second.id)
    assert other.status(other.get(second.id)).state == "stopped"
    other.stop(first.id)
    until(lambda: not other.get(first.id).process.alive())
    stopped = other.status(other.get(first.id))
    step = checkpoint_position(run)["step"]
    assert stopped.state == "stopped"
    assert stopped.message.startswith(f"stopped after step {step} of {STEPS} of classify")
    assert 0 < step < STEPS
    assert read_metrics(run)[-1]["step"] <= step < read_metrics(run)[-1]["step"] + 10  # nothing is lost
    again = other.resume(first.id)
    assert again.arguments == ("train", "--resume", "runs/one")
    whole = train(
        "stroke_cnn", workspace / STORE, recipe="tiny", split="all", accelerator="cpu", out=workspace / "runs/whole",
        changes={"config.steps": STEPS, "training.checkpoint_every": 100000},
    ).folder  # fmt: skip
    until(lambda: other.status(other.get(first.id)).state == "finished")
    for name in ("model.safetensors", "metrics.jsonl"):
        assert (run / name).read_bytes() == (whole / name).read_bytes()
    with pytest.raises(ParameterError, match="finished; only stopped or failed tasks can be resumed"):
        other.resume(first.id)
    other.delete_run(run)
    assert not run.exists()
    assert first.id not in [task.id for task in other.all()]


def test_a_failed_or_killed_training_says_why(trainings, workspace, until):
    failed = trainings.begin("train", ["train", "nosuch", *command("runs/bad")[2:]], "runs/bad")
    until(lambda: trainings.status(trainings.get(failed.id)).state == "failed")
    assert trainings.status(trainings.get(failed.id)).message.startswith("model must be one of ar_texture")
    assert not (workspace / "runs/bad").exists()
    killed = trainings.begin("train", command("runs/killed"), "runs/killed")
    trainings.stop(killed.id, at_once=True)
    until(lambda: not trainings.get(killed.id).process.alive())
    assert trainings.status(trainings.get(killed.id)).state == "stopped"
    trainings.forget(killed.id)
    with pytest.raises(DataError, match="no task"):
        trainings.get(killed.id)


def test_a_process_with_a_reused_number_is_another_one(trainings, tmp_path, until, monkeypatch):
    lasting = tmp_path / "python"
    lasting.write_text("#!/bin/sh\nexec sleep 600\n")
    lasting.chmod(0o755)
    monkeypatch.setattr(tasks_log.sys, "executable", str(lasting))
    process = start(["devices"], folder=tmp_path, log=tmp_path / "log")
    later = DetachedProcess(os.getpid(), process.created - 1000)  # the number was reused
    assert DetachedProcess(os.getpid(), time.time() + 5).alive() is False
    assert not later.alive()
    assert not later.terminate()
    task = record("runs/gone", process=later)
    assert trainings.status(task).state == "failed"
    assert "killed, or the machine was switched off" in trainings.status(task).message
    assert process.kill()
    until(lambda: not process.alive())


def test_a_run_continued_elsewhere_is_reported(trainings, workspace):
    task = record("runs/on", process=DetachedProcess(1, 0.0))
    (workspace / "runs/on").mkdir(parents=True)
    checkpoint, log = workspace / "runs/on/checkpoint.safetensors", trainings.folder / f"{task.id}.log"
    checkpoint.write_bytes(b"")
    trainings.folder.mkdir(parents=True, exist_ok=True)
    log.write_text("tactogram: stopped after step 4 of 9 of gan; all of it is in runs/on\n")
    os.utime(log, (2e9, 2e9))
    assert trainings.status(task).message.startswith("stopped after step 4")
    os.utime(checkpoint, (2e9 + 9, 2e9 + 9))
    assert "outside the studio, continued this run" in trainings.status(task).message


def test_a_broken_record_is_left_out(trainings, tmp_path):
    other = TaskQueue(Workspace.at(tmp_path))
    other.folder.mkdir(parents=True)
    (other.folder / "20260101-000000-abcdef.json").write_text("{")
    (other.folder / "other.json").write_text("{}")
    assert other.all() == []
    with pytest.raises(ParameterError, match="lies outside"):
        other.begin("train", [], "../elsewhere")
    with pytest.raises(ParameterError, match="not a run of this workspace"):
        other.delete_run(tmp_path)


def test_a_model_that_does_not_fit_the_data_is_refused_in_advance(workspace):
    facts = check_training(TrainingRequest("stroke_cnn", workspace / STORE, recipe="tiny", split="all"))
    assert (facts["train"], facts["test"], len(facts["materials"]), facts["rate"]) == (18, 0, 9, 1000.0)
    assert facts["simulated"] is True
    with pytest.raises(ParameterError, match="has no ratings; `tactogram data rate`"):
        check_training(TrainingRequest("rater", workspace / STORE, recipe="tiny"))
    with pytest.raises(ParameterError, match="axis must be one of x, y, z"):
        check_training(
            TrainingRequest("stroke_cnn", workspace / STORE, split="all", changes={"prepare.axes": ["w"]})
        )


def test_a_form_shows_the_models_own_documentation():
    fields = {field.key: field for field in recipe_fields(find("stroke_cnn"), "tiny")}
    window = fields["config.window"]
    assert (window.value, window.published, window.widget) == (32, 200, "integer")
    assert window.text == 'Samples per axis of one input. Sec. II-B: "200-point continuous time series".'
    assert fields["config.schedule"].choices == ("constant", "one-cycle")
    assert fields["prepare.rate"].widget == "text"
    entries = {
        "config.window": 64.0,
        "config.filters": "[8, 8]",
        "config.steps": 6,
        "prepare.band": "",
        "other": 1,
    }
    changed = assignments(list(fields.values()), entries)
    assert changed == ["config.window=64", "config.filters=[8, 8]"]
    assert parse_changes(changed) == {"config.window": 64, "config.filters": [8, 8]}
    with pytest.raises(ParameterError, match="whole number"):
        assignments(list(fields.values()), {"config.window": 2.5})


def test_a_nested_configuration_has_dotted_keys():
    fields = {field.key: field for field in recipe_fields(find("visual_tactile_gan"), "quick")}
    assert fields["config.pairs.hop"].published == 128
    assert fields["config.pairs.hop"].value == 32
    assert all(field.text for field in fields.values())

import json
import shutil
import struct
import sys
import types
from pathlib import Path

import pytest

from tactogram.cli import main
from tactogram.errors import DataError, MissingExtraError, ParameterError, RunError
from tactogram.training.run import Run
from tactogram.workflows.training import execution
from tactogram.workflows.training.execution import make_logger, resume
from tactogram.workflows.training.plan import plan_of
from tactogram.workflows.training.run_lock import run_lock
from tactogram.workflows.training.train import train


@pytest.fixture
def unfinished(run, tmp_path):
    """Give a copy of the run as it was before its end."""
    shutil.copytree(run.folder, tmp_path / "run")
    (tmp_path / "run" / "model.json").unlink()
    return Run(tmp_path / "run")


def changed(run, **values):
    file = run.folder / "data.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), **values}))


def test_a_run_that_does_not_say_its_split_is_refused_in_one_line(unfinished):
    (unfinished.folder / "split.json").unlink()
    with pytest.raises(DataError, match=r"split.json: no such file"):
        resume(unfinished.folder)


def test_data_that_has_changed_or_gone_is_refused(unfinished, store, tmp_path):
    data = unfinished.data["path"]
    changed(unfinished, path=str(tmp_path / "gone"))
    with pytest.raises(RunError, match="its data is not at .*gone.*; give `data`"):
        resume(unfinished.folder)
    assert plan_of(unfinished, data=store).identity == unfinished.data["run_id"]
    changed(unfinished, path=data, sha256="0" * 64)
    with pytest.raises(RunError, match="has changed since the run began"):
        resume(unfinished.folder)


def test_a_run_in_work_is_refused_before_anything_is_prepared(unfinished, monkeypatch):
    monkeypatch.setattr("tactogram.workflows.training.execution.training_material", None)  # would be called
    with run_lock(unfinished.folder), pytest.raises(RunError, match="another process trains here at present"):
        resume(unfinished.folder, accelerator="cpu")


NOWHERE = Path(__file__) / "made"
"""Beneath a file: not even root writes there."""


def test_a_training_does_not_prepare_what_it_could_not_keep(store, monkeypatch):
    monkeypatch.setattr(execution, "training_material", lambda *_: pytest.fail("recordings were prepared"))
    with pytest.raises(ParameterError, match="cannot be written"):
        train("stroke_cnn", store, recipe="tiny", out=NOWHERE, accelerator="cpu")


def events(folder):
    """Return what TensorBoard reads: (step, name) -> value, the last written one of each."""
    from tensorboardX.proto.event_pb2 import Event

    found = {}
    for file in sorted(folder.glob("events.*")):
        data, place = file.read_bytes(), 0
        while place < len(data):
            (length,) = struct.unpack_from("<Q", data, place)
            event = Event.FromString(data[place + 12 : place + 12 + length])
            found |= {(event.step, value.tag): value.simple_value for value in event.summary.value}
            place += length + 16
    return found


def test_tensorboard_has_the_losses_of_every_stage_and_the_validation(store, tmp_path):
    pytest.importorskip("tensorboardX")
    told = ["train", "stroke_cnn", "--data", str(store), "--recipe", "tiny", "--set", "config.steps=20"]
    assert (
        main([*told, "--accelerator", "cpu", "--out", str(tmp_path / "run"), "--logger", "tensorboard"]) == 0
    )
    run = Run(tmp_path / "run")
    found = events(run.folder / "tensorboard")
    logged = {(line["step"], "classify/loss"): line["loss"] for line in run.metrics() if line["stage"] == 1}
    first = min(step for step, name in found if name == "classify/loss") - min(step for step, _ in logged)
    shifted = {(step + first, name): value for (step, name), value in logged.items()}
    assert {key: found[key] for key in shifted} == pytest.approx(shifted)
    validation = run.facts()["validation"]
    assert found[20 + first, "validation/recording_accuracy"] == pytest.approx(
        validation["recording_accuracy"]
    )


@pytest.fixture
def wandb(monkeypatch):
    """Stand in for the package, which would start a process and look for an account."""
    calls = []
    run = types.SimpleNamespace(
        config=types.SimpleNamespace(update=lambda values, **_: calls.append(("config", values))),
        log=lambda values, step: calls.append((step, values)),
        finish=lambda exit_code: calls.append(("finish", exit_code)),
    )
    package = types.ModuleType("wandb")
    package.init = lambda **options: calls.append(("init", options)) or run
    monkeypatch.setitem(sys.modules, "wandb", package)
    return calls


def test_a_resumed_run_continues_its_own_run_in_weights_and_biases(wandb, tmp_path):
    for status in ("failed", "success"):
        logger = make_logger("wandb", tmp_path, start=0)
        logger.log_hyperparams({"model": "m"})
        logger.log_metrics({"fit/loss": 1.0}, step=3)
        logger.finalize(status)
    (_, first), (_, second) = [call for call in wandb if call[0] == "init"]
    assert first == second
    assert len(first["id"]) == 32
    assert (first["project"], first["name"], first["dir"]) == (
        "tactogram",
        tmp_path.name,
        tmp_path,
    )
    assert wandb.count((3, {"fit/loss": 1.0})) == wandb.count(("config", {"model": "m"})) == 2
    assert [call for call in wandb if call[0] == "finish"] == [("finish", 1), ("finish", 0)]


def test_a_logger_that_is_not_installed_is_refused_before_anything_is_written(
    store, tmp_path, monkeypatch, capsys
):
    monkeypatch.setitem(sys.modules, "wandb", None)
    told = [
        "train",
        "stroke_cnn",
        "--data",
        str(store),
        "--out",
        str(tmp_path / "run"),
        "--logger",
        "wandb",
    ]
    assert main(told) != 0
    assert "pip install 'tactogram[loggers]'" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
    with pytest.raises(MissingExtraError):
        make_logger("wandb", tmp_path, start=0)

"""Trainings by several processes: as one process, and resumed in another number."""

import json
import subprocess
import sys

import numpy as np
import psutil
import pytest

from tactogram.errors import StoppedError
from tactogram.training.run import Run
from tactogram.workflows.training.train import train

CHANGES = {
    "config.steps": 8,
    "config.batch_size": 16,
    "config.dropout": 0,  # the one thing that each process draws for itself
    "training.log_every": 1,
    "training.checkpoint_every": 1,
}


def trained(store, out, **options):
    return train(
        "stroke_cnn",
        store,
        recipe="tiny",
        changes=CHANGES,
        split="all",
        out=out,
        accelerator="cpu",
        **options,
    )


@pytest.fixture(scope="module")
def alone(store, tmp_path_factory):
    return trained(store, tmp_path_factory.mktemp("alone") / "run")


def losses(run):
    return [line["loss"] for line in run.metrics() if "loss" in line]


def check_as(run, alone):
    """The losses are about those of one process, which normalises a batch as a whole."""
    assert run.finished
    np.testing.assert_allclose(losses(run)[0], losses(alone)[0], rtol=0.01)
    np.testing.assert_allclose(losses(run), losses(alone), rtol=0.15)
    assert run.data["run_id"] == alone.data["run_id"]


def commanded(model, store, out, *more):
    """Train by the command, in two processes."""
    command = (
        sys.executable,
        "-m",
        "tactogram",
        "train",
        model,
        "--data",
        store,
        "--recipe",
        "tiny",
        "--out",
        out,
    )
    options = ("--accelerator", "cpu", "--devices", "2", "--json", *more)
    return subprocess.run([*command, *options], check=False, capture_output=True, text=True, timeout=300)


@pytest.mark.slow
def test_two_processes_train_as_one(alone, store, tmp_path):
    changes = [part for name, value in CHANGES.items() for part in ("--set", f"{name}={value}")]
    done = commanded("stroke_cnn", store, tmp_path / "run", "--split", "all", *changes)
    assert json.loads(done.stdout)["run"] == str(tmp_path / "run"), done.stderr
    check_as(Run(tmp_path / "run"), alone)


@pytest.mark.slow
def test_no_process_is_left_when_the_first_is_killed(store, tmp_path, until):
    command = "-m tactogram train stroke_cnn --recipe quick --accelerator cpu --devices 2 --data"
    with subprocess.Popen([sys.executable, *command.split(), store, "--out", tmp_path / "run"]) as first:
        others = psutil.Process(first.pid).children
        until(lambda: others() or first.poll() is not None)
        begun = others()
        first.kill()
    assert begun
    assert psutil.wait_procs(begun, timeout=60)[1] == []


@pytest.mark.slow
def test_a_closed_form_is_refused(store, tmp_path):
    done = commanded("ar_texture", store, tmp_path / "run")
    assert "ar_texture cannot divide its batches, or is a closed form: train it" in done.stdout + done.stderr
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_two_processes_continue_what_one_process_began(alone, store, tmp_path):
    with pytest.raises(StoppedError):
        trained(store, tmp_path / "run", stop=(tmp_path / "run" / "checkpoint.safetensors").exists)
    command = ("-m", "tactogram", "train", "--resume", tmp_path / "run", "--accelerator", "cpu", "--json")
    done = subprocess.run(
        [sys.executable, *map(str, command), "--devices", "2"], check=True, capture_output=True, text=True
    )
    assert json.loads(done.stdout)["run"] == str(tmp_path / "run")
    check_as(Run(tmp_path / "run"), alone)

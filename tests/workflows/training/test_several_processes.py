"""Trainings by several processes: as one process, killed, resumed in any number, and by torchrun."""

import json
import multiprocessing
import os
import subprocess
import sys

import numpy as np
import pytest

from tactogram.errors import ParameterError, RunError, StoppedError
from tactogram.training.run import Run
from tactogram.workflows.training.launch import free_port
from tactogram.workflows.training.resume import resume
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
    """The losses are those of one process; Adam's first steps amplify rounding."""
    assert run.finished
    np.testing.assert_allclose(losses(run)[0], losses(alone)[0], rtol=1e-5)
    np.testing.assert_allclose(losses(run), losses(alone), rtol=0.05)
    assert run.data["run_id"] == alone.data["run_id"]


@pytest.mark.slow
def test_two_processes_train_as_one_and_a_killed_one_ends_both_in_one_line(alone, store, tmp_path):
    def kill(task, done, total, note=""):
        if task == "classify" and done >= 3:
            sorted(multiprocessing.active_children(), key=lambda child: child.pid)[1].kill()

    with pytest.raises(RunError, match="process 2 of 2 was killed by SIGKILL") as caught:
        trained(store, tmp_path / "run", devices=2, progress=kill)
    assert "\n" not in str(caught.value)
    assert not multiprocessing.active_children()
    done = losses(Run(tmp_path / "run"))
    np.testing.assert_allclose(done, losses(alone)[: len(done)], rtol=0.05)
    assert 3 <= len(done) < CHANGES["config.steps"] + 1
    check_as(resume(tmp_path / "run", accelerator="cpu"), alone)  # begun by two, ended by one


def test_a_closed_form_is_refused(store, tmp_path):
    with pytest.raises(
        ParameterError, match="^ar_texture cannot divide its batches, or is a closed form: train it"
    ):
        train("ar_texture", store, recipe="tiny", out=tmp_path / "run", devices=2, accelerator="cpu")
    assert not (tmp_path / "run").exists()


def test_several_machines_are_torchruns_matter(store, tmp_path):
    with pytest.raises(
        ParameterError, match="on 2 machines is started by torchrun, on each of them: torchrun"
    ):
        trained(store, tmp_path / "run", nodes=2)


@pytest.mark.slow
def test_two_machines_of_torchrun_continue_what_one_process_began(alone, store, tmp_path):
    with pytest.raises(StoppedError):
        trained(store, tmp_path / "run", stop=(tmp_path / "run" / "checkpoint.safetensors").exists)
    port = free_port()
    command = ("-m", "tactogram", "train", "--resume", tmp_path / "run", "--accelerator", "cpu", "--json")
    machines = [
        subprocess.Popen(
            [
                *(sys.executable, "-m", "torch.distributed.run", "--nnodes", "2", "--nproc-per-node", "1"),
                *("--node-rank", str(number), "--master-addr", "127.0.0.1", "--master-port", str(port)),
                *map(str, command),
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
        )
        for number in range(2)
    ]
    outputs = [machine.communicate(timeout=300) for machine in machines]
    assert [machine.returncode for machine in machines] == [0, 0], outputs
    assert json.loads(outputs[0][0])["run"] == str(tmp_path / "run")
    assert outputs[1][0] == ""
    check_as(Run(tmp_path / "run"), alone)

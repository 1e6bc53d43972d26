"""One training per run folder."""

import fcntl
import shutil

import pytest

from tactogram.errors import RunError
from tactogram.training.run import Run
from tactogram.workflows.training import run_lock as looking
from tactogram.workflows.training.execution import resume
from tactogram.workflows.training.run_lock import is_training, run_lock


@pytest.fixture
def unfinished(run, tmp_path):
    """Give a copy of the run as it was before its end."""
    shutil.copytree(run.folder, tmp_path / "run")
    (tmp_path / "run" / "model.json").unlink()
    return Run(tmp_path / "run")


def test_two_processes_never_train_one_run(unfinished):
    assert not is_training(unfinished.folder)
    with run_lock(unfinished.folder):
        assert is_training(unfinished.folder)
        with pytest.raises(RunError, match="another process trains here at present"):
            resume(unfinished.folder, accelerator="cpu")
    assert not is_training(unfinished.folder)
    assert not is_training(unfinished.folder / "nothing")


def test_whoever_only_looks_keeps_nobody_from_training(unfinished, monkeypatch):
    with (unfinished.folder / "recipe.toml").open("rb") as other:
        fcntl.flock(other, fcntl.LOCK_SH)  # as a page does that lists runs
        monkeypatch.setattr(looking.time, "sleep", lambda seconds: fcntl.flock(other, fcntl.LOCK_UN))
        with run_lock(unfinished.folder):
            assert is_training(unfinished.folder)

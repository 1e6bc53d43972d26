"""Folders of runs before the first step."""

import shutil
from dataclasses import replace

import pytest

from tactogram.errors import RunError
from tactogram.training.run import Run
from tactogram.workflows.training.plan import plan_of
from tactogram.workflows.training.run_folder import begin


@pytest.fixture
def unfinished(run, tmp_path):
    """Give a copy of the run as it was before its end."""
    shutil.copytree(run.folder, tmp_path / "run")
    (tmp_path / "run" / "model.json").unlink()
    return Run(tmp_path / "run")


def test_a_run_that_was_begun_meanwhile_keeps_its_split(unfinished):
    plan = plan_of(unfinished)
    before = (unfinished.folder / "split.json").read_bytes()
    other = replace(plan, parts=replace(plan.parts, train=plan.parts.train[1:]))
    with pytest.raises(RunError, match="contains a run, which has begun"):
        begin(unfinished, other)
    assert (unfinished.folder / "split.json").read_bytes() == before

import fcntl
import json
import shutil
from dataclasses import replace

import pytest

from tactogram.cli.command import main
from tactogram.errors import DataError, RunError
from tactogram.training.run import Run
from tactogram.workflows.training import run_lock as looking
from tactogram.workflows.training.execution import resume
from tactogram.workflows.training.plan import plan_of
from tactogram.workflows.training.run_folder import begin
from tactogram.workflows.training.run_lock import is_training, run_lock


@pytest.fixture
def unfinished(run, tmp_path):
    """Give a copy of the run as it was before its end."""
    shutil.copytree(run.folder, tmp_path / "run")
    (tmp_path / "run" / "model.json").unlink()
    return Run(tmp_path / "run")


def changed(run, **values):
    file = run.folder / "data.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), **values}))


def test_a_run_says_all_that_its_training_is_of(run):
    plan = plan_of(run)
    assert plan.identity == run.data["run_id"]
    assert plan.config.steps == 60
    assert {plan.store.info(segment.id).material for segment in plan.parts.train} == {"cork", "foam", "tile"}


def test_a_run_that_does_not_say_its_split_is_refused_in_one_line(unfinished):
    (unfinished.folder / "split.json").unlink()
    with pytest.raises(DataError, match=r"split.json: not readable: No such file"):
        resume(unfinished.folder)


def test_data_that_has_changed_or_gone_is_refused(unfinished, store, tmp_path):
    data = unfinished.data["path"]
    changed(unfinished, path=str(tmp_path / "gone"))
    with pytest.raises(RunError, match="its data is not at .*gone; give `data`"):
        resume(unfinished.folder)
    assert plan_of(unfinished, data=store).identity == unfinished.data["run_id"]
    changed(unfinished, path=data, sha256="0" * 64)
    with pytest.raises(RunError, match="has changed since the run began"):
        resume(unfinished.folder)


def test_two_processes_never_train_one_run(unfinished):
    assert not is_training(unfinished.folder)
    with run_lock(unfinished.folder):
        assert is_training(unfinished.folder)
        with pytest.raises(RunError, match="another process trains here at present"):
            resume(unfinished.folder, accelerator="cpu")
    assert not is_training(unfinished.folder)
    assert not is_training(unfinished.folder / "nothing")


def test_a_run_in_work_is_refused_before_anything_is_prepared(unfinished, monkeypatch):
    monkeypatch.setattr("tactogram.workflows.training.execution.training_material", None)  # would be called
    with run_lock(unfinished.folder), pytest.raises(RunError, match="another process trains here at present"):
        resume(unfinished.folder, accelerator="cpu")


def test_whoever_only_looks_keeps_nobody_from_training(unfinished, monkeypatch):
    with (unfinished.folder / "recipe.toml").open("rb") as other:
        fcntl.flock(other, fcntl.LOCK_SH)  # as a page does that lists runs
        monkeypatch.setattr(looking.time, "sleep", lambda seconds: fcntl.flock(other, fcntl.LOCK_UN))
        with run_lock(unfinished.folder):
            assert is_training(unfinished.folder)


def test_a_run_that_was_begun_meanwhile_keeps_its_split(unfinished):
    plan = plan_of(unfinished)
    before = (unfinished.folder / "split.json").read_bytes()
    other = replace(plan, parts=replace(plan.parts, train=plan.parts.train[1:]))
    with pytest.raises(RunError, match="contains a run, which has begun"):
        begin(unfinished, other)
    assert (unfinished.folder / "split.json").read_bytes() == before


def test_what_a_run_has_said_is_not_said_again(run, capsys):
    assert (
        main(["train", "--resume", str(run.folder), "stroke_cnn", "--split", "all", "--set", "seed=1"]) == 2
    )
    assert "omit MODEL, --set, --split" in capsys.readouterr().err


def test_a_finished_run_is_given_as_it_is(run, capsys):
    assert main(["train", "--resume", str(run.folder)]) == 0
    assert f"run: {run.folder}" in capsys.readouterr().out


def test_a_training_needs_a_model_and_data(capsys):
    assert main(["train", "stroke_cnn"]) == 2
    assert "needs --data DIR and MODEL or --for, or --resume RUN" in capsys.readouterr().err

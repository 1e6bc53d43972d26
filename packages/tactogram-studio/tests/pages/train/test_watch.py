import pytest

from tactogram.errors import ParameterError
from tactogram.workflows.training.run_lock import run_lock
from tactogram_studio.pages.train.watch import state_of
from tactogram_studio.tasks import log as tasks_log
from tactogram_studio.tasks.queue import StudioTask, TaskQueue
from tactogram_studio.workspace.folder import Workspace
from tactogram_studio.workspace.runs import run_summary


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


def test_a_run_that_another_process_trains_is_protected(trainings, workspace):
    run = workspace / "runs/elsewhere"
    run.mkdir(parents=True)
    (run / "recipe.toml").write_text('model = "stroke_cnn"\n')
    assert state_of(run_summary(run), None) == "unfinished"
    with run_lock(run):
        assert state_of(run_summary(run), None) == "running"
        with pytest.raises(ParameterError, match="outside the studio is training it; wait"):
            trainings.resume_run(run)
        with pytest.raises(ParameterError, match="outside the studio is training it; stop it before"):
            trainings.delete_run(run)
        trainings._write(record("runs/elsewhere", stop_asked=True))
        # Also if the studio once started it.
        with pytest.raises(ParameterError, match="outside the studio is training it; wait"):
            trainings.resume_run(run)
    left = run.with_name(".deleted-0a1b2c.gone")
    (left / "samples").mkdir(parents=True)
    trainings.delete_run(run)
    assert not run.exists()
    assert not left.exists()  # the leftover of a killed server

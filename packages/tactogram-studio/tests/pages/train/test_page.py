import contextlib
import signal

import psutil
import pytest

from tactogram_studio.pages.train.page import loss_by_run
from tactogram_studio.tasks.log import checkpoint_position, read_metrics
from tactogram_studio.tasks.queue import TaskQueue
from tactogram_studio.workspace.folder import Workspace

SET = "studio/first/surfaces"


@pytest.fixture
def left_behind(workspace):
    """End the trainings that a test leaves running: they outlive its server by design."""
    yield
    for task in TaskQueue(Workspace.at(workspace)).all():
        if task.process is not None:
            task.process.kill()


def started(tab, *, steps):
    """Fill in the form and start the training, which opens the page of its run."""
    tab.goto(f"/train?model=stroke_gan&data={SET}")
    tab.get_by_text("Recommended: texture_var, closest").get_by_text("Chosen below: stroke_gan.").wait_for()
    tab.get_by_role("button", name="More options").click()
    tab.get_by_label("Recipe", exact=True).click()
    tab.get_by_role("option", name="tiny").click()
    tab.get_by_role("button", name="Start").click()
    # Two recordings of a material are too few for the default split.
    tab.get_by_role("alert").filter(has_text="validation would be empty").wait_for()
    tab.get_by_label("Split").click()
    tab.get_by_role("option", name="no test part").click()
    tab.get_by_role("button", name="Recipe settings").click()
    tab.get_by_label("steps", exact=True).fill(str(steps))
    tab.get_by_text("Published: none. Steps, instead of epochs. Ours.").wait_for()
    tab.get_by_role("button", name="Done").click()
    tab.get_by_text(f"--set config.steps={steps}").wait_for()
    tab.get_by_role("button", name="Start").click()
    tab.wait_for_url("**/train/watch**")


def state(tab, name):
    tab.locator(f"[data-state={name}]").first.wait_for()


def hurried(workspace):
    """Undo the niceness of trainings where that is allowed: nothing else has to stay responsive here."""
    for task in TaskQueue(Workspace.at(workspace)).all():
        if task.process is not None:
            with contextlib.suppress(psutil.Error):
                psutil.Process(task.process.pid).nice(0)


@pytest.mark.usefixtures("left_behind")
def test_a_training_is_watched_stopped_resumed_and_survives_the_server(
    browser, workspace, served, watched, until
):
    arguments = ("studio", "--port", "0", "--no-open", "--folder", ".")
    run = workspace / "runs/stroke_gan-tiny"
    with served(*arguments, folder=workspace, prefix="studio: ") as (process, address):
        context = browser.new_context(base_url=address, viewport={"width": 1440, "height": 900})
        with watched(context, address) as tab:
            started(tab, steps=100_000)
            state(tab, "running")
            hurried(workspace)
            tab.get_by_text("No losses yet.").wait_for(state="hidden")
            tab.get_by_text("per second").wait_for()
            tab.get_by_role("button", name="Stop", exact=True).click()
            state(tab, "stopped")
            tab.get_by_text("stopped after step").first.wait_for()
            stopped_at = checkpoint_position(run)["step"]
            assert stopped_at >= read_metrics(run)[-1]["step"]
            tab.get_by_role("combobox", name="Sample of").click()
            tab.get_by_role("option", name="carpet").click()
            tab.get_by_role("button", name="Generate sample").click()
            sample = tab.locator(".signal", has_text=f"carpet at step {stopped_at}")
            sample.wait_for()
            sample.get_by_text("simulated", exact=True).wait_for()  # as its training data is
            trainings = TaskQueue(Workspace.at(workspace))
            for task in trainings.of("runs/stroke_gan-tiny"):
                trainings.forget(task.id)  # as if it had been started at the command line
            state(tab, "unfinished")
            tab.get_by_role("button", name="Resume").click()
            state(tab, "running")
            hurried(workspace)
        context.close()
        process.send_signal(signal.SIGKILL)  # while the training's own process is starting
        process.wait()
    with served(*arguments, folder=workspace, prefix="studio: ") as (_, address):
        context = browser.new_context(base_url=address, viewport={"width": 820, "height": 1180})
        with watched(context, address) as tab:
            tab.goto("/train/watch?run=runs/stroke_gan-tiny")
            state(tab, "running")  # still the same process
            until(lambda: read_metrics(run)[-1]["step"] > stopped_at)
            tab.get_by_role("button", name="Stop", exact=True).click()
            state(tab, "stopped")
            tab.goto("/train/compare?run=runs/stroke_gan-tiny&run=studio/first/voices")
            tab.get_by_text("Different settings").wait_for()
            tab.get_by_role("cell", name="ar_texture").wait_for()
            tab.goto("/train/watch?run=runs/stroke_gan-tiny")
            tab.get_by_role("button", name="Delete").click()
            with watched(context, address) as other:
                other.goto("/train/watch?run=runs/stroke_gan-tiny")
                tab.get_by_role("button", name="Delete run").click()
                other.get_by_text("runs/stroke_gan-tiny has been deleted.").wait_for()
                other.close()
            tab.get_by_text("Runs (1)").wait_for()
            assert not run.exists()
            # This browser has not filled in the form yet: the command has the defaults.
            tab.locator(".code", has_text="--recipe quick --out runs/texture_var-quick").wait_for()
            tab.goto("/train/watch?run=runs/gone")
            tab.get_by_text("no such run in this workspace").wait_for()
        context.close()


def test_a_comparison_shows_the_loss_of_the_runs_that_have_it():
    curves = {"r1": {"loss": [(1, 2.0)]}, "r2": {"other": [(1, 1.0)]}}
    assert loss_by_run(curves, "loss") == {"r1": [(1, 2.0)]}

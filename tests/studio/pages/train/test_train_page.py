import contextlib
import signal
from pathlib import Path

import psutil
import pytest

from tactogram.errors import ParameterError
from tactogram.models import available, find
from tactogram.recipe import parse_changes
from tactogram.studio.pages.train.compare import differences, flat, overlaid, rows_of_figures
from tactogram.studio.pages.train.log import checkpoint_step, metrics
from tactogram.studio.pages.train.request import RunRequest, describe_model
from tactogram.studio.pages.train.run_facts import RunSummary
from tactogram.studio.pages.train.trainings import TaskQueue
from tactogram.studio.pages.train.widgets import loss_options
from tactogram.studio.workspace.folder import Workspace

SET = "studio/first/surfaces"


def test_a_form_says_what_the_command_line_says():
    plain = RunRequest("stroke_cnn", "data/x", "quick", "one")
    assert plain.arguments == [
        "train",
        "stroke_cnn",
        "--data",
        "data/x",
        "--recipe",
        "quick",
        "--out",
        "runs/one",
    ]
    order = RunRequest(
        "stroke_cnn", "d", "quick", "one", "last", 3, "session", "material+contactor", "contactor=pen session=a|b",
        ("config.steps=5",),
    )  # fmt: skip
    more = "--split last=3 --by session --label material+contactor --where contactor=pen --where session=a|b"
    assert order.arguments[6:-2] == [*more.split(), "--set", "config.steps=5"]
    asked = order.asked(Path("d"))
    assert (asked.split, asked.where) == ("last=3", {"contactor": "pen", "session": "a|b"})
    assert asked.changes == parse_changes(["config.steps=5"])


@pytest.mark.parametrize("name", ["", "../x", "a/b", ".hidden", "-x", "x" * 90])
def test_a_name_that_is_none_for_a_folder_is_refused(name):
    with pytest.raises(ParameterError, match="the run's name must be letters"):
        _ = RunRequest("m", "d", "quick", name).arguments


def test_every_model_is_told_in_two_sentences():
    texts = {name: describe_model(facts) for name, facts in available().items()}
    assert texts["texture_gan"].startswith(
        "Generates signals, going by material, speed (if given) and force (if given); learns from recordings"
    )
    assert "with photographs" in describe_model(find("pix2pix"))
    assert all(len(text) < 400 for text in texts.values())


def test_runs_are_compared_by_what_differs():
    one, two = {"a": {"b": 1, "c": [2]}, "d": "x"}, {"a": {"b": 1, "c": [3]}, "d": "x"}
    assert differences({"r1": flat(one), "r2": flat(two)}) == {"a.c": {"r1": "[2]", "r2": "[3]"}}
    held = {"r1": {"loss": [(1, 2.0)]}, "r2": {"other": [(1, 1.0)]}}
    assert overlaid(held, "loss") == {"r1": [(1, 2.0)]}
    facts = {
        "r1": RunSummary(None, "m", True, validation={"acc": 0.51234}),
        "r2": RunSummary(None, "m", False),
    }
    assert rows_of_figures(facts) == {"acc (validation)": {"r1": "0.5123"}}


def test_a_chart_is_logarithmic_only_where_it_can_be():
    assert loss_options({"a": [(1, 1.0)]}, log_scale=True)["yAxis"]["type"] == "log"
    assert loss_options({"a": [(1, -1.0)]}, log_scale=True)["yAxis"]["type"] == "value"


@pytest.fixture
def left_behind(workspace):
    """End the trainings that a test leaves behind: they survive it, as they should."""
    yield
    for task in TaskQueue(Workspace.at(workspace)).all():
        if task.process is not None:
            task.process.end()


def started(tab, *, steps):
    """Fill in the form and start; give the run's page."""
    tab.goto(f"/train?model=stroke_gan&data={SET}")
    tab.get_by_label("Recipe", exact=True).click()
    tab.get_by_role("option", name="tiny").click()
    tab.get_by_role("button", name="Start").click()
    tab.get_by_role("alert").filter(
        has_text="validation would be empty"
    ).wait_for()  # two recordings of a material
    tab.get_by_label("Split").click()
    tab.get_by_role("option", name="nothing kept apart").click()
    tab.get_by_role("button", name="Values of the recipe").click()
    tab.get_by_label("steps", exact=True).fill(str(steps))
    tab.get_by_text("Published: none. Steps in place of epochs. Ours.").wait_for()
    tab.get_by_role("button", name="Done").click()
    tab.get_by_text(f"--set config.steps={steps}").wait_for()
    tab.get_by_role("button", name="Start").click()
    tab.wait_for_url("**/train/watch**")


def state(tab, name):
    tab.locator(f"[data-state={name}]").first.wait_for()


def hurried(workspace):
    """Give trainings their full share of the processor where that is allowed: nothing else is to stay quick here."""
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
            tab.get_by_text("all of it is kept").first.wait_for()
            kept = checkpoint_step(run)["step"]
            assert kept >= metrics(run)[-1]["step"]
            tab.get_by_role("combobox", name="of", exact=True).click()
            tab.get_by_role("option", name="carpet").click()
            tab.get_by_role("button", name="Make a sample").click()
            sample = tab.locator(".signal", has_text=f"carpet at step {kept}")
            sample.wait_for()
            sample.get_by_text("simulated", exact=True).wait_for()  # made by what learned from simulated data
            trainings = TaskQueue(Workspace.at(workspace))
            for task in trainings.of("runs/stroke_gan-tiny"):
                trainings.forget(task.id)  # as if it had been begun at the command line
            state(tab, "unfinished")
            tab.get_by_role("button", name="Go on").click()
            state(tab, "running")
            hurried(workspace)
        context.close()
        process.send_signal(signal.SIGKILL)  # while the training's own process still begins
        process.wait()
    with served(*arguments, folder=workspace, prefix="studio: ") as (_, address):
        context = browser.new_context(base_url=address, viewport={"width": 820, "height": 1180})
        with watched(context, address) as tab:
            tab.goto("/train/watch?run=runs/stroke_gan-tiny")
            state(tab, "running")  # the same process, found again
            until(lambda: metrics(run)[-1]["step"] > kept)
            tab.get_by_role("button", name="Stop", exact=True).click()
            state(tab, "stopped")
            tab.goto("/train/compare?run=runs/stroke_gan-tiny&run=studio/first/voices")
            tab.get_by_text("What differs in their recipes and data").wait_for()
            tab.get_by_role("cell", name='"ar_texture"').wait_for()
            tab.goto("/train/watch?run=runs/stroke_gan-tiny")
            tab.get_by_role("button", name="Delete").click()
            with watched(context, address) as other:
                other.goto("/train/watch?run=runs/stroke_gan-tiny")
                tab.get_by_role("button", name="Delete it").click()
                other.get_by_text("runs/stroke_gan-tiny was deleted meanwhile.").wait_for()
                other.close()
            tab.get_by_text("Runs (1)").wait_for()
            assert not run.exists()
            tab.reload()  # what the form kept is in its command
            tab.locator("code", has_text="--recipe quick --out runs/texture_gan-quick").wait_for()
            tab.goto("/train/watch?run=runs/gone")
            tab.get_by_text("no run of this workspace").wait_for()
        context.close()

"""Tasks on processes of this machine."""

import os
import re
import signal
import sys
import time
from threading import Event, Thread

import psutil
import pytest
import torch
import worker_chores as chores

from tactogram.errors import MissingExtraError, ParameterError, TactogramError
from tactogram.workflows.workers import run_tasks
from tactogram.workflows.workers.tasks import kept_values


def by_task(outcomes):
    return {outcome.task: outcome for outcome in outcomes}


def test_results_are_the_same_to_the_bit_in_this_process_and_in_others():
    threads = torch.get_num_threads()
    here = by_task(run_tasks(chores.trained, [1, 2, 3]))
    elsewhere = by_task(run_tasks(chores.trained, [1, 2, 3], processes=2))
    assert {task: outcome.value for task, outcome in here.items()} == {
        task: outcome.value for task, outcome in elsewhere.items()
    }
    assert here[1].value[1] == 1
    assert torch.get_num_threads() == threads


def test_an_error_is_an_outcome_of_its_task_alone():
    seen = []
    found = by_task(run_tasks(chores.refused, [0, 1, 2], progress=lambda *args: seen.append(args)))
    assert [found[n].value for n in (0, 1, 2)] == [0, None, 2]
    assert [found[n].error for n in (0, 1, 2)] == [None, "number must be 0 or 2, got 1", None]
    assert seen == [("tasks", n + 1, 3, str(n)) for n in range(3)]


@pytest.mark.parametrize("processes", [1, 2])
def test_a_bug_is_raised(processes):
    with pytest.raises(ZeroDivisionError, match="is a bug"):
        list(run_tasks(chores.broken, [1, 2], processes=processes))


def test_a_killed_process_costs_its_task_which_is_done_again(tmp_path):
    files = [str(tmp_path / name) for name in ("a", "deadly-b", "c", "deadly-d", "e")]
    found = by_task(run_tasks(chores.deadly_once, files, processes=2))
    assert {outcome.value for outcome in found.values()} == {"a", "deadly-b", "c", "deadly-d", "e"}


def test_a_task_that_kills_every_process_ends_all():
    with pytest.raises(TactogramError, match="workers died 4 times.*ask for fewer processes"):
        list(run_tasks(chores.always_deadly, [0, 1], processes=2))


def test_processes_end_when_the_driver_takes_no_more(tmp_path):
    outcomes = run_tasks(chores.waits, [(str(tmp_path), "a"), (str(tmp_path), "b")], processes=2)
    before = set(psutil.Process().children(recursive=True))
    with pytest.raises(KeyboardInterrupt):
        interrupted(outcomes, tmp_path)
    del outcomes
    running = {int(re.search(r"\.(\d+)\.", f.name)[1]) for f in tmp_path.glob("*.started")}
    assert running
    assert not running & {p.pid for p in psutil.Process().children(recursive=True)} - before


def interrupted(outcomes, folder):
    """Take outcomes until a task runs, then press Ctrl-C, again if it came where Python drops exceptions."""
    ended = Event()

    def press():
        while not list(folder.glob("*.started")):
            time.sleep(0.05)
        while not ended.is_set():
            os.kill(os.getpid(), signal.SIGINT)
            ended.wait(5)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
    Thread(target=press, daemon=True).start()
    try:
        list(outcomes)
    finally:
        ended.set()
        signal.signal(signal.SIGINT, before)


def test_a_driver_that_was_killed_goes_on(tmp_path, killed_and_started_again):
    done, again = killed_and_started_again(tmp_path, "")
    assert not done & again
    assert len(list(tmp_path.glob("*.json"))) == 6


def test_failed_task_is_named_and_the_others_are_kept(tmp_path):
    files = [tmp_path / f"{n}.json" for n in range(3)]
    with pytest.raises(TactogramError, match="task 1: number must be 0 or 2, got 1"):
        kept_values(chores.refused, [0, 1, 2], files, title="t", name=lambda n: f"task {n}")
    assert [file.is_file() for file in files] == [True, False, False]


def test_ray_that_is_not_installed_is_named_with_its_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'tactogram\[ray\]'"):
        list(run_tasks(chores.refused, [0], on="ray"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"on": "dask"}, "on must be ray or ray:ADDRESS, got 'dask'"),
        ({"on": "ray:"}, "on must be ray or ray:ADDRESS"),
        ({"processes": 0}, "processes must be at least 1, got 0"),
    ],
)
def test_what_cannot_be_is_refused_at_once(options, message):
    with pytest.raises(ParameterError, match=message):
        run_tasks(chores.refused, [0], **options)

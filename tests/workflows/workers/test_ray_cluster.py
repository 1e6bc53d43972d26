"""Tasks on a real Ray of two nodes on this machine: two raylets, of which one is killed."""

import re
from threading import Thread

import psutil
import pytest
import worker_chores as chores

from tactogram.errors import ParameterError
from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.workers import run_tasks
from tactogram.workflows.workers.ray_cluster import connected
from tactogram_simulate import simulate_to_store

ray = pytest.importorskip("ray", reason="Ray, of the extra ray, is not installed")

NODE = {"num_cpus": 1, "object_store_memory": 100_000_000}


@pytest.fixture(scope="module")
def cluster():
    patch = pytest.MonkeyPatch()
    patch.setenv("RAY_usage_stats_enabled", "0")
    from ray.cluster_utils import Cluster

    nodes = Cluster(initialize_head=True, head_node_args=NODE | {"include_dashboard": False})
    nodes.second = nodes.add_node(**NODE)
    yield nodes
    nodes.shutdown()
    patch.undo()


@pytest.fixture(scope="module")
def on(cluster):
    """An address to which this process is connected all the time: each connection starts workers of its own."""
    with connected(cluster.address):
        yield f"ray:{cluster.address}"


def by_task(outcomes):
    return {outcome.task: outcome for outcome in outcomes}


def test_an_address_without_a_cluster_is_refused():
    with pytest.raises(ParameterError, match=r"`ray start --head` starts one.*127.0.0.1:9: .*refused"):
        list(run_tasks(chores.refused, [0], on="ray:127.0.0.1:9"))


@pytest.mark.slow
def test_a_ray_of_this_machine_is_started_and_ended():
    (outcome,) = run_tasks(chores.refused, [0], on="ray", processes=2)
    assert (outcome.error, outcome.value) == (None, chores.refused(0))
    assert not ray.is_initialized()


def test_a_driver_that_was_killed_goes_on(cluster, tmp_path, killed_and_started_again):
    done, again = killed_and_started_again(tmp_path, f"ray:{cluster.address}")
    assert not done & again
    assert len(list(tmp_path.glob("*.json"))) == 6


def test_results_are_those_of_this_process_to_the_bit(on):
    here = by_task(run_tasks(chores.trained, [1, 2, 3]))
    there = by_task(run_tasks(chores.trained, [1, 2, 3], on=on))
    assert {task: one.value for task, one in here.items()} == {task: one.value for task, one in there.items()}


def test_an_error_is_an_outcome_and_a_killed_worker_costs_its_task_which_is_done_again(on, tmp_path):
    found = by_task(run_tasks(chores.refused, [0, 1, 2], on=on))
    assert [found[n].error for n in (0, 1, 2)] == [None, "number must be 0 or 2, got 1", None]
    files = [str(tmp_path / name) for name in ("a", "deadly-b", "c")]
    assert {one.value for one in run_tasks(chores.deadly_once, files, on=on)} == {"a", "deadly-b", "c"}


def test_a_bug_is_raised(on):
    with pytest.raises(ZeroDivisionError, match="is a bug"):
        list(run_tasks(chores.broken, [1, 2], on=on))


def test_a_simulated_store_has_the_same_hash(on, tmp_path):
    options = {"random": 2, "seed": 2, "per_class": 2, "seconds": 0.2}
    here = simulate_to_store("surfaces", tmp_path / "here", workers=1, **options)
    there = simulate_to_store("surfaces", tmp_path / "there", on=on, **options)
    assert there["sha256"] == here["sha256"]


def test_cross_validation_has_the_same_figures(on, store, tmp_path):
    options = {"recipe": "tiny", "folds": 2, "changes": {"config.steps": 10}, "accelerator": "cpu"}
    here = crossval("stroke_cnn", store, out=tmp_path / "here", processes=1, **options)
    there = crossval("stroke_cnn", store, out=tmp_path / "there", on=on, **options)
    assert there | {"report": ""} == here | {"report": ""}
    assert {file.name for file in (tmp_path / "there").iterdir()} == {
        "crossval.json",
        "confusion.png",
        "report.html",
    }


def test_a_node_that_is_killed_amid_work_costs_its_task_which_is_done_again(cluster, on, tmp_path):
    """The last of the tests, since the node is gone after it."""
    raylet = cluster.second.all_processes["raylet"][0].process.pid

    def started():
        pids = [int(re.search(r"\.(\d+)\.", file.name)[1]) for file in tmp_path.glob("*.started")]
        return [psutil.Process(pid).ppid() for pid in pids]

    def kill():
        chores.until(lambda: raylet in started() and len(started()) == 2)
        cluster.remove_node(cluster.second, allow_graceful=False)
        (tmp_path / "go").touch()

    killing = Thread(target=kill, daemon=True)
    killing.start()
    found = by_task(run_tasks(chores.waits, [(str(tmp_path), "a"), (str(tmp_path), "b")], on=on))
    killing.join()
    assert {task[1]: one.value for task, one in found.items()} == {"a": "a", "b": "b"}
    assert len(list(tmp_path.glob("*.started"))) == 3

"""The tasks of the package."""

import json
from pathlib import Path

import pytest
from benchmarks.make_tasks import family

from tactogram import models
from tactogram.datasets.importer import IMPORTERS
from tactogram.datasets.simulate.sets import SETS
from tactogram.workflows.data.simulate import simulate_to_store
from tactogram_benchmark.result import COMMITTED as BRIEF, BenchmarkResult, brief, check_result, read_results
from tactogram_benchmark.task import available_tasks
from tactogram_benchmark.task_kind import kind_of

ROOT = Path(__file__).parents[3]
TASKS = available_tasks()
COMMITTED = sorted((ROOT / "benchmarks" / "tasks").glob("*/*.json"))


@pytest.mark.parametrize("name", TASKS)
def test_a_task_is_whole(name):
    task = TASKS[name]
    split = task.load_split()  # refuses another file, and leaks
    assert split.test or split.photographs["test"]
    assert kind_of(task.kind).given
    assert bool(task.data.simulate) != bool(task.data.importer)
    assert task.data.importer in ("", *IMPORTERS.names())
    assert task.data.simulate.get("set_name", "stroking9") in SETS
    for model, chosen in task.recipes.items():
        facts = models.find(model)
        facts.recipe(chosen.recipe)


@pytest.mark.parametrize("name", TASKS)
def test_simulated_data_is_called_simulated(name):
    task = TASKS[name]
    assert not task.data.simulated or "simulated" in task.data.what + task.title


SIMULATED = {task.data.sha256: task.data for task in TASKS.values() if task.data.simulated}


@pytest.mark.slow
@pytest.mark.parametrize("data", SIMULATED.values(), ids=lambda data: data.simulate["set_name"])
def test_the_simulator_still_makes_the_data_that_results_were_measured_on(data, tmp_path):
    assert simulate_to_store(**data.simulate, out=tmp_path / "store")["sha256"] == data.sha256


def test_the_kinds_that_a_paper_of_the_field_asks_are_there():
    kinds = {(task.kind, task.options.get("given", "")) for task in TASKS.values()}
    wanted = {"classification", "rejection", "retrieval", "mixing", "words", "rating"}
    assert wanted < {kind for kind, _ in kinds}
    assert {("generation", "image"), ("generation", "vibration")} < kinds
    assert len(TASKS) >= 20


def test_what_score_ranks_among_is_of_the_committed_results():
    """`make benchmark-page` writes it."""
    assert BRIEF.read_text(encoding="utf-8") == brief(read_results([ROOT / "benchmarks" / "tasks"]))


@pytest.mark.parametrize("name", [name for name, task in TASKS.items() if task.aggregate_only])
def test_results_of_data_that_may_not_be_passed_on_hold_aggregates(name):
    folder = ROOT / "benchmarks" / "tasks" / name
    assert TASKS[name].data.importer == "hatt"
    assert not (folder / "shown").exists()
    for file in folder.glob("*.json"):
        result = BenchmarkResult.load(file)
        assert all(item.startswith("group ") for figure in result.figures.values() for item in figure.by_item)
        assert len(result.main.by_item) <= 9 if result.figures else result.failed


def test_families_of_surfaces_are_in_one_part():
    """Two names for a family that the rule of `benchmarks.make_tasks` makes, and the groups of the split."""
    assert [family(name) for name in ("Canvas 2", "Styrofoam", "Sandpaper 100", "Wax Paper", "Cork")] == [
        "canvas", "foam", "sandpaper", "paper", "Cork",
    ]  # fmt: skip
    split = TASKS["hatt-name"].load_split()
    held = {
        part: {split.groups[segment.id] for segment in segments} for part, segments in split.parts.items()
    }
    assert not held["train"] & held["test"]
    assert not held["validation"] & (held["train"] | held["test"])
    assert {"foam", "carpet", "sandpaper"} < held["test"]


@pytest.mark.parametrize("file", COMMITTED, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_a_committed_result_is_of_its_task(file):
    result = BenchmarkResult.load(file)
    check_result(result, TASKS, where=str(file))
    assert file == result.file(file.parents[1])
    assert not any("/tmp/" in text for text in (json.dumps(result.settings), result.failed))

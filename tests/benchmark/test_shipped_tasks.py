"""The tasks of the package."""

import json
from pathlib import Path

import pytest

from tactogram import models
from tactogram.benchmark.result import BenchmarkResult, check_result
from tactogram.benchmark.task import available_tasks
from tactogram.benchmark.task_kind import kind_of
from tactogram.datasets.importer import IMPORTERS
from tactogram.datasets.simulate.sets import SETS

ROOT = Path(__file__).parents[2]
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


def test_the_kinds_that_a_paper_of_the_field_asks_are_there():
    kinds = {(task.kind, task.options.get("given", "")) for task in TASKS.values()}
    wanted = {"classification", "rejection", "retrieval", "mixing", "words", "rating"}
    assert wanted < {kind for kind, _ in kinds}
    assert {("generation", "image"), ("generation", "vibration")} < kinds
    assert len(TASKS) >= 20


@pytest.mark.parametrize("file", COMMITTED, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_a_committed_result_is_of_its_task(file):
    result = BenchmarkResult.load(file)
    check_result(result, TASKS, where=str(file))
    assert file == result.file(file.parents[1])
    assert not any("/tmp/" in text for text in (json.dumps(result.settings), result.failed))

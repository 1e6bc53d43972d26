"""Result files: committed ones, and samples beside them."""

import json
from pathlib import Path

import numpy as np
import pytest

from tactogram.signal import Image
from tactogram_benchmark.result import (
    COMMITTED as BRIEF,
    REAL_FOLDER,
    BenchmarkResult,
    brief,
    check_result,
    read_results,
    save_shown,
)
from tactogram_benchmark.task import available_tasks

ROOT = Path(__file__).parents[3]


TASKS = available_tasks()


COMMITTED = sorted((ROOT / "benchmarks" / "tasks").glob("*/*.json"))


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


@pytest.mark.parametrize("file", COMMITTED, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_a_committed_result_is_of_its_task(file):
    result = BenchmarkResult.load(file)
    check_result(result, TASKS, where=str(file))
    assert file == result.file(file.parents[1])
    assert not any("/tmp/" in text for text in (json.dumps(result.settings), result.failed))


def test_samples_of_recorded_data_are_kept_apart(tmp_path):
    image = Image(np.zeros((8, 8, 3), np.uint8))
    save_shown(tmp_path, "task", "mine", {"a/b": image, "a/b recorded": image}, simulated=False)
    files = sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.png"))
    assert files == [f"{REAL_FOLDER}/task/shown/mine/a_b.png", f"{REAL_FOLDER}/task/shown/recorded/a_b.png"]

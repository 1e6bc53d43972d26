"""Cells of a run: where their results belong, and which are done."""

from made_up_results import TASKS, result

from tactogram_benchmark.run import BenchmarkCell, is_done
from tactogram_benchmark.task_kind import kind_of

TASK = TASKS["strokes-generate"]


def test_only_a_result_of_this_task_judge_and_recipe_that_did_not_fail_is_done(tmp_path):
    cell = BenchmarkCell(TASK.name, "near", "model", 1, str(tmp_path), str(tmp_path), recipe="quick")
    assert cell.name == "strokes-generate near 1"
    assert not is_done(cell, TASK)
    made = result(TASK, "near", 0.5, seed=1).model_copy(update={"judge": kind_of(TASK.kind).version})
    for change, done in (
        ({}, True),
        ({"task_sha256": "0" * 64}, False),
        ({"judge": made.judge + 1}, False),
        ({"recipe": "paper"}, False),
        ({"failed": "out of memory", "figures": {}}, False),
    ):
        made.model_copy(update=change).save(tmp_path)
        assert cell.file.is_file()
        assert is_done(cell, TASK) is done, change
    cell.file.write_text("{")
    assert not is_done(cell, TASK)

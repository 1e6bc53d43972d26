"""Made-up results of models on the tasks of the package."""

from tactogram_benchmark.ranking import rank_models
from tactogram_benchmark.result import BenchmarkResult
from tactogram_benchmark.table import TaskTable
from tactogram_benchmark.task import available_tasks

TASKS = available_tasks()


def result(task, model, value, *, seed=0, copying=False):
    by_item = {f"item {n}": value + 0.01 * n for n in range(-10, 11)}
    main = {
        "value": value,
        "better": "lower",
        "title": "distance",
        "by_item": by_item,
        "floor": 0.0,
        "ceiling": 1.0,
    }
    near = {"value": 0.9 if copying else 0.3, "better": "lower", "title": "correlation", "floor": 0.2}
    return BenchmarkResult(
        task=task.name, task_sha256=task.sha256, model=model, entry="model", seed=seed, recipe="quick",
        data={"name": task.data.name, "sha256": task.data.sha256, "simulated": task.data.simulated},
        split_sha256=task.split_sha256, judge=1, code="0", device="CPU", finished="now",
        figures={"distance": main, "training_correlation": near},
    )  # fmt: skip


def table(name, values, copying=()):
    task = TASKS[name]
    results = [result(task, model, value, copying=model in copying) for model, value in values.items()]
    failed = [
        result(task, "slow", 1.0).model_copy(update={"figures": {}, "failed": "not trained within 1 minute"})
    ]
    return TaskTable(task, tuple(rank_models(results)), tuple(failed))

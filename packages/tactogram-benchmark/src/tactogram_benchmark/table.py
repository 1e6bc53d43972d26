"""Tables of results in Markdown: one of all tasks, and one for each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tactogram.workflows import HOLDING_RECORDINGS
from tactogram_benchmark.ignoring import IGNORING, RANDOM
from tactogram_benchmark.ranking import RankedModel, rank_models
from tactogram_benchmark.result import BenchmarkResult
from tactogram_benchmark.task import BenchmarkTask
from tactogram_benchmark.task_kind import Figure, kind_of

OTHERS = 4
"""Further figures in a table."""
NOTES = """\
Each model was trained only on the training part of its task, except those marked "as it comes", whose weights ship
with the package. A value is the mean over seeds ± standard deviation, with its 95 % interval in brackets: over the
questions and, if there are several seeds, over trainings. **At best** is the value that other recordings of the same
material, or a perfect answer, would have; **by chance** that of other materials, or of a guess. The rank 2–4 means
that one model is better, and that two others are not told apart from this one. Models are told apart if a paired
permutation test over the questions gives p < 0.05 after Benjamini and Hochberg's correction for all pairs of the task,
and the difference has the same sign for every seed. `random` and `mean` **ignore what is given**, except speed and
force: they answer with training items drawn at random and with the mean of all, of signals noise of their mean log
spectrum. A model **shows no use of its input** unless it is better than both: told apart from them, or better with
every seed and by the 95 % interval of the difference over the questions. Fewer than three seeds are of baselines, which
are not trained, and of models whose trainings took too long for more. A model that **copies** plays back its training
recordings, and makes nothing new."""


@dataclass(frozen=True, eq=False)
class TaskTable:
    """Ranked models of one task, and those that failed."""

    task: BenchmarkTask
    ranked: tuple[RankedModel, ...]
    failed: tuple[BenchmarkResult, ...]

    @property
    def best_new(self) -> RankedModel | None:
        """The best of the models that make something new, if the best does not, and there is one."""
        return (
            next((each for each in self.ranked if not copies(each)), None) if copies(self.ranked[0]) else None
        )


def tables_of(results: Sequence[BenchmarkResult], tasks: Mapping[str, BenchmarkTask]) -> list[TaskTable]:
    """Return the table of each task that has results of its present version, by kind, recorded data first."""

    def order(task: BenchmarkTask) -> tuple[int, bool, str]:
        return kind_of(task.kind).rank, task.data.simulated, task.name

    tables = []
    for task in sorted(tasks.values(), key=order):
        name = task.name
        version = kind_of(task.kind).version
        held = [r for r in results if r.task == name and r.task_sha256 == task.sha256 and r.judge == version]
        ranked = rank_models(held)
        known = {entry.model for entry in ranked}
        failed = {r.model: r for r in held if r.failed and r.model not in known}
        if ranked:
            tables.append(TaskTable(task, tuple(ranked), tuple(failed.values())))
    return tables


def standing_of(
    task: BenchmarkTask, results: Sequence[BenchmarkResult], others: Sequence[BenchmarkResult]
) -> tuple[dict[str, Any], str]:
    """Return ``mean`` and ``rank`` (best, worst) of a model's results on a task among ``others``, and a sentence."""
    model = results[0].model
    (table,) = tables_of([*results, *(other for other in others if other.model != model)], {task.name: task})
    entry = next(each for each in table.ranked if each.model == model)
    told = f"mean {value_text(entry)}: rank {entry.rank_text} of {len(table.ranked)} models with results"
    if entry.informed is False:
        told += f"; not better than {' and '.join(IGNORING)}, which ignore what is given: no use of its input shown"
    facts = {"mean": entry.value, "rank": [entry.best_rank, entry.worst_rank], "informed": entry.informed}
    return facts | {"models": len(table.ranked)}, told


def markdown(tables: Sequence[TaskTable]) -> str:
    """Return all tables as one page."""
    lines = ["# Benchmark", "", NOTES, ""]
    heads = ("task", "data", "given", "best", "not told apart from it", "at best", "by chance")
    lines += [_row(*heads), "| --- " * len(heads) + "|"]
    for table in tables:
        first, task = table.ranked[0], table.task
        tied = ", ".join(f"`{name}`" for name in first.not_told_apart) or "–"
        main = first.results[0].main
        inputs = kind_of(task.kind).given_in(task)
        best = f"`{first.model}`{about_text(first)} {value_text(first)}"
        if table.best_new:
            best += f"; making something new: `{table.best_new.model}` {value_text(table.best_new)}"
        ends = map(number, (main.floor, main.ceiling))
        lines.append(_row(f"[{task.title}](#{task.name})", data_text(task), inputs, best, tied, *ends))
    for table in tables:
        lines += ["", *_section(table)]
    return "\n".join(lines) + "\n"


def _section(table: TaskTable) -> list[str]:
    task, kind = table.task, kind_of(table.task.kind)
    result = table.ranked[0].results[0]
    main, (name, *others) = result.main, list(result.figures)[: 1 + OTHERS]
    lines = [
        f"({task.name})=",
        f"## {task.title}",
        "",
        f"`{task.name}`: {data_text(task)}. Given {kind.given_in(task)}, a model returns {kind.asked}. "
        f"Figure: {main.title}{f', {main.unit}' if main.unit else ''}, {main.better} is better; {span_text(main)}.",
        "",
        _row("rank", "model", *map(heading, [name, *others]), "seeds", "training"),
        "| --- " * (5 + len(others)) + "|",
    ]
    for entry in table.ranked:
        model = f"`{entry.model}`{about_text(entry)}"
        figures = (value_text(entry), *(mean_text(entry, key) for key in others))
        lines.append(_row(entry.rank_text, model, *figures, str(len(entry.results)), training_text(entry)))
    if table.failed:
        lines += ["", "Without a result:", "", *(f"- `{r.model}`: {r.failed}" for r in table.failed)]
    return lines


def _row(*cells: str) -> str:
    return f"| {' | '.join(cells)} |"


def copies(entry: RankedModel) -> bool:
    """Return whether a model plays its training data.

    Its signals are then nearer to that than half way from unseen recordings to copies.
    """
    if entry.model in (*HOLDING_RECORDINGS, RANDOM):
        return True
    near = [r.figures["training_correlation"] for r in entry.results if "training_correlation" in r.figures]
    return bool(near) and all(figure.value > ((figure.floor or 0.0) + 1) / 2 for figure in near)


def about_text(entry: RankedModel) -> str:
    """Return what sets an entry apart: a baseline, answers from outside, or one that copies."""
    marks = ["copies"] if copies(entry) else []
    marks += (
        ["ignores what is given"]
        if entry.model in IGNORING
        else [entry.entry]
        if entry.entry != "model"
        else []
    )
    marks += ["no use of its input shown"] if entry.informed is False else []
    return f" ({', '.join(marks)})" if marks else ""


def data_text(task: BenchmarkTask) -> str:
    """Return what the data of a task is, simulated data marked as such."""
    marked = not task.data.simulated or "simulated" in task.data.what
    return task.data.what if marked else f"{task.data.what} (simulated)"


def value_text(entry: RankedModel) -> str:
    """Return the main figure, mean ± sd [interval], to two digits of half the interval's width."""
    width = 0.0 if entry.low is None or entry.high is None else (entry.high - entry.low) / 2
    places = min(3, max(0, 1 - math.floor(math.log10(width)))) if width else 3

    def told(value: float) -> str:
        return f"{value:.{places}f}"

    sd = "" if entry.sd is None else f" ± {told(entry.sd)}"
    interval = "" if entry.low is None or entry.high is None else f" [{told(entry.low)}, {told(entry.high)}]"
    return f"{told(entry.value)}{sd}{interval}"


def span_text(figure: Figure) -> str:
    """Return between which values a figure lies: the best to expect, and chance."""
    ends = (("at best", figure.floor), ("by chance", figure.ceiling))
    return ", ".join(f"{what} {number(value)}" for what, value in ends if value is not None)


def mean_of(entry: RankedModel, figure: str) -> float | None:
    """Return the mean of another figure over seeds; None where it is missing."""
    values = [result.figures[figure].value for result in entry.results if figure in result.figures]
    return sum(values) / len(values) if values else None


def mean_text(entry: RankedModel, figure: str) -> str:
    """Return `mean_of` as text."""
    return number(mean_of(entry, figure))


def training_text(entry: RankedModel) -> str:
    """Return the recipe, and the mean time of a training where it was measured."""
    times = [result.training_s for result in entry.results if result.training_s is not None]
    took = f", {sum(times) / len(times):.0f} s" if times else ""
    return f"{entry.results[0].recipe}{took}"


def heading(figure: str) -> str:
    """Return the heading of a column: the name of a figure, without what its unit says."""
    name = figure.removesuffix("_db").replace("_distance", "").replace("_", " ")
    return f"{name}, dB" if figure.endswith("_db") else name


def number(value: float | None) -> str:
    """Return a number with three significant digits; "–" for None."""
    return "–" if value is None else f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"

"""Reading of the items of a data set on Ray."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from functools import partial

from tactogram.datasets.importer import ImportItem
from tactogram.datasets.reading import Reading, read_item
from tactogram.errors import DataError
from tactogram.workflows.workers import in_order, run_tasks


def read_on(
    on: str,
    importer_name: str,
    items: Sequence[ImportItem],
    workers: int | None,
    progress: Callable[[int, int], None],
) -> Generator[tuple[ImportItem, Reading]]:
    """Yield each item as `read_all` does, read on Ray, whose nodes share the folder."""
    tasks = list(enumerate(items))
    outcomes = run_tasks(partial(_read, importer_name), tasks, on=on, name=_name, processes=workers or 1)
    for done, outcome in enumerate(in_order(outcomes), start=1):
        item = outcome.task[1]
        if outcome.value is None:
            raise DataError(f"{item.name}: {outcome.error}")
        yield item, outcome.value
        progress(done, len(items))


def _read(importer_name: str, task: tuple[int, ImportItem]) -> Reading:
    return read_item(importer_name, task[1])


def _name(task: tuple[int, ImportItem]) -> str:
    return task[1].name

"""Data of a task: its store, found by its hash or simulated again, the examples of each part, and rated items."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import (
    Examples,
    Ratings,
    Segment,
    Split,
    Store,
    label_of,
    open_store,
    part_examples,
    signal_kind,
)
from tactogram.errors import DataError, ParameterError
from tactogram.model import Example, SignalKind
from tactogram.plugins import further_folders
from tactogram.workflows import ProgressCallback, RatingData, silent
from tactogram_benchmark.task import BenchmarkTask, find_task
from tactogram_simulate import simulate_to_store

STORES_VARIABLE = "TACTOGRAM_STORES"
"""Environment variable with stores, or folders of stores, separated as in PATH."""


@dataclass(frozen=True)
class OpenTask:
    """A task with its data.

    ``folder`` is the work folder of the benchmark, where trainings and reference models are kept.
    """

    task: BenchmarkTask
    store: Store
    split: Split
    folder: Path

    def examples(self, part: str) -> Examples:
        """Return the examples of ``train``, ``validation`` or ``test``, prepared once for all tasks."""
        return part_examples(
            self.store, self.split, part, self.task.prepare, label=self.task.label, cache_dir=self.prepared
        )

    @property
    def prepared(self) -> Path:
        """Folder of prepared recordings, of all tasks and trainings."""
        return self.folder / "prepared"

    @cached_property
    def test(self) -> Sequence[Example]:
        """The test examples, each prepared once."""
        return list(self.examples("test"))

    @cached_property
    def train(self) -> Sequence[Example]:
        """The training examples, each prepared once."""
        return list(self.examples("train"))

    def by_material(self, part: Literal["train", "test"]) -> dict[str, list[Example]]:
        """Return the examples of a part by material, without those of none."""
        examples: dict[str, list[Example]] = {}
        for example in self.train if part == "train" else self.test:
            if example.material is not None:
                examples.setdefault(example.material, []).append(example)
        return examples

    def counts(self, part: str) -> Counter[str]:
        """Return the number of recordings of each material in a part, without reading them."""
        return Counter(str(label_of(info, self.task.label)) for info in self.examples(part).infos)

    @cached_property
    def materials(self) -> tuple[str, ...]:
        """Materials of the training part, sorted."""
        return self.examples("train").materials

    @cached_property
    def kind(self) -> SignalKind:
        """The kind of all signals of the task."""
        part = "train" if self.split.train else "test"
        return signal_kind(self.examples(part), simulated=self.store.simulated)


def open_task(
    task: BenchmarkTask,
    folder: Path,
    stores: Sequence[Path | str] = (),
    *,
    progress: ProgressCallback = silent,
) -> OpenTask:
    """Return a task with its data; simulated data is made in ``folder`` if it is nowhere.

    Raises
    ------
    DataError
        If recorded data is not available, or simulated data has another hash on this machine.
    LeakError
        If the split leaks.
    """
    split = task.load_split()
    store = find_store(task, (folder / "stores", *further_folders(STORES_VARIABLE, stores)))
    if store is None and task.data.simulated:
        store = _simulated(task, folder / "stores", progress)
    if store is None:
        raise DataError(
            task.name,
            f"needs {task.data.name} (SHA-256 {task.data.sha256[:12]}…), which is not available; "
            f"import it by `tactogram data import {task.data.importer} PATH --out DIR` and name its folder with "
            "`--stores`",
        )
    ids = {segment.id for part in split.parts.values() for segment in part}
    if missing := [id for id in ids if id not in store]:
        raise DataError(
            task.name, f"{len(missing)} recordings of its split are not in {store.path} ({missing[0]}, …)"
        )
    return OpenTask(task, store, split, folder)


def open_named(name: str, folder: Path | str, progress: ProgressCallback | None) -> OpenTask:
    """Return the task called ``name`` with its data, as `open_task`."""
    return open_task(find_task(name), Path(folder), progress=progress or silent)


def find_store(task: BenchmarkTask, places: Sequence[Path]) -> Store | None:
    """Return the store of a task, by its hash, in ``places`` or the folders in them; None if there is none."""
    for folder in places:
        for file in (folder / "dataset.json", *sorted(folder.glob("*/dataset.json"))):
            if not file.is_file():
                continue
            try:
                store = open_store(file.parent)
            except DataError:
                continue
            if store.sha256 == task.data.sha256:
                return store
    return None


def _simulated(task: BenchmarkTask, folder: Path, progress: ProgressCallback) -> Store:
    arguments = dict(task.data.simulate)
    if "set_name" not in arguments:
        raise ParameterError(f"{task.name}: data.simulate must name the set as set_name")
    path = folder / f"{arguments['set_name']}-{task.data.sha256[:12]}"
    if not (path / "dataset.json").is_file():
        simulate_to_store(**arguments, out=path, progress=progress)
    store = open_store(path)
    if store.sha256 != task.data.sha256:
        raise DataError(
            path,
            f"simulated data must have SHA-256 {task.data.sha256[:12]}… as {task.file.name} states, got "
            f"{store.sha256[:12]}…: the simulator or its numerical libraries are of another version",
        )
    return store


def ratings_of(opened: OpenTask) -> Ratings:
    """Return the ratings of a task's store; a `ParameterError` if it has none."""
    return RatingData(opened.store, "ratings").ratings


def rated_surfaces(opened: OpenTask) -> tuple[Segment, ...]:
    """Return recordings of rated surfaces beside the rated signals of a task, from which some models learn, too."""
    split, ratings = opened.split, opened.store.ratings
    parts = {segment.id for part in split.parts.values() for segment in part}
    infos = opened.store.index
    if ratings is None or any(info.material is not None for info in infos if info.id in parts):
        return ()
    return tuple(Segment(info.id) for info in infos if info.material in ratings.items)


def rated_examples(opened: OpenTask, part: str) -> Sequence[Any]:
    """Return the rated examples of a part: of `Example`, or of `ImageExample` in a store of images."""
    return RatingData(opened.store, "ratings").examples(opened.split, part, opened.task.prepare)


def items_of(examples: Sequence[Any]) -> list[str]:
    """Return the names of the rated items of examples, sorted."""
    return sorted({str(example.item) for example in examples})


def mean_scores(opened: OpenTask, items: Sequence[str]) -> NDArray[np.float64]:
    """Return the mean scores of items on the scale of the ratings, float64, shape (item, word)."""
    ratings = ratings_of(opened)
    rows: NDArray[np.float64] = np.stack(
        [ratings.scale.from_unit(ratings.rated(item).means) for item in items]
    )
    return rows

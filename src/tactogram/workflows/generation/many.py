"""Signals and images for every condition of a table, on several processes or machines."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any, get_origin

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, create_model

from tactogram.datasets.examples import cores
from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.model import check_options, condition_options
from tactogram.parameters import checked
from tactogram.recipe import run_id
from tactogram.signal.io.atomic import check_writable, write_text
from tactogram.text_files import read_table, read_toml
from tactogram.validation import validated
from tactogram.workflows.generation.generate import (
    SIMULATED,
    Reading,
    check_suffix,
    checked_condition,
    generate_files,
    suffixes_for,
)
from tactogram.workflows.generation.word_scores import needs_words
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.loaded_run import LoadedRun, load_run
from tactogram.workflows.workers import absolute
from tactogram.workflows.workers.tasks import kept_values

CHUNK = 16
"""Conditions of a task: loading a run costs more than a signal."""


@dataclass(frozen=True)
class ConditionRow:
    """A row of the table: options of ``tactogram generate``, by the same names."""

    file: str
    options: Mapping[str, Any]
    """Of the condition."""
    seconds: float | None = None
    seed: int | None = None


def _weights(value: Any) -> Any:
    """Read ``cork=0.6,tile=0.4``, as a cell of a CSV file has it."""
    if not isinstance(value, str):
        return value
    pairs = [pair.rpartition("=") for pair in value.split(",")]
    return {name.strip(): weight for name, _, weight in pairs}


def _columns() -> type[BaseModel]:
    """Return the type of a row's values."""
    columns: dict[str, Any] = {
        name: (
            Annotated[option.kind, BeforeValidator(_weights)] | None
            if get_origin(option.kind) is Mapping
            else option.kind | None,
            None,
        )
        for name, (_, option) in condition_options().items()
    }
    return create_model(
        "ConditionColumns",
        __config__=ConfigDict(frozen=True, extra="forbid"),
        file=(str, ""),
        seconds=(float | None, None),
        seed=(Annotated[int, Field(ge=0)] | None, None),
        **columns,
    )


def read_conditions(path: Path, *, suffix: str) -> list[ConditionRow]:
    """Return the rows of a CSV file with a heading, or of ``[[condition]]`` in a TOML file.

    Those without ``file`` are named by their number; paths in the table are relative to it.

    Raises
    ------
    ParameterError
        If a row has an unknown column, or a wrong value.
    DataError
        If the file has no row, two rows for one file, or two options of one condition in a row.
    """
    if path.suffix.lower() == ".toml":
        tables = read_toml(path).get("condition", [])
        numbered = list(enumerate(tables if isinstance(tables, list) else [tables], start=1))
    else:
        numbered = [
            (number, {name: cell for name, cell in cells.items() if cell})
            for number, cells in read_table(path)
        ]
    if not numbered:
        raise DataError(path, "must have a condition in each row (TOML: [[condition]]), found none")
    width, rows, columns = len(str(len(numbered))), [], _columns()
    for position, (number, values) in enumerate(numbered, start=1):
        where = f"{path}: row {number}"
        stated = validated(columns, values, where=where).model_dump(exclude_none=True)
        try:
            check_options(stated)
        except ParameterError as error:
            raise DataError(where, error) from error
        own = {name: stated.pop(name, None) for name in ("file", "seconds", "seed")}
        for name, (_, option) in condition_options().items():
            if option.file and name in stated and stated[name] != SIMULATED:
                stated[name] = absolute(path.parent / stated[name])
        rows.append(
            ConditionRow(own["file"] or f"{position:0{width}}{suffix}", stated, own["seconds"], own["seed"])
        )
    if len({row.file for row in rows}) < len(rows):
        raise DataError(path, "every row must have a file of its own")
    return rows


@dataclass(frozen=True)
class _Chunk:
    run: str
    out: str
    rows: Sequence[ConditionRow]

    @property
    def name(self) -> str:
        first, last = self.rows[0].file, self.rows[-1].file
        return first if len(self.rows) == 1 else f"{first} to {last}"


@checked
def generate_many(
    run: Path | str,
    conditions: Path | str,
    out: Path | str,
    *,
    seconds: float | None = None,
    seed: int = 0,
    on: str = "",
    processes: int | None = None,
    progress: ProgressCallback = silent,
) -> list[dict[str, Any]]:
    """Write a file per condition of a table into the folder ``out``, each as `generate_files` alone would.

    ``seconds`` and ``seed`` are those of the rows that have none. A call that was killed goes on when it is made again.
    On a cluster, ``run`` and ``out`` are in a folder that all nodes share.

    Returns
    -------
    list of dict
        As `generate_files`, in the order of the table; also in ``generated.json`` in ``out``.

    Raises
    ------
    DataError, ParameterError
        As `read_conditions`; if the run needs scores of all its words; or a condition is not for its model.
    """
    loaded, folder = load_run(run), Path(out)
    if needs_words(loaded):
        raise ParameterError.must(
            "conditions", f"not be for a model that needs scores of words, as {loaded.run.name}"
        )
    check_writable(folder, folder=True)
    rows = read_conditions(Path(conditions), suffix=suffixes_for(loaded.facts.gives)[0])
    rows = [
        replace(row, seconds=row.seconds or seconds, seed=seed if row.seed is None else row.seed)
        for row in rows
    ]
    for row in rows:
        try:
            _check_row(loaded, row, folder)
        except TactogramError as error:
            raise ParameterError(row.file, error) from error
    kept = folder / "made"
    chunks = [
        _Chunk(
            absolute(run) if Path(run).exists() else str(run), absolute(folder), rows[first : first + CHUNK]
        )
        for first in range(0, len(rows), CHUNK)
    ]
    identity = {"run": loaded.run.data["run_id"]}
    ids = [run_id(identity | {"rows": [asdict(row) for row in chunk.rows]}, "") for chunk in chunks]
    values = kept_values(
        _made,
        chunks,
        [kept / f"{id}.json" for id in ids],
        title="generate",
        name=lambda chunk: chunk.name,
        on=on,
        processes=processes or min(cores(), len(chunks)),
        progress=progress,
    )
    files: list[dict[str, Any]] = [file for value in values for file in value["files"]]
    write_text(folder / "generated.json", json.dumps(files, indent=1) + "\n")
    shutil.rmtree(kept)
    return files


def _made(chunk: _Chunk) -> dict[str, Any]:
    """Write the files of some rows; return their facts."""
    loaded, files = load_run(chunk.run), []
    for row in chunk.rows:
        target, seed = Path(chunk.out) / row.file, row.seed or 0
        files += generate_files(loaded, {}, target, seconds=row.seconds, seed=seed, options=row.options)
    return {"files": files}


def _check_row(run: LoadedRun, row: ConditionRow, folder: Path) -> None:
    """Refuse a row that `generate_files` would refuse, so that no file of the others is written before."""
    check_suffix(run, folder / row.file)
    check_writable(folder / row.file)
    seed = row.seed or 0
    checked_condition(run, Reading(run, {}, row.seconds, seed).condition(row.options), row.seconds, seed)

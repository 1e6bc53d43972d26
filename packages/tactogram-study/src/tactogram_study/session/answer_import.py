"""Import of tables of answers from other programs.

lab.js and spreadsheets write one row per trial under their own headings; a mapping assigns headings to columns. Other
columns are kept unchanged. Ratings in exports of PsychoPy, jsPsych, Qualtrics and Google Forms need none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from tactogram.datasets import (
    MISSING,
    Export,
    Questions,
    RatingColumns,
    Scale,
    export_of,
    read_cells,
    rows_left_out,
)
from tactogram.errors import DataError, Message, ParameterError, Remedy
from tactogram_study.answers import COLUMNS, KINDS, Answers, answers_of

ANY_NUMBER = Scale("any number", -1e300, 1e300)
TRUE, FALSE = ("true", "1", "yes", "correct", "t"), ("false", "0", "no", "wrong", "incorrect", "f")


@dataclass(frozen=True)
class TableMapping:
    """Mapping from another program's table to answers.

    ``columns`` are the table's headings by our columns, as ``{"participant": "subject"}``, where they differ;
    ``constants`` are values of a column in every row, as ``{"question": "which"}``. The encoding is detected if it is
    empty.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    constants: Mapping[str, str] = field(default_factory=dict)
    encoding: str = ""

    def __post_init__(self) -> None:
        for name in (*self.columns, *self.constants):
            if name not in COLUMNS:
                raise ParameterError(f"a column must be one of {', '.join(COLUMNS)}, got {name!r}")
        if both := set(self.columns) & set(self.constants):
            raise ParameterError(
                f"{', '.join(sorted(both))} is given as a column and as a constant; remove one"
            )


def import_answers(path: Path, mapped: TableMapping | None = None) -> Answers:
    """Return the answers of another program's table (``.csv``, ``.tsv`` or ``.parquet``).

    A missing ``answer`` is filled from ``value``, and ``value`` from an ``answer`` that is a number; ``study`` defaults
    to the file's name; without ``trial``, the rows of each participant are counted. Raises `DataError` if a mapped
    heading or a required column is missing, or a cell is not of its column's type.
    """
    mapped = mapped or TableMapping()
    taken = {*mapped.columns, *mapped.constants}
    rated = not taken & {"question", "answer", "value", "correct"}
    export = export_of(path, read_cells(path, encoding=mapped.encoding), low=0.0 if rated else None)
    headings = [*filter(None, export.headings)]
    for ours, theirs in mapped.columns.items():
        if theirs not in headings:
            raise DataError(path, f"has no column {theirs!r} for {ours}, has {', '.join(headings)}")
    ours_of = {theirs: ours for ours, theirs in mapped.columns.items()}
    # A heading that equals a column but is mapped otherwise is kept under another name.
    named = [ours_of.get(h, f"their_{h}" if h in taken else h) for h in export.headings]
    numbers = [number for number, _ in export.rows]
    tables = [dict(zip(named, map(_plain, row), strict=True)) for _, row in export.rows]
    if not tables:
        raise DataError(path, "holds no row below its headings")
    if export.program and rated:
        numbers, tables = _ratings(export, mapped, dict(zip(numbers, tables, strict=True)))
    rows = list(zip(numbers, tables, strict=True))
    empty = [
        number for number, row in rows if not any(map(row.get, ("stimulus", "answer", "value", "correct")))
    ]
    export.notes += rows_left_out("without stimulus and answer", empty)
    rows = [(number, row) for number, row in rows if number not in empty]
    for number, row in rows:
        row.update(mapped.constants)
        _complete(row, path, number)
    _count_trials([row for _, row in rows])
    full = list(dict.fromkeys(name for _, row in rows for name in row))
    cells = [(number, [row.get(name, "") for name in full]) for number, row in rows]
    return replace(
        answers_of(full, cells, where=str(path)),
        notes=tuple(note.problem if isinstance(note, Message) else note for note in export.notes),
    )


def _ratings(
    export: Export, mapped: TableMapping, tables: Mapping[int, dict[str, str]]
) -> tuple[list[int], list[dict[str, str]]]:
    """Return the rows of an export as one for each rating, with the other columns of their row."""
    theirs = {"participant": "rater", "stimulus": "item", "session": "session"}
    named = {theirs[ours]: heading for ours, heading in mapped.columns.items() if ours in theirs}
    try:
        columns = RatingColumns(named=named, ignored=("*", *mapped.columns.values()))
        (_, rows, export.notes), _ = Questions(export, columns, ANY_NUMBER).read()
    except DataError as error:
        raise DataError(
            export.path,
            f"{export.program}: ratings are not recognised",
            remedy=(
                Remedy(
                    "say which columns are participant, stimulus, question and value,",
                    "columns",
                    "NAME=HEADING",
                ),
                Remedy("of which question all are,", "constants", "question=WORD"),
            ),
        ) from error
    ratings = []
    for number, (person, item, word, score, _, session) in rows:
        row = {"participant": person, "stimulus": item, "question": word, "value": score, "session": session}
        others = {
            name: cell for name, cell in tables[number].items() if "@" not in cell
        }  # no e-mail addresses
        ratings.append(others | {name: cell for name, cell in row.items() if cell})
    return [number for number, _ in rows], ratings


def _plain(cell: str) -> str:
    return "" if cell.strip().casefold() in MISSING else cell.strip()


def _complete(row: dict[str, str], path: Path, number: int) -> None:
    row.setdefault("study", path.stem)
    row.setdefault("design", "")
    row.setdefault("question", "")
    if not row.get("participant"):
        raise DataError(f"{path}: row {number}", "participant must not be empty; say which column it is")
    if not (row.get("answer") or row.get("value") or row.get("correct")):
        row["answer"] = ""
    if row.get("correct"):
        text = row["correct"].casefold()
        if text not in (*TRUE, *FALSE):
            raise DataError(f"{path}: row {number}", f"correct must be true or false, got {row['correct']!r}")
        row["correct"] = "true" if text in TRUE else "false"
    if not row.get("value"):
        row["value"] = _number(row.get("answer", "")) or {"true": "1", "false": "0"}.get(
            row.get("correct", ""), ""
        )
    if not row.get("answer"):
        row["answer"] = row.get("value", "")
    for name, kind in KINDS.items():
        if kind == "int" and row.get(name) and _number(row[name]).endswith(".0"):
            row[name] = row[name].partition(".")[0]


def _count_trials(rows: list[dict[str, str]]) -> None:
    """Set the trials to counts of each participant's rows if no row has one."""
    if any(row.get("trial") for row in rows):
        return
    counts: dict[str, int] = {}
    for row in rows:
        counts[row["participant"]] = counts.get(row["participant"], 0) + 1
        row["trial"] = str(counts[row["participant"]])


def _number(text: str) -> str:
    try:
        return repr(float(text))
    except ValueError:
        return ""

"""Import of tables of answers from other programs.

jsPsych, lab.js, PsychoPy, Qualtrics and spreadsheets write one row per trial under their own headings; a mapping
assigns headings to columns. Other columns are kept unchanged.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tactogram.errors import DataError, ParameterError
from tactogram.study.answers import COLUMNS, KINDS, Answers, answers_of, read_cells

MISSING = ("", "na", "n/a", "nan", "none", "null", "-")
"""Cells without a value, in any case."""
TRUE, FALSE = ("true", "1", "yes", "correct", "t"), ("false", "0", "no", "wrong", "incorrect", "f")


@dataclass(frozen=True)
class TableMapping:
    """Mapping from another program's table to answers.

    ``columns`` are the table's headings by our columns, as ``{"participant": "subject"}``, where they differ;
    ``constants`` are values of a column in every row, as ``{"question": "which"}``; ``values`` are meanings of cells by
    column, as ``{"condition": {"0": "recorded"}}``. Japanese Excel writes ``cp932``.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    constants: Mapping[str, str] = field(default_factory=dict)
    values: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    encoding: str = "utf-8-sig"

    def __post_init__(self) -> None:
        for name in (*self.columns, *self.constants, *self.values):
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
    headings, rows = read_cells(path, encoding=mapped.encoding)
    for ours, theirs in mapped.columns.items():
        if theirs not in headings:
            raise DataError(f"{path}: has no column {theirs!r} for {ours}, has {', '.join(headings)}")
    ours_of = {theirs: ours for ours, theirs in mapped.columns.items()}
    # A heading that equals a column but is mapped otherwise is kept under another name.
    taken = {*mapped.columns, *mapped.constants}
    named = [ours_of.get(h, f"their_{h}" if h in taken else h) for h in headings]
    tables = [dict(zip(named, (_plain(cell) for cell in row), strict=True)) for row in rows]
    if not tables:
        raise DataError(f"{path}: holds no row below its headings")
    for number, row in enumerate(tables, 2):
        row.update(mapped.constants)
        for name, meanings in mapped.values.items():
            if row.get(name, "") in meanings:
                row[name] = meanings[row[name]]
        _complete(row, path, number)
    _count_trials(tables)
    full = list(dict.fromkeys(name for row in tables for name in row))
    return answers_of(full, [[row.get(name, "") for name in full] for row in tables], where=str(path))


def _plain(cell: str) -> str:
    return "" if cell.strip().casefold() in MISSING else cell.strip()


def _complete(row: dict[str, str], path: Path, number: int) -> None:
    row.setdefault("study", path.stem)
    row.setdefault("design", "")
    row.setdefault("question", "")
    if not row.get("participant"):
        raise DataError(f"{path}: row {number}: participant must not be empty; say which column it is")
    if not (row.get("answer") or row.get("value") or row.get("correct")):
        row["answer"] = ""
    if row.get("correct"):
        text = row["correct"].casefold()
        if text not in (*TRUE, *FALSE):
            raise DataError(f"{path}: row {number}: correct must be true or false, got {row['correct']!r}")
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

"""Tables of answers that other programs wrote, read as ours.

jsPsych, lab.js, PsychoPy, Qualtrics and spreadsheets write one row per trial, under their own headings; a mapping says
which heading is which column. Columns that are not named are kept as they are.
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

    Parameters
    ----------
    columns : mapping from str to str
        The table's heading of each of our columns, as ``{"participant": "subject", "value": "response"}``. A heading
        that is called as ours needs no entry.
    constants : mapping from str to str
        What a column holds in every row: ``{"question": "which"}``.
    values : mapping from str to mapping
        What a cell means, by our column: ``{"condition": {"0": "recorded", "1": "generated"}}``.
    encoding : str
        Of a CSV or TSV file; ``cp932`` is what Japanese Excel writes.
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
                f"{', '.join(sorted(both))} is given as a column and as a constant; leave one out"
            )


def import_answers(path: Path, mapped: TableMapping | None = None) -> Answers:
    """Return another's table as ours.

    ``answer`` is filled from ``value`` where only that is there, and the other way round where it is a number;
    ``study`` is the file's name and ``question`` the design's first where nothing says them; ``trial`` counts the rows
    of each participant where it is not given.

    Parameters
    ----------
    path : Path
        ``.csv``, ``.tsv`` or ``.parquet``.
    mapped : Mapped, optional

    Raises
    ------
    DataError
        If a heading is not there, a column that is needed is neither there nor given, or a cell is not what its column
        holds.
    """
    mapped = mapped or TableMapping()
    headings, rows = read_cells(path, encoding=mapped.encoding)
    for ours, theirs in mapped.columns.items():
        if theirs not in headings:
            raise DataError(f"{path}: has no column {theirs!r} for {ours}, has {', '.join(headings)}")
    ours_of = {theirs: ours for ours, theirs in mapped.columns.items()}
    # A heading that is ours in name but was mapped otherwise is kept under another name.
    taken = {*mapped.columns, *mapped.constants}
    named = [ours_of.get(h, f"their_{h}" if h in taken else h) for h in headings]
    tables = [dict(zip(named, (_plain(cell) for cell in row), strict=True)) for row in rows]
    if not tables:
        raise DataError(f"{path}: holds no row below its headings")
    for number, row in enumerate(tables, 2):
        row.update(mapped.constants)
        for name, meant in mapped.values.items():
            if row.get(name, "") in meant:
                row[name] = meant[row[name]]
        _completed(row, path, number)
    _numbered(tables)
    full = list(dict.fromkeys(name for row in tables for name in row))
    return answers_of(full, [[row.get(name, "") for name in full] for row in tables], where=str(path))


def _plain(cell: str) -> str:
    return "" if cell.strip().casefold() in MISSING else cell.strip()


def _completed(row: dict[str, str], path: Path, number: int) -> None:
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


def _numbered(rows: list[dict[str, str]]) -> None:
    """Count the rows of each participant where no trial is given."""
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

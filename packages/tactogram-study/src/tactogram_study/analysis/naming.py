"""Names in an analysis: computations keep the keys of a study's file, reports and figures have its names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from tactogram_study.analysis.findings import AnalysisSection, Finding
from tactogram_study.answers import Answers

NAMED_COLUMNS = ("texture", "item", "stimulus", "image", "condition")
"""Columns of any design's tables that hold keys."""
TABLE_PARTS = (" n", " mean", " se")
"""Suffixes of a condition in the heading of a column."""


def named_section(
    section: AnalysisSection, names: Mapping[str, str], *, columns: Iterable[str] = ()
) -> AnalysisSection:
    """Return a section whose findings and tables have the names of items and conditions, by key.

    ``columns`` are further columns of its tables that hold keys.
    """
    if not names:
        return section
    # Longest first, and whole words only: tile is not part of tile-2.
    keys = "|".join(re.escape(key) for key in sorted(names, key=len, reverse=True))
    pattern = re.compile(rf"(?<![\w-])(?:{keys})(?![\w-])")

    def named(text: str) -> str:
        return pattern.sub(lambda found: names[found.group()], text)

    def finding(one: Finding) -> Finding:
        return replace(one, of=named(one.of), measure=named(one.measure))

    key_columns = {*NAMED_COLUMNS, *columns}

    def cell(column: str, value: Any) -> Any:
        return named(value) if column in key_columns and isinstance(value, str) else value

    def heading(column: str) -> str:
        return named(column) if column.endswith(TABLE_PARTS) else column

    tables = {
        title: [{heading(column): cell(column, value) for column, value in row.items()} for row in rows]
        for title, rows in section.tables.items()
    }
    return replace(
        section,
        title=named(section.title) if ":" in section.title else section.title,
        findings=tuple(finding(one) for one in section.findings),
        tables=tables,
    )


def named_answers(answers: Answers, names: Mapping[str, str]) -> Answers:
    """Return answers with named conditions, for figures that draw single answers of a named section."""
    if not names:
        return answers
    return Answers(tuple(replace(row, condition=names.get(row.condition, row.condition)) for row in answers))

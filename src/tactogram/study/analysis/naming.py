"""An analysis in the names that a study's file gives: what is computed keeps the keys, what is read has names."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from tactogram.study.analysis.findings import AnalysisSection, Finding
from tactogram.study.answers import Answers

NAMED_COLUMNS = ("texture", "item", "stimulus", "image", "condition", "staircase")
"""Of the tables of a section."""
TABLE_PARTS = (" n", " mean", " se")
"""What follows a condition in the heading of a column."""


def named_section(section: AnalysisSection, names: Mapping[str, str]) -> AnalysisSection:
    """Return a section with what it is of, and its tables, in the names of items and conditions.

    Parameters
    ----------
    section : Section
    names : mapping from str to str
        By key, as `Study.names_in` returns them.
    """
    if not names:
        return section
    # Longest first, and whole words only: tile is not part of tile-2.
    known = "|".join(re.escape(key) for key in sorted(names, key=len, reverse=True))
    pattern = re.compile(rf"(?<![\w-])(?:{known})(?![\w-])")

    def named(text: str) -> str:
        return pattern.sub(lambda found: names[found.group()], text)

    def finding(one: Finding) -> Finding:
        return replace(one, of=named(one.of), measure=named(one.measure))

    def cell(column: str, value: Any) -> Any:
        return named(value) if column in NAMED_COLUMNS and isinstance(value, str) else value

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
    """Return answers whose conditions have names: for figures that draw single answers beside a named section."""
    if not names:
        return answers
    return Answers(tuple(replace(row, condition=names.get(row.condition, row.condition)) for row in answers))

"""Exports of questionnaires, without the rows that hold no answers: PsychoPy, jsPsych, Qualtrics and Google Forms."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactogram.datasets.cells import Cells, cell_text
from tactogram.errors import DataError, Message, Remedy

_STAMP = re.compile(
    "timestamp|zeitstempel|horodateur|marca temporal|tijdstempel|タイムスタンプ|时间戳记", re.I
)
_DATED = ("StartDate", "EndDate", "RecordedDate", "ResponseId")
_FIRST = (*_DATED, "Finished", "DistributionChannel", "UserLanguage")
"""Columns of Qualtrics that come before those of questions."""
_NO_QUESTION = re.compile(r".*_(TEXT|DO(_.+)?|First Click|Last Click|Page Submit|Click Count)")
_PREVIEW = ("previews", "1|2|8|9|12|17|.*(preview|test|spam).*")
_LEFT_OUT = {
    "Status": _PREVIEW,
    "DistributionChannel": _PREVIEW,
    "Finished": ("unfinished answers", "false|0"),
}
"""States of answers of Qualtrics that do not count, in numbers and in words."""
_RATED = re.compile("likert|slider|vas|survey(?!-(text|multi))"), re.compile("button-response")
_FROM_ZERO = re.compile("likert|button-response")


@dataclass
class Export:
    """Table of a ``program``, "" if unknown: ``labels`` are the questions, ``asked`` the columns of answers."""

    path: Path
    headings: list[str]
    rows: list[tuple[int, list[str]]]
    notes: list[str]
    program: str = ""
    labels: list[str] = field(default_factory=list)
    asked: list[int] = field(default_factory=list)

    @property
    def by_trial(self) -> bool:
        """Whether a row is a trial; else it is a person."""
        return self.program in ("PsychoPy", "jsPsych")

    def leave_out(self, what: str, numbers: Sequence[int], *remedies: Remedy) -> None:
        """Leave out rows by number, and note ``what`` they are."""
        self.notes += rows_left_out(what, numbers, *remedies)
        self.rows = [(number, row) for number, row in self.rows if number not in set(numbers)]


def rows_left_out(what: str, numbers: Sequence[int], *remedies: Remedy) -> list[Message]:
    """Return the note on rows that are left out, if there are any."""
    if not numbers:
        return []
    return [Message(f"rows left out {what}: {len(numbers)}, the first is row {numbers[0]}", *remedies)]


def export_of(path: Path, table: Cells, *, low: float | None, ignored: Sequence[str] = ()) -> Export:
    """Return the rows that hold answers; positions on a scale, which jsPsych counts from 0, begin with ``low``.

    If that is None, the trials of jsPsych are kept as they are. Of Qualtrics, previews and unfinished answers are left
    out unless the columns that tell are ``ignored``.
    """
    export, names = Export(path, *table, labels=[*table.headings]), table.headings
    if {"trial_type", "trial_index"} <= set(names):
        export.program = "jsPsych"
        if low is not None:
            _divide_responses(export, low)
    elif "psychopyVersion" in names or any(name.endswith(".thisN") for name in names):
        export.program = "PsychoPy"
        export.asked = [n for n, name in enumerate(names) if name.endswith(".response")]
    elif "ResponseId" in names or {"StartDate", "EndDate"} <= set(names):
        export.program = "Qualtrics"
        _leave_out_previews(export, ignored)
        begin = max(names.index(name) for name in _FIRST if name in names) + 1
        export.asked = [n for n, name in enumerate(names) if n >= begin and not _NO_QUESTION.fullmatch(name)]
    elif _STAMP.fullmatch(names[0]) and not {"rater", "item"} & set(names):
        export.program = "Google Forms"
        export.asked = [n for n, name in enumerate(names) if n and name != "Score"]
    return export


def _divide_responses(export: Export, low: float) -> None:
    """Keep the trials of jsPsych that ask for ratings, with a column for each name in their responses."""
    kind = export.headings.index("trial_type")
    types = dict.fromkeys(row[kind] for _, row in export.rows)
    rated = next((matching for form in _RATED if (matching := [*filter(form.search, types)])), [])
    response = next((n for n, name in enumerate(export.headings) if name in ("response", "responses")), None)
    if response is None or not rated:
        raise DataError(
            export.path, f"jsPsych: no trial asks for ratings, as survey-likert, but {', '.join(types)}"
        )
    others = ", ".join(name for name in types if name not in rated)
    export.leave_out(f"of other plugins ({others})", [n for n, row in export.rows if row[kind] not in rated])
    responses = [dict(_answers("", row[response])) for _, row in export.rows]
    names = [name for name in dict.fromkeys(name for answers in responses for name in answers) if name]
    raised = 0
    for (_, row), answers in zip(export.rows, responses, strict=True):
        for name, text in answers.items():
            if low and text.isdecimal() and _FROM_ZERO.search(row[kind]):
                answers[name], raised = f"{int(text) + low:g}", raised + 1
        row[response] = answers.get("", "")
        row += [answers.get(name, "") for name in names]
    if raised:
        export.notes.append(
            f"scores raised by {low:g}, as {', '.join(filter(_FROM_ZERO.search, rated))} counts from 0: {raised}"
        )
    export.asked = [response, *range(len(export.headings), len(export.headings) + len(names))]
    export.headings += [name if name not in export.headings else f"response.{name}" for name in names]
    export.labels = [*export.headings]


def _answers(name: str, response: Any) -> Iterator[tuple[str, str]]:
    """Yield the answers in a response by name; a single one has none."""
    if isinstance(response, str) and response.startswith("{"):
        with suppress(ValueError):
            response = json.loads(response)
    if not isinstance(response, dict):
        yield name, cell_text(response)
        return
    for inner, answer in response.items():
        yield from _answers(f"{name}.{inner}" if name else inner, answer)


def _leave_out_previews(export: Export, ignored: Sequence[str]) -> None:
    """Take the questions from the rows of Qualtrics below the headings; leave out previews and unfinished answers."""
    first = next(n for n, name in enumerate(export.headings) if name in _DATED)
    texts = [(number, row) for number, row in export.rows[:2] if not re.match(r"R_|\d", row[first])]
    export.labels = next((row for _, row in texts if not row[first].startswith("{")), export.labels)
    export.leave_out("of questions and their identifiers", [number for number, _ in texts])
    for name, (what, form) in _LEFT_OUT.items():
        if name in export.headings and name not in ignored:
            n = export.headings.index(name)
            gone = [number for number, row in export.rows if re.fullmatch(form, row[n], re.I)]
            export.leave_out(f"of {what}", gone, Remedy("keep them by", "ignore", name))

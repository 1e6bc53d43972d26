"""Remedies of an import, in words of the command line."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from tactogram.cli.functions import FunctionVerb, flags_of
from tactogram.cli.verbs import with_options
from tactogram.datasets.reading import in_one_line

_MAPPING = "`--preview --save-mapping mapping.toml`"
REMEDIES = (
    (r"`path=([^`]+)`", r"`--set path=\1`"),
    (
        r"which array\? choose of (.+)",
        rf"has several arrays (\1); choose in the mapping that {_MAPPING} writes",
    ),
    (
        r"which sheet\? choose of (.+?), e\.g\. `[^`]*`",
        r"has several sheets (\1); save the one to read as a file of its own",
    ),
    (r"; choose those of one as axes", f"; choose those of one in the mapping that {_MAPPING} writes"),
    (
        r"choose the columns to read",
        f"correct it, or remove its column from the axes of the mapping that {_MAPPING} writes",
    ),
    (
        r"; leave the (rate|unit) out(, then resample)?",
        r"; omit `--set \1=…`, or state it in recordings.csv for the files that lack it",
    ),
    (
        r"; give the rate instead",
        f"; give the rate instead of the time in the mapping that {_MAPPING} writes",
    ),
    (
        r"omit (it|them|the column) from (?:the|a) mapping",
        rf"remove \1 from the mapping that {_MAPPING} writes",
    ),
)
"""What readers advise, and what can be typed instead."""


def in_words_of_the_command(reason: str, verb: FunctionVerb) -> str:
    """Return why something cannot be imported, with a remedy that can be typed."""
    for pattern, remedy in REMEDIES:
        reason = re.sub(pattern, remedy, reason)
    return with_options(reason, flags_of(verb))


def said_of_files(report: Mapping[str, Any], verb: FunctionVerb) -> list[str]:
    """Return a line for each kind of what is skipped, noted and asked in the report of an import or preview."""
    lines = [f"skipped: {in_one_line(kind)}" for kind in report["problems"]]
    lines += [f"note: {in_one_line(kind)}" for kind in report["notes"]]
    if question := report.get("question"):
        lines.append(f"to answer: {question}")
    return [in_words_of_the_command(line, verb) for line in lines]

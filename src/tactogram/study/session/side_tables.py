"""Participant and note tables of a session."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from tactogram.signal.io.atomic import atomic_write
from tactogram.study.session.device_facts import COLUMN, described, fact_text
from tactogram.study.session.store import SessionStore

Table = tuple[list[str], list[list[str]]]
"""Headings, and rows as text."""
PARTICIPANTS, NOTES = ".participants.csv", ".notes.csv"
"""In the place of a table's suffix."""
DESCRIPTIONS = {
    "participant": "Code of the participant",
    "number": "In the order of enrolment; the counterbalancing follows it",
    "language": "Of the pages",
    "simulated": "Whether it is a simulated participant",
    "status": "How the session stands",
    "trials": "Trials that were answered",
    "text": "What the experimenter wrote down",
    "at": "When it was written, UTC, by the clock of then",
}


def participants_table(store: SessionStore) -> Table:
    """Return a row per participant, with what the device said as they began (``device_…``)."""
    known = store.progress()
    devices = {
        one["participant"]: {
            name: fact
            for said in store.device_log(one["participant"])
            if said["token"] == ""
            for name, fact in said["facts"].items()
        }
        for one in known
    }
    facts = sorted({name for device in devices.values() for name in device})
    rows = [
        [
            one["participant"],
            str(one["number"]),
            one["language"],
            fact_text(one["simulated"]),
            one["status"],
            str(one["trials"]),
            *(fact_text(devices[one["participant"]].get(name, "")) for name in facts),
        ]
        for one in known
    ]
    headings = ["participant", "number", "language", "simulated", "status", "trials"]
    return [*headings, *(f"{COLUMN}{name}" for name in facts)], rows


def notes_table(store: SessionStore) -> Table:
    """Return a row per note; ``participant`` is "" where it is about the whole study."""
    rows = [[note["participant"] or "", note["text"], note["at"]] for note in store.notes()]
    return ["participant", "text", "at"], rows


def column_description(heading: str) -> str:
    """Return what a column holds."""
    if heading.startswith(COLUMN):
        return described(heading.removeprefix(COLUMN))
    return DESCRIPTIONS[heading]


def write_companion_tables(path: Path, store: SessionStore) -> list[Path]:
    """Write participants and notes beside a table of answers, and return where they are.

    Both are written even if they hold no row: what an earlier export left there would be of people who withdrew.
    """
    written = []
    for suffix, table in ((PARTICIPANTS, participants_table(store)), (NOTES, notes_table(store))):
        target = path.with_suffix(suffix)
        with atomic_write(target) as part:
            _write(part, *table)
        written.append(target)
    return written


def _write(path: Path, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([headings, *rows])

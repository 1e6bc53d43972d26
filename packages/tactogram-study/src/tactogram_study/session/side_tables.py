"""Participant and note tables of a session."""

from __future__ import annotations

import csv
from pathlib import Path

from tactogram.signal.io import atomic_write
from tactogram_study.session.device_facts import COLUMN, fact_description, fact_text
from tactogram_study.session.store import SessionStore

Table = tuple[list[str], list[list[str]]]
"""Headings, and rows as text."""
PARTICIPANTS, NOTES = ".participants.csv", ".notes.csv"
"""Suffixes that replace that of the table of answers."""
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
    """Return a row per participant, with the device facts of their start (``device_…``)."""
    people = store.progress()
    devices = {
        person["participant"]: {
            name: fact
            for entry in store.device_log(person["participant"])
            if entry["token"] == ""
            for name, fact in entry["facts"].items()
        }
        for person in people
    }
    facts = sorted({name for device in devices.values() for name in device})
    rows = [
        [
            person["participant"],
            str(person["number"]),
            person["language"],
            fact_text(person["simulated"]),
            person["status"],
            str(person["trials"]),
            *(fact_text(devices[person["participant"]].get(name, "")) for name in facts),
        ]
        for person in people
    ]
    headings = ["participant", "number", "language", "simulated", "status", "trials"]
    return [*headings, *(f"{COLUMN}{name}" for name in facts)], rows


def notes_table(store: SessionStore) -> Table:
    """Return a row per note; ``participant`` is "" where it is about the whole study."""
    rows = [[note["participant"] or "", note["text"], note["at"]] for note in store.notes()]
    return ["participant", "text", "at"], rows


def column_description(heading: str) -> str:
    """Return the description of a column."""
    if heading.startswith(COLUMN):
        return fact_description(heading.removeprefix(COLUMN))
    return DESCRIPTIONS[heading]


def write_companion_tables(path: Path, store: SessionStore) -> list[Path]:
    """Write participants and notes beside a table of answers, and return their paths.

    Both are written even without rows: an earlier export there would keep data of participants who withdrew.
    """
    written = []
    for suffix, (headings, rows) in ((PARTICIPANTS, participants_table(store)), (NOTES, notes_table(store))):
        target = path.with_suffix(suffix)
        with atomic_write(target) as part, part.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([headings, *rows])
        written.append(target)
    return written

"""Export of a session: participant and note tables, and a BIDS ``beh`` folder.

BIDS is the Brain Imaging Data Structure, https://bids-specification.readthedocs.io, "Behavioral experiments (with no
neural recordings)".
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from tactogram.datasets import new_folder
from tactogram.errors import DataError
from tactogram.signal.io import atomic_write
from tactogram_study.answers import Answers, cells
from tactogram_study.session.device_facts import COLUMN, fact_description, fact_text
from tactogram_study.session.progress import STATES
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import Study
from tactogram_study.wording import own_name

Table = tuple[list[str], list[list[str]]]
"""Headings, and rows as text."""
PARTICIPANTS, NOTES = ".participants.csv", ".notes.csv"
"""Suffixes that replace that of the table of answers."""
BIDS_VERSION = "1.10.0"
DESCRIPTIONS: Mapping[str, str] = {
    "study": "Name of the study",
    "participant": "Code of the participant",
    "session": "What the sitting is called",
    "block": "Block, from 1",
    "trial": "What was shown, counted from 1",
    "repeat": "How often this was asked, from 1",
    "design": "Design of the study, or questions before and after",
    "question": "What was asked",
    "condition": "Version of the stimulus",
    "stimulus": "Texture, plate or image",
    "other": "The second stimulus",
    "side": "Where the asked-for stimulus was",
    "answer": "What was answered",
    "value": "The answer as a number",
    "correct": "Whether the answer was right",
    "scale_low": "Lower end of the scale",
    "scale_high": "Upper end of the scale",
    "rt_ms": "From what was shown until the answer, in ms",
    "at": "When it was answered, UTC; the rows are in the order given, whatever the clock said",
    "played_sha256": "Hash of the samples that were played; several are joined by +",
    "level": "How strong it was played",
    "display": "On what it was played",
    "seed": "Seed of the study's order",
    "simulated": "Whether a simulated participant answered",
    "other_condition": "Version of the second stimulus",
    "simulated_stimuli": "true where what was felt or seen was simulated, whoever answered",
    "limited_stimuli": "What of a generated stimulus was outside of what its run learned, and for what it counted",
    "token": "Page on which it was asked",
    "step": "Step of the trial",
    "consent_sha256": "Hash of the text that was agreed to",
    "practice": "Design that was practised; such an answer does not count",
}
SIDE_DESCRIPTIONS = {
    "participant": DESCRIPTIONS["participant"],
    "number": "In the order of enrolment; the counterbalancing follows it",
    "language": "Of the pages",
    "simulated": "Whether it is a simulated participant",
    "status": "How the session stands",
    "trials": "Trials that were answered",
    "text": "What the experimenter wrote down",
    "at": "When it was written, UTC, by the clock of then",
}
"""Of participants and notes."""
KEY_COLUMNS = ("stimulus", "other", "condition", "other_condition")
"""Columns with keys, for which a study may have names."""


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


def column_description(name: str, descriptions: Mapping[str, str] = SIDE_DESCRIPTIONS) -> str:
    """Return the description of a column, its name if there is none."""
    if name.startswith(COLUMN) and name not in descriptions:
        return fact_description(name.removeprefix(COLUMN))
    return descriptions.get(name, name)


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


def export_bids(store: SessionStore, out: Path) -> Path:
    """Write a BIDS data set into a new or empty folder, complete or not at all, and return the folder."""
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise DataError(out, "is not empty; give a new folder")
    answers = store.answers()
    if not len(answers):
        raise DataError(store.path.parent, "holds no answer to export")
    if out.exists():
        out.rmdir()
    with new_folder(out) as part:
        _write(part, store, answers)
    return out


def _write(folder: Path, store: SessionStore, answers: Answers) -> None:
    study = store.study
    _json(folder / "dataset_description.json", _description(study, answers))
    (folder / "README").write_text(_readme(study, answers), encoding="utf-8")
    [_, *headings], rows = participants_table(store)
    facts: dict[str, Any] = {name: {"Description": column_description(name)} for name in headings}
    facts["language"]["Levels"] = {language: own_name(language) for language in study.languages}
    facts["simulated"]["Levels"] = {"true": "a program", "false": "a person"}
    facts["status"]["Levels"] = dict(STATES)
    facts = {"participant_id": {"Description": "Code of the participant"}} | facts
    _table(folder / "participants", [*facts], [[f"sub-{row[0]}", *row[1:]] for row in rows], facts)
    task = re.sub("[^A-Za-z0-9]", "", study.name)
    for code, group in answers.by("participant").items():
        session = group.rows[0].session
        beh_folder = folder / f"sub-{code}" / f"ses-{session}" / "beh"
        beh_folder.mkdir(parents=True)
        stem = f"sub-{code}_ses-{session}_task-{task}"
        headings, table = cells(group)
        kept = [i for i, name in enumerate(headings) if name not in ("study", "participant", "session")]
        names = [headings[i] for i in kept]
        rows = [[row[i] for i in kept] for row in table]
        _table(beh_folder / f"{stem}_beh", names, rows, _sidecar(study, names, rows))
        if played := store.played_log(code):
            _events(beh_folder / f"{stem}_events", played)
    if store.notes():
        _notes(folder / "sourcedata", store)


def _notes(folder: Path, store: SessionStore) -> None:
    """Write the experimenter's notes into ``sourcedata``, which BIDS leaves to its makers."""
    folder.mkdir()
    headings, rows = notes_table(store)
    facts = {name: {"Description": column_description(name)} for name in headings}
    _table(folder / "notes", headings, rows, facts)


def _description(study: Study, answers: Answers) -> dict[str, Any]:
    return {
        "Name": study.title.in_english(),
        "BIDSVersion": BIDS_VERSION,
        "DatasetType": "raw",
        "GeneratedBy": [{"Name": "tactogram"}],
        "SourceDatasets": [],
        **({"ReferencesAndLinks": [study.source]} if study.source else {}),
        "StudySha256": study.sha256,
        "Simulated": any(answers.column("simulated")),
    }


def _readme(study: Study, answers: Answers) -> str:
    simulated = len({row.participant for row in answers if row.simulated})
    people = len(answers.unique("participant")) - simulated
    return (
        f"{study.title.in_english()}\n\nA study of the design {study.design.kind} with "
        f"{people} participants and {simulated} simulated participants.\n{study.description.in_english()}\n"
    )


def _sidecar(study: Study, names: Sequence[str], rows: Sequence[Sequence[str]]) -> dict[str, Any]:
    facts: dict[str, Any] = {
        "TaskName": study.name,
        "TaskDescription": study.title.in_english(),
        "Instructions": study.design.instructions.in_english(),
    }
    labels = {key: name.in_english() for key, name in study.display_names.items()}
    for name, values in zip(names, zip(*rows, strict=True), strict=True):
        facts[name] = {"Description": column_description(name, {**DESCRIPTIONS, **study.design.columns})}
        if labels and name in (*KEY_COLUMNS, *study.design.key_columns):
            # Every value must be a level; those of practice trials have no name.
            facts[name]["Levels"] = {value: value for value in sorted(set(values)) if value} | labels
    facts["rt_ms"]["Units"] = "ms"
    return facts


def _events(stem: Path, played: Sequence[Mapping[str, Any]]) -> None:
    start = datetime.fromisoformat(played[0]["at"])
    headings = ["onset", "duration", "token", "slot", "sha256", "level", "display", "gain_db", "facts"]
    rows = [
        [
            f"{(datetime.fromisoformat(entry['at']) - start).total_seconds():.3f}",
            str(entry["facts"].get("seconds", "")),
            *(str(entry[name]) for name in headings[2:-1]),
            json.dumps(entry["facts"]) if entry["facts"] else "",
        ]
        for entry in played
    ]
    sidecar = {
        "onset": {
            "Description": "When it was played, after the first; by the computer's clock, which may have been set",
            "Units": "s",
        },
        "duration": {"Description": "Of a stream; of others not measured", "Units": "s"},
        "token": {"Description": DESCRIPTIONS["token"]},
        "slot": {"Description": "As what it was presented: A, B, X, or alone"},
        "sha256": {"Description": "Hash of the samples"},
        "level": {"Description": DESCRIPTIONS["level"]},
        "display": {"Description": DESCRIPTIONS["display"]},
        "gain_db": {"Description": "By how much stronger than the level says", "Units": "dB"},
        "facts": {"Description": "Of a stream, as JSON: drive, latency, motion of the finger, device"},
    }
    _table(stem, headings, rows, sidecar)


def _json(path: Path, value: Any) -> None:
    path.write_text(json.dumps(value, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


def _table(
    stem: Path, headings: Sequence[str], rows: Sequence[Sequence[str]], sidecar: Mapping[str, Any]
) -> None:
    """Write a table in BIDS form, tabs, no quotes, n/a for missing values, and the description of its columns."""
    lines = ["\t".join(headings)] + [
        "\t".join(re.sub(r"\s+", " ", cell) or "n/a" for cell in row) for row in rows
    ]
    stem.with_name(f"{stem.name}.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    _json(stem.with_name(f"{stem.name}.json"), sidecar)

"""Answers of a session given away: as a tidy table with what stands beside it, as a BIDS folder, as a ZIP file."""

from __future__ import annotations

import io
import json
import tempfile
import zipfile
from pathlib import Path
from typing import Any, Literal

from tactogram.errors import ParameterError
from tactogram.signal.io.atomic import write_text
from tactogram.study.answers import write_answers
from tactogram.study.session.export import export_bids
from tactogram.study.session.side_tables import write_companion_tables
from tactogram.study.session.store import SessionStore

STUDY_SUFFIX = ".study.json"
"""Of the file beside a table that holds the study it is of."""


def export_zip(folder: Path | str, *, kind: Literal["tables", "bids"]) -> tuple[str, bytes]:
    """Return the name and the bytes of a ZIP file with the answers of a session.

    Parameters
    ----------
    folder : Path
        Of the session.
    kind : {"tables", "bids"}
        What `export_study` writes as a table with what stands beside it, or as a BIDS folder.
    """
    name = Path(folder).resolve().name
    with tempfile.TemporaryDirectory(prefix="tactogram-export-") as temporary:
        whole = Path(temporary) / f"{name}-{kind}"
        if kind == "bids":
            export_study(folder, bids=whole)
        else:
            whole.mkdir()
            export_study(folder, table=whole / "answers.csv")
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
            for path in sorted(whole.rglob("*")):
                if path.is_file():
                    file.write(path, path.relative_to(whole.parent))
    return f"{name}-{kind}.zip", packed.getvalue()


def export_study(
    folder: Path | str, *, table: Path | str | None = None, bids: Path | str | None = None
) -> dict[str, Any]:
    """Write the answers of a session folder as a tidy table, as a BIDS folder, or both.

    Parameters
    ----------
    folder : Path
    table : Path, optional
        ``.csv``, ``.tsv`` or ``.parquet``. Beside it stand the study (``.study.json``), the participants with what
        their devices said (``.participants.csv``), and the experimenter's notes (``.notes.csv``).
    bids : Path, optional
        A new folder.
    """
    if table is None and bids is None:
        raise ParameterError("export needs where to: --out F.csv, --bids DIR, or both")
    with SessionStore(Path(folder)) as store:
        answers = store.answers()
        facts: dict[str, Any] = {
            "study": store.study.name,
            "answers": len(answers),
            "participants": len(answers.unique("participant")),
            "simulated_participants": len(answers.where(simulated=True).unique("participant")),
            "withdrawn": store.withdrawn,
            "notes": len(store.notes()),
        }
        if table is not None:
            path = Path(table)
            write_answers(path, answers)
            described = path.with_suffix(STUDY_SUFFIX)
            text = json.dumps(json.loads(store.study.as_json()), ensure_ascii=False, indent=1)
            write_text(described, text + "\n")
            participants, notes = write_companion_tables(path, store)
            facts |= {
                "table": str(path),
                "study_file": str(described),
                "participants_table": str(participants),
                "notes_table": str(notes),
            }
        if bids is not None:
            facts["bids"] = str(export_bids(store, Path(bids)))
    return facts

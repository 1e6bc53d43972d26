"""Verbs on the session of a study: `study progress`, `note`, `abort`, `end`, `withdraw`, `export`."""

import sys
from dataclasses import dataclass
from typing import Annotated

from tactogram.cli.printing import Printer, columns, lines_of
from tactogram.cli.verbs import Verb
from tactogram.workflows import Argument, Option, Request


@dataclass(frozen=True)
class _SessionRequest(Request):
    folder: Annotated[str, Argument("folder of the session", "DIR")]


@dataclass(frozen=True)
class _ParticipantRequest(_SessionRequest):
    code: Annotated[str, Argument("code of the participant", "CODE")]


@dataclass(frozen=True)
class _AbortRequest(_ParticipantRequest):
    undo: Annotated[bool, Option("let the participant continue")] = False


@dataclass(frozen=True)
class _EndRequest(_SessionRequest):
    undo: Annotated[bool, Option("let the study continue")] = False


@dataclass(frozen=True)
class _NoteRequest(_SessionRequest):
    text: Annotated[str, Argument("text of the note; no names of people", "TEXT")]
    participant: Annotated[
        str | None, Option("participant the note is about (default: the whole study)", "CODE")
    ] = None


@dataclass(frozen=True)
class _ExportRequest(_SessionRequest):
    table: Annotated[str | None, Option("a tidy table: .csv, .tsv or .parquet", "F", "--out")] = None
    bids: Annotated[str | None, Option("a BIDS folder, which must be new", "DIR")] = None
    salvage: Annotated[
        bool,
        Option("damaged session: write every answer that can still be read into the table of --out"),
    ] = False


def _progress(request: _SessionRequest, show: Printer) -> None:
    from tactogram_study.session.progress import status_counts, status_label
    from tactogram_study.workflows.sessions import session_progress

    facts = session_progress(request.folder)
    rows = [("code", "status", "trials", "last answer", "")]
    rows += [
        (
            one["participant"],
            status_label(one["status"]),
            f"{one['trials']} of {one['of']}",
            one["last"] or "-",
            "simulated" if one["simulated"] else "",
        )
        for one in facts["participants"]
    ]
    ended = f"; ended {facts['ended']}" if facts["ended"] else ""
    count = len(facts["participants"])
    states = status_counts(one["status"] for one in facts["participants"])
    who = f"{count} participant{'' if count == 1 else 's'}{f', {states}' if states else ''}"
    show(facts, f"{facts['study']}: {who}; {facts['answers']} answers{ended}\n{columns(rows)}")


def _note(request: _NoteRequest, show: Printer) -> None:
    from tactogram_study.workflows.sessions import write_note

    show(facts := write_note(request.folder, request.text, code=request.participant), lines_of(facts))


def _abort(request: _AbortRequest, show: Printer) -> None:
    from tactogram_study.workflows.sessions import abort_participant

    show(facts := abort_participant(**vars(request)), lines_of(facts))


def _end(request: _EndRequest, show: Printer) -> None:
    from tactogram_study.workflows.sessions import end_session

    show(facts := end_session(**vars(request)), lines_of(facts))


def _export(request: _ExportRequest, show: Printer) -> None:
    from tactogram_study.workflows.answers import export_study

    show(facts := export_study(**vars(request)), lines_of(facts))
    if request.salvage:
        sys.stderr.write(f"tactogram: at least {facts['lost']} rows of answers are lost\n")


def _withdraw(request: _ParticipantRequest, show: Printer) -> None:
    from tactogram_study.workflows.sessions import withdraw

    facts = withdraw(**vars(request))
    text = (
        f"deleted: {facts['answers_deleted']} answers and the code; {facts['participants_left']} participants left\n"
        "earlier exports still hold them: delete those, and export again"
    )
    show(facts, text)


VERBS = {
    "study export": Verb(_ExportRequest, _export, folders=("designs", "languages")),
    "study withdraw": Verb(_ParticipantRequest, _withdraw, folders=("designs", "languages")),
    "study progress": Verb(_SessionRequest, _progress, folders=("designs", "languages")),
    "study note": Verb(_NoteRequest, _note, folders=("designs", "languages")),
    "study abort": Verb(_AbortRequest, _abort, folders=("designs", "languages")),
    "study end": Verb(_EndRequest, _end, folders=("designs", "languages")),
}

"""Verbs for a running session: `study progress`, `note`, `abort`, `end`."""

from __future__ import annotations

import shlex
from functools import wraps

from tactogram.cli.options import Verb, Verbs
from tactogram.cli.printing import Arguments, columns, lines_of, print_result


def with_salvage_command(verb: Verb) -> Verb:
    """Wrap a verb so that the error of a damaged session names the command that exports its readable answers."""

    @wraps(verb)
    def wrapped(a: Arguments) -> int | None:
        from tactogram.errors import DataError
        from tactogram.study.session.salvage import DamagedSessionError

        try:
            return verb(a)
        except DamagedSessionError as error:
            if not error.readable:
                raise
            command = f"tactogram study export {shlex.quote(str(error.folder))} --salvage --out F.csv"
            raise DataError(f"{error.summary}; export them: {command}") from error

    return wrapped


def add_session_verbs(study: Verbs) -> None:
    """Add what each verb takes."""
    add = study.add("progress", progress)
    add("folder", metavar="DIR", help="folder of the session")

    add = study.add("note", note)
    add("folder", metavar="DIR", help="folder of the session")
    add("text", metavar="TEXT", help="text of the note; no names of people")
    add("--participant", metavar="CODE", help="participant the note is about (default: the whole study)")

    add = study.add("abort", abort)
    add("folder", metavar="DIR", help="folder of the session")
    add("code", metavar="CODE", help="code of the participant")
    add("--undo", action="store_true", help="let the participant continue")

    add = study.add("end", end)
    add("folder", metavar="DIR", help="folder of the session")
    add("--undo", action="store_true", help="let the study continue")


@with_salvage_command
def progress(a: Arguments) -> None:
    """Show the progress of each participant in a session."""
    from tactogram.study.session.states import status_counts, status_label
    from tactogram.workflows.study.sessions import session_progress

    facts = session_progress(a.folder)
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
    stand = status_counts(one["status"] for one in facts["participants"])
    who = f"{count} participant{'' if count == 1 else 's'}{f', {stand}' if stand else ''}"
    print_result(a, facts, f"{facts['study']}: {who}; {facts['answers']} answers{ended}\n{columns(rows)}")


@with_salvage_command
def note(a: Arguments) -> None:
    """Add an experimenter's note to a session."""
    from tactogram.workflows.study.sessions import write_note

    facts = write_note(a.folder, a.text, code=a.participant)
    print_result(a, facts, lines_of(facts))


@with_salvage_command
def abort(a: Arguments) -> None:
    """End a participant's session now; the answers so far are kept."""
    from tactogram.workflows.study.sessions import abort_participant

    facts = abort_participant(a.folder, a.code, undo=a.undo)
    print_result(a, facts, lines_of(facts))


@with_salvage_command
def end(a: Arguments) -> None:
    """End a study: nobody can join, and unfinished participants cannot continue."""
    from tactogram.workflows.study.sessions import end_session

    facts = end_session(a.folder, undo=a.undo)
    print_result(a, facts, lines_of(facts))

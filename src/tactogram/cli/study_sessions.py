"""Verbs for a session that is being taken: `study progress`, `note`, `abort`, `end`."""

from __future__ import annotations

from tactogram.cli.options import Verbs
from tactogram.cli.printing import Arguments, columns, lines_of, print_result


def add_session_verbs(study: Verbs) -> None:
    """Add what each verb takes."""
    add = study.add("progress", progress)
    add("folder", metavar="DIR", help="folder of the session")

    add = study.add("note", note)
    add("folder", metavar="DIR", help="folder of the session")
    add("text", metavar="TEXT", help="what is to be remembered; no names")
    add("--participant", metavar="CODE", help="whom it is about; by default the whole study")

    add = study.add("abort", abort)
    add("folder", metavar="DIR", help="folder of the session")
    add("code", metavar="CODE", help="of the participant")
    add("--undo", action="store_true", help="let them go on again")

    add = study.add("end", end)
    add("folder", metavar="DIR", help="folder of the session")
    add("--undo", action="store_true", help="let it go on again")


def progress(a: Arguments) -> None:
    """Say where each participant of a session stands."""
    from tactogram.study.session.states import called, counted
    from tactogram.workflows.study.sessions import session_progress

    facts = session_progress(a.folder)
    rows = [("code", "status", "trials", "last answer", "")]
    rows += [
        (
            one["participant"],
            called(one["status"]),
            f"{one['trials']} of {one['of']}",
            one["last"] or "-",
            "simulated" if one["simulated"] else "",
        )
        for one in facts["participants"]
    ]
    ended = f"; ended {facts['ended']}" if facts["ended"] else ""
    count = len(facts["participants"])
    stand = counted(one["status"] for one in facts["participants"])
    who = f"{count} participant{'' if count == 1 else 's'}{f', {stand}' if stand else ''}"
    print_result(a, facts, f"{facts['study']}: {who}; {facts['answers']} answers{ended}\n{columns(rows)}")


def note(a: Arguments) -> None:
    """Write down what the experimenter saw."""
    from tactogram.workflows.study.sessions import write_note

    facts = write_note(a.folder, a.text, code=a.participant)
    print_result(a, facts, lines_of(facts))


def abort(a: Arguments) -> None:
    """End a participant's session now; what was answered stays."""
    from tactogram.workflows.study.sessions import abort_participant

    facts = abort_participant(a.folder, a.code, undo=a.undo)
    print_result(a, facts, lines_of(facts))


def end(a: Arguments) -> None:
    """End a study: nobody joins, and who has not finished does not go on."""
    from tactogram.workflows.study.sessions import end_session

    facts = end_session(a.folder, undo=a.undo)
    print_result(a, facts, lines_of(facts))

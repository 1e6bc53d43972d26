"""Verbs for experiments with people: the text of each result."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from tactogram.cli.printing import columns, lines_of
from tactogram.cli.verbs import Verb

MOST_KEYS = 8
"""Keys of missing texts that a line names."""
FOLDERS = ("designs", "languages")


def _studies(studies: Mapping[str, Any]) -> str:
    rows = [(name, s["design"], f"{s['trials']} trials", s["title"]) for name, s in studies.items()]
    return columns([("name", "design", "each", ""), *rows])


def _designs(designs: Mapping[str, Any]) -> str:
    rows = [
        (kind, ", ".join(d["margins"]), ", ".join(d["power"]), d["question"]) for kind, d in designs.items()
    ]
    return columns([("kind", "margins", "power tables", ""), *rows])


def _languages(languages: Mapping[str, Any]) -> str:
    if "name" in languages:  # the texts of one
        import tomli_w

        return tomli_w.dumps(languages).rstrip()
    rows = [(tag, facts["name"], _missing(facts["missing_texts"])) for tag, facts in languages.items()]
    return columns([("language", "", "missing texts"), *rows])


def _missing(keys: Sequence[str]) -> str:
    """Return keys as text: how many, and the first ones."""
    if not keys:
        return "none"
    return f"{len(keys)}: {', '.join(keys[:MOST_KEYS])}{' …' if len(keys) > MOST_KEYS else ''}"


def _check(facts: Mapping[str, Any]) -> str:
    rendered = None if facts["rendered"] is None else f"{len(facts['rendered'])} stimuli"
    missing = [f"{language} {_missing(keys)}" for language, keys in facts["missing_texts"].items()]
    return lines_of({**facts, "rendered": rendered, "missing_texts": missing, "limited": None})


def _limited(facts: Mapping[str, Any]) -> list[str]:
    from tactogram_study.workflows.stimuli import limited_lines

    return limited_lines(facts["limited"])


def _simulated(result: Mapping[str, Any]) -> str:
    count = len(result["simulated_participants"])
    return f"{result['study']}: {count} simulated participants, {result['answers']} answers in {result['folder']}"


def _progress(facts: Mapping[str, Any]) -> str:
    from tactogram_study.session.progress import status_counts, status_label

    rows = [("code", "status", "trials", "last answer", "")]
    rows += [
        (
            participant["participant"],
            status_label(participant["status"]),
            f"{participant['trials']} of {participant['of']}",
            participant["last"] or "-",
            "simulated" if participant["simulated"] else "",
        )
        for participant in facts["participants"]
    ]
    ended = f"; ended {facts['ended']}" if facts["ended"] else ""
    count = len(facts["participants"])
    states = status_counts(participant["status"] for participant in facts["participants"])
    who = f"{count} participant{'' if count == 1 else 's'}{f', {states}' if states else ''}"
    return f"{facts['study']}: {who}; {facts['answers']} answers{ended}\n{columns(rows)}"


def _lost(facts: Mapping[str, Any]) -> Iterator[str]:
    if "lost" in facts:
        yield f"at least {facts['lost']} rows of answers are lost"


def _withdrawn(facts: Mapping[str, Any]) -> str:
    return (
        f"deleted: {facts['answers_deleted']} answers and the code; {facts['participants_left']} participants left\n"
        "earlier exports still hold them: delete those, and export again"
    )


def _analysis(result: dict[str, Any]) -> str:
    written = f"written: {', '.join(result['files'])} in {result['out']}"
    return "\n".join([result.pop("text"), *result["notes"], written])


def _power(result: dict[str, Any]) -> str:
    return str(result.pop("text"))


WORKFLOWS = "tactogram_study.workflows"
STUDIES, SESSIONS = f"{WORKFLOWS}.studies", f"{WORKFLOWS}.sessions"
VERBS = {
    "study list": Verb(f"{STUDIES}:list_studies", _studies, folders=FOLDERS),
    "study designs": Verb(f"{STUDIES}:list_designs", _designs, folders=FOLDERS),
    "study languages": Verb(f"{STUDIES}:list_languages", _languages, folders=("languages",)),
    "study copy": Verb(f"{STUDIES}:copy_study", lines_of, folders=FOLDERS),
    "study check": Verb(f"{STUDIES}:check_study", _check, _limited, FOLDERS),
    "study simulate": Verb(f"{SESSIONS}:simulate_study", _simulated, folders=FOLDERS),
    "study export": Verb(f"{WORKFLOWS}.answers:export_study", lines_of, _lost, FOLDERS),
    "study withdraw": Verb(f"{SESSIONS}:withdraw", _withdrawn, folders=FOLDERS),
    "study progress": Verb(f"{SESSIONS}:session_progress", _progress, folders=FOLDERS),
    "study note": Verb(f"{SESSIONS}:write_note", lines_of, folders=FOLDERS),
    "study abort": Verb(f"{SESSIONS}:abort_participant", lines_of, folders=FOLDERS),
    "study end": Verb(f"{SESSIONS}:end_session", lines_of, folders=FOLDERS),
    "study analyse": Verb(f"{WORKFLOWS}.analysis:analyse_study", _analysis, folders=FOLDERS),
    "study power": Verb(f"{WORKFLOWS}.power:study_power", _power, folders=FOLDERS),
}

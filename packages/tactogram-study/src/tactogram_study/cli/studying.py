"""Verbs for experiments with people: `study list`, `designs`, `languages`, `check`, `simulate`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from tactogram.cli.printing import Printer, columns, lines_of
from tactogram.cli.verbs import Verb
from tactogram.workflows import Argument, Option, Request
from tactogram_study.workflows.requests import CHANGES, ParticipantsRequest

MOST_KEYS = 8
"""Keys of missing texts that a line names."""


@dataclass(frozen=True)
class _ListRequest(Request):
    pass


@dataclass(frozen=True)
class _LanguagesRequest(Request):
    language: Annotated[
        str,
        Argument("print the texts of this language as a file to translate, missing ones in English", "LANG"),
    ] = ""


@dataclass(frozen=True)
class _CheckRequest(Request):
    study: Annotated[str, Argument("a study: a TOML file, or one of `study list`", "FILE|NAME")]
    stimuli: Annotated[bool, Option("also generate and render every stimulus")] = False
    changes: Annotated[Mapping[str, Any] | None, CHANGES] = None


def _list(request: _ListRequest, show: Printer) -> None:
    from tactogram_study.workflows.studies import list_studies

    studies = list_studies()
    rows = [(name, s["design"], f"{s['trials']} trials", s["title"]) for name, s in studies.items()]
    show(studies, columns([("name", "design", "each", ""), *rows]))


def _designs(request: _ListRequest, show: Printer) -> None:
    from tactogram_study.workflows.studies import list_designs

    designs = list_designs()
    rows = [
        (kind, ", ".join(d["margins"]), ", ".join(d["power"]), d["question"]) for kind, d in designs.items()
    ]
    show(designs, columns([("kind", "margins", "power tables", ""), *rows]))


def _languages(request: _LanguagesRequest, show: Printer) -> None:
    import tomli_w

    from tactogram_study.wording import complete_texts
    from tactogram_study.workflows.studies import list_languages

    if request.language:
        texts = complete_texts(request.language)
        show(texts, tomli_w.dumps(texts).rstrip())
        return
    languages = list_languages()
    rows = [(tag, one["name"], _missing(one["missing_texts"])) for tag, one in languages.items()]
    show(languages, columns([("language", "", "missing texts"), *rows]))


def _missing(keys: Sequence[str]) -> str:
    """Return keys as text: how many, and the first ones."""
    return (
        f"{len(keys)}: {', '.join(keys[:MOST_KEYS])}{' …' if len(keys) > MOST_KEYS else ''}"
        if keys
        else "none"
    )


def _check(request: _CheckRequest, show: Printer) -> None:
    from tactogram_study.workflows.stimuli import limited_lines
    from tactogram_study.workflows.studies import check_study

    facts = check_study(**vars(request))
    rendered = None if facts["rendered"] is None else f"{len(facts['rendered'])} stimuli"
    missing = [f"{language} {_missing(keys)}" for language, keys in facts["missing_texts"].items()]
    show(facts, lines_of({**facts, "rendered": rendered, "missing_texts": missing, "limited": None}))
    show.notes(limited_lines(facts["limited"]))


def _simulate(request: ParticipantsRequest, show: Printer) -> None:
    from tactogram_study.workflows.sessions import simulate_study

    with show.progress() as progress:
        result = simulate_study(**vars(request) | {"progress": progress})
    count = len(result["simulated_participants"])
    text = f"{result['study']}: {count} simulated participants, {result['answers']} answers in {result['folder']}"
    show(result, text)


VERBS = {
    "study list": Verb(_ListRequest, _list, folders=("designs", "languages")),
    "study designs": Verb(_ListRequest, _designs, folders=("designs", "languages")),
    "study languages": Verb(_LanguagesRequest, _languages, folders=("languages",)),
    "study check": Verb(_CheckRequest, _check, folders=("designs", "languages")),
    "study simulate": Verb(ParticipantsRequest, _simulate, folders=("designs", "languages")),
}

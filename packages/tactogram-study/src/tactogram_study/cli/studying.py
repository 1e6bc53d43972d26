"""Verbs for experiments with people: `study list`, `designs`, `languages`, `check`, `run`, `simulate`."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Annotated, Any

from tactogram.cli.printing import Printer, columns, lines_of
from tactogram_studio.cli.studio import ServerOptions, bound_port, shown_qr_code
from tactogram.cli.verbs import Verb
from tactogram.workflows.request import Argument, Option, Request
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


@dataclass(frozen=True)
class _RunRequest(ServerOptions):
    study: Annotated[
        str,
        Argument(
            "a study: a TOML file, or one of `study list`; or the folder of a session to continue",
            "FILE|NAME|DIR",
        ),
    ]
    _: KW_ONLY
    out: Annotated[str | None, Option("folder of the session; created, or continued", "DIR")] = None
    device: Annotated[
        str,
        Option(
            "device for played_by = 'server' or 'stream': audio, audio:NAME or null; for 'stream' also digilent "
            "or osc:HOST:PORT"
        ),
    ] = "audio"
    full_scale: Annotated[
        float | None, Option("the device's full scale, in the unit of the display's drive", "X")
    ] = None
    track: Annotated[
        Mapping[str, Any] | None,
        Option("keep a Digilent's carrier at the transducer's resonance, as of `stream`", "KEY=VALUE"),
    ] = None
    participants: Annotated[
        tuple[str, ...],
        Option("codes to enrol beforehand; otherwise people get one as they join", "CODE,CODE,…"),
    ] = ()
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

    from tactogram_study.language_files import complete_texts
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


def _run(request: _RunRequest, show: Printer) -> None:
    from pathlib import Path

    from tactogram_study.study_file import Study
    from tactogram_study.workflows.stimuli import limited_lines

    def ready(facts: dict[str, Any]) -> None:
        addresses = {
            "experimenter": facts["experimenter"],
            "participants": facts["join"],
            **{f"participant {code}": address for code, address in facts["codes"].items()},
            "participants, by another": facts["addresses"],
            "certificate, SHA-256": facts["certificate_sha256"],
        }
        show(facts, lines_of(addresses) + ("" if port.loopback else shown_qr_code(facts["join"])))
        show.notes(limited_lines(facts["limited"]))
        sys.stdout.flush()
        sys.stderr.write("Ctrl-C ends it; run again to continue\n")

    if not Path(request.study).is_dir():
        Study.load(request.study, changes=request.changes)  # a wrong name is reported before a port in use

    with bound_port(request) as port:
        from tactogram_studio.study_server import run_study

        run_study(
            request.study,
            request.out,
            port,
            changes=request.changes or {},
            codes=list(request.participants),
            open_browser=request.open_browser,
            device=request.device,
            full_scale=request.full_scale,
            track=request.track,
            ready=ready,
        )
    sys.stderr.write("tactogram: the study's server ended; all answers are stored\n")


def _simulate(request: ParticipantsRequest, show: Printer) -> None:
    from tactogram_study.workflows.simulation import simulate_study

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
    "study run": Verb(_RunRequest, _run, folders=("designs", "languages")),
    "study simulate": Verb(ParticipantsRequest, _simulate, folders=("designs", "languages")),
}

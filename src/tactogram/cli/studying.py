"""Verbs for experiments with people: `study list`, `check`, `run`, `simulate`, `export`, `analyse` and others."""

from __future__ import annotations

import sys
from typing import Any

from tactogram.cli.options import Add, Verbs, designs_option
from tactogram.cli.printing import Arguments, columns, lines_of, print_result
from tactogram.cli.studio import bound_port, server_options, shown_qr_code
from tactogram.cli.study_sessions import add_session_verbs, with_salvage_command


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    study = verbs.group(
        "study", "experiments with people: check, run, simulate, export, analyse", shared=designs_option
    )
    study.add("list", studies)
    study.add("designs", designs)

    add = study.add("check", check)
    add("study", metavar="FILE|NAME", help="a study: a TOML file, or one of `study list`")
    add("--stimuli", action="store_true", help="also generate and render every stimulus")
    _changes_option(add)

    add = study.add("run", run)
    add(
        "study",
        metavar="FILE|NAME|DIR",
        help="a study: a TOML file, or one of `study list`; or the folder of a session to continue",
    )
    add("--out", metavar="DIR", help="folder of the session; created, or continued")
    server_options(add)
    add(
        "--device",
        default="audio",
        help="device for played_by = 'server': audio, audio:NAME or null (default %(default)s)",
    )
    add(
        "--full-scale",
        type=float,
        metavar="X",
        help="the device's full scale, in the unit of the display's drive",
    )
    add(
        "--participants",
        metavar="CODE,CODE,…",
        help="codes to enrol beforehand; otherwise people get one as they join",
    )
    _changes_option(add)

    add = study.add("simulate", simulate)
    add("study", metavar="FILE|NAME")
    add("--out", required=True, metavar="DIR", help="folder of the session; created, or continued")
    add(
        "--participants",
        type=int,
        default=20,
        metavar="N",
        help="number of simulated participants (default %(default)s)",
    )
    add(
        "--effect",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="true effect, e.g. d_prime=1 or shift.generated=-10 (default: none)",
    )
    add("--seed", type=int, default=0, help="seed of their answers (default %(default)s)")
    add("--play", action="store_true", help="generate and render stimuli and log their hashes")
    _changes_option(add)

    add = study.add("export", export)
    add("folder", metavar="DIR", help="folder of the session")
    add("--out", metavar="F", help="a tidy table: .csv, .tsv or .parquet")
    add("--bids", metavar="DIR", help="a BIDS folder, which must be new")
    add(
        "--salvage",
        action="store_true",
        help="damaged session: write every answer that can still be read into the table of --out",
    )

    add = study.add("withdraw", withdraw)
    add("folder", metavar="DIR", help="folder of the session")
    add("code", metavar="CODE", help="code of the participant")

    add_session_verbs(study)
    _analyse_options(study.add("analyse", analyse))
    _power_options(study.add("power", power))


def studies(a: Arguments) -> None:
    """List the studies that come with the package."""
    from tactogram.workflows.study.studies import list_studies

    found = list_studies()
    rows = [(name, s["design"], f"{s['trials']} trials", s["title"]) for name, s in found.items()]
    print_result(a, found, columns([("name", "design", "each", ""), *rows]))


def designs(a: Arguments) -> None:
    """List the designs that a study can have, with their margins and power tables."""
    from tactogram.workflows.study.studies import list_designs

    found = list_designs()
    rows = [
        (kind, ", ".join(d["margins"]), ", ".join(d["power"]), d["question"]) for kind, d in found.items()
    ]
    print_result(a, found, columns([("kind", "margins", "power tables", ""), *rows]))


def check(a: Arguments) -> None:
    """Check a study's file and describe what it asks of a participant."""
    from tactogram.recipe import parse_changes
    from tactogram.workflows.study.studies import check_study

    facts = check_study(a.study, changes=parse_changes(a.set), stimuli=a.stimuli)
    shown = {**facts, "rendered": None if facts["rendered"] is None else f"{len(facts['rendered'])} stimuli"}
    print_result(a, facts, lines_of(shown))


@with_salvage_command
def run(a: Arguments) -> int:
    """Serve a study to participants and its progress to the experimenter; run again to continue."""
    from tactogram.recipe import parse_changes

    def ready(facts: dict[str, Any]) -> None:
        told = {
            "experimenter": facts["experimenter"],
            "participants": facts["join"],
            **{f"participant {code}": address for code, address in facts["codes"].items()},
            "participants, by another": facts["addresses"],
            "certificate, SHA-256": facts["certificate_sha256"],
        }
        print_result(a, facts, lines_of(told) + ("" if port.loopback else shown_qr_code(facts["join"])))
        sys.stdout.flush()
        sys.stderr.write("Ctrl-C ends it; run again to continue\n")

    with bound_port(a) as port:
        from tactogram.studio.study_server import run_study

        run_study(
            a.study,
            a.out,
            port,
            changes=parse_changes(a.set),
            codes=[code.strip() for code in (a.participants or "").split(",") if code.strip()],
            open_browser=not a.no_open,
            device=a.device,
            full_scale=a.full_scale,
            ready=ready,
        )
    sys.stderr.write("tactogram: the study's server ended; all answers are stored\n")
    return 0


def simulate(a: Arguments) -> None:
    """Let simulated participants take a study, with or without an effect."""
    from tactogram.recipe import parse_changes
    from tactogram.workflows.study.simulation import simulate_study

    def progress(done: int) -> None:
        sys.stderr.write(f"\r{done} of {a.participants} simulated participants")
        sys.stderr.flush()

    result = simulate_study(
        a.study,
        a.out,
        participants=a.participants,
        effect=parse_changes(a.effect),
        seed=a.seed,
        changes=parse_changes(a.set),
        play=a.play,
        progress=progress,
    )
    sys.stderr.write("\n")
    count = len(result["simulated_participants"])
    text = f"{result['study']}: {count} simulated participants, {result['answers']} answers in {result['folder']}"
    print_result(a, result, text)


@with_salvage_command
def export(a: Arguments) -> None:
    """Write the answers of a session as a tidy table or a BIDS folder."""
    from tactogram.errors import ParameterError
    from tactogram.workflows.study.export import export_study

    if a.out is None and a.bids is None:
        raise ParameterError("export needs --out F, --bids DIR, or both")
    if a.salvage and (a.out is None or a.bids is not None):
        raise ParameterError("--salvage needs --out F, and takes no --bids")
    facts = export_study(a.folder, table=a.out, bids=a.bids, salvage=a.salvage)
    print_result(a, facts, lines_of(facts))
    if a.salvage:
        least = "" if facts["lost_is_exact"] else "at least "
        sys.stderr.write(f"tactogram: {least}{facts['lost']} rows of answers are lost\n")


@with_salvage_command
def withdraw(a: Arguments) -> None:
    """Delete a participant and all their data; export tables again afterwards."""
    from tactogram.workflows.study.sessions import withdraw

    facts = withdraw(a.folder, a.code)
    print_result(a, facts, _withdrawn_text(facts))


@with_salvage_command
def analyse(a: Arguments) -> None:
    """Analyse answers, as published and with repeated measures, with intervals and verdicts."""
    from tactogram.datasets.ratings.ratings import SEVEN_POINT, scale_of
    from tactogram.workflows.study.analysis import analyse_study, margins_of

    result = analyse_study(
        a.source,
        a.out,
        design=a.design,
        margins=margins_of(a.margin),
        targets=a.targets,
        targets_scale=scale_of(a.targets_scale) if a.targets_scale else SEVEN_POINT,
        reference=a.reference,
        columns=_pairs("--column", a.column),
        constants=_pairs("--constant", a.constant),
        encoding=a.encoding,
        draws=a.draws,
        seed=a.seed,
        alpha=a.alpha,
        practice=a.practice,
        figures=not a.no_figures,
        language=a.language,
    )
    text = result.pop("text")
    print_result(a, result, f"{text}\nwritten: {', '.join(result['files'])} in {result['out']}")


def power(a: Arguments) -> None:
    """Compute the power of a study before it is run: exactly, and with simulated participants."""
    from tactogram.workflows.progress import shown
    from tactogram.workflows.study.power import study_power

    with shown() as progress:
        result = study_power(
            a.design,
            participants=_counts("--participants", a.participants),
            trials=_counts("--trials", a.trials),
            effect=a.effect,
            person_sd=a.person_sd,
            trial_sd=a.trial_sd,
            margin=a.margin,
            items=a.items,
            simulations=a.simulations,
            seed=a.seed,
            progress=progress,
        )
    print_result(a, result, result.pop("text"))


def _analyse_options(add: Add) -> None:
    add(
        "source",
        metavar="FILE|STORE",
        help="a table of answers (.csv, .tsv, .parquet), or a session's folder",
    )
    add(
        "--out",
        required=True,
        metavar="DIR",
        help="folder for report.html, analysis.json, analysis.txt and the figures",
    )
    add(
        "--design",
        help="only rows of this design; for a foreign table the design of all its rows: see `study designs`",
    )
    add(
        "--margin",
        action="append",
        default=[],
        metavar="QUESTION=VALUE",
        help="margin of equivalence that replaces the study file's, e.g. which=0.1; reported as set "
        "afterwards",
    )
    add("--alpha", type=float, help="significance level that replaces the study file's; likewise reported")
    add(
        "--practice",
        action="store_true",
        help="analyse the practice trials instead of those that count",
    )
    add("--targets", metavar="F", help="target scores: ratings, or answers to a study of words")
    add("--targets-scale", metavar="SCALE", help="scale of the target scores (default 7-point)")
    add("--reference", metavar="CONDITION", help="condition whose mean scores are the targets instead")
    add(
        "--column",
        action="append",
        default=[],
        metavar="NAME=HEADING",
        help="foreign table: heading of one of our columns, e.g. participant=subject",
    )
    add(
        "--constant",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="foreign table: value of a column in every row, e.g. question=which",
    )
    add("--encoding", default="utf-8-sig", help="encoding of a foreign table (default %(default)s)")
    add("--draws", type=int, default=2000, help="draws of the bootstraps (default %(default)s)")
    add("--seed", type=int, default=0, help="seed of the bootstraps (default %(default)s)")
    add("--no-figures", action="store_true", help="write no PNG")
    add(
        "--language",
        choices=("en", "ja"),
        default="en",
        help="language of item and condition names in the report (default %(default)s)",
    )


def _power_options(add: Add) -> None:
    add(
        "design",
        metavar="TABLE|FILE|NAME",
        help="a power table, see `study designs`; or a study, whose margin, alpha and trials are used",
    )
    add("--participants", metavar="N,N,…", help="numbers of participants")
    add("--trials", metavar="N,N,…", help="trials per participant")
    add("--effect", type=float, help="true effect")
    add("--person-sd", type=float, help="standard deviation of effects between people")
    add("--trial-sd", type=float, help="standard deviation of single answers")
    add("--margin", type=float, help="margin of equivalence")
    add("--items", type=int, help="number of items compared with each other")
    add(
        "--simulations",
        type=int,
        default=2000,
        help="studies of simulated participants per row (default %(default)s)",
    )
    add("--seed", type=int, default=0, help="seed of the simulations (default %(default)s)")


def _pairs(option: str, texts: list[str]) -> dict[str, str]:
    from tactogram.errors import ParameterError

    found = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not sign or not name or name in found:
            raise ParameterError(f"{option} needs NAME=VALUE, each name once, got {text!r}")
        found[name] = value
    return found


def _counts(option: str, text: str | None) -> tuple[int, ...]:
    from tactogram.errors import ParameterError

    try:
        return tuple(int(part) for part in text.split(",")) if text else ()
    except ValueError:
        raise ParameterError(f"{option} needs whole numbers separated by commas, got {text!r}") from None


def _withdrawn_text(facts: dict[str, Any]) -> str:
    return (
        f"deleted: {facts['answers_deleted']} answers and the code; {facts['participants_left']} participants left\n"
        "earlier exports still hold them: delete those, and export again"
    )


def _changes_option(add: Add) -> None:
    add("--set", action="append", default=[], metavar="KEY=VALUE", help="change a value of the study")

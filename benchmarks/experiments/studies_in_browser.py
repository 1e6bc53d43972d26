"""Each shipped study taken by simulated participants in a real browser, its server killed midway, and analysed.

Once with an effect, once without. No measure of touch: participants, stimuli and answers are simulated.
The experiment tests that nothing is lost from page to verdict, and that the verdict finds effects and their absence.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.experiments.browser_participants import StudyServer, take_all
from benchmarks.experiments.study_cases import STUDIES
from benchmarks.experiments.study_recovery import recovery
from tactogram.errors import DataError, ParameterError
from tactogram.extras import imported
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.progress import ProgressCallback
from tactogram_study.analysis.findings import p_text
from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.study_file import Study

SEEDS = {"effect": 1, "none": 2}
"""Of the simulated participants."""
RECOVERY = (
    *("study", "taken with", "looked at", "true of them", "estimate (95 %)", "covered"),
    *("p", "equivalence", "outcome", "of what nothing was put into"),
)
COLUMNS = (
    *("study", "simulated participants", "seed", "participants (simulated)", "pages", "kills", "reloads"),
    *("lost", "twice", "BIDS problems", "changed for two cores"),
)
NOTES = (
    "True of them: computed from the rules of the simulated participants, in the analysis' own unit, not from their",
    "answers; of steps it is what rounding and the scale's ends leave of the shift that was put in. Of many intervals",
    "of 95 % one in twenty may miss. An absence is never told from a large p: by the margin of the study's file, or",
    "it is undecided.",
)


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    studies: str = "",
    participants: int = 20,
    at_once: int = 4,
    draws: int = 2000,
) -> dict[str, Any]:
    """Return the recovery of each study's effect, and of its absence.

    Parameters
    ----------
    folder, progress
        As in every experiment. Results already in ``folder`` are reused.
    paper : bool
        Every trial of each study; else with the changes of `STUDIES`, for two cores.
    studies : str
        Names, separated by commas; by default all shipped studies.
    participants, at_once : int
        Number of simulated participants, in total and at the same time.
    draws : int
        Of the bootstraps.
    """
    chosen = [name.strip() for name in studies.split(",") if name.strip()] or list(STUDIES)
    if unknown := set(chosen) - set(STUDIES):
        raise ParameterError(f"studies must be of {', '.join(STUDIES)}, got {', '.join(sorted(unknown))}")
    found: dict[str, Any] = {}
    for name in chosen:
        for kind, seed in SEEDS.items():
            place, case = folder / f"{name}-{kind}", STUDIES[name]
            if not (place / "taken.json").is_file():
                facts = take_study(
                    name,
                    place,
                    changes={} if paper else case.changes,
                    effect={**(case.effect if kind == "effect" else {}), **case.people},
                    participants=participants,
                    seed=seed,
                    at_once=at_once,
                )
                write_text(place / "taken.json", json.dumps(facts, ensure_ascii=False, indent=1) + "\n")
            taken = json.loads((place / "taken.json").read_text(encoding="utf-8"))
            analysis = analysis_of(place, draws=draws)
            study = Study.load(name, changes=taken["changes"])
            effect = SimulatedEffect(**taken["effect"])
            recovered = [
                recovery(one, analysis, study, effect, seed=taken["seed"], kind=kind) for one in case.findings
            ]
            found.setdefault(name, {})[kind] = {**taken, "recovery": recovered}
    result = {"simulated": True, "participants": participants, "studies": found}
    table = _table(found)
    write_text(folder / "studies_in_browser.md", table + "\n")
    return result | {"text": table}


def take_study(
    name: str,
    folder: Path,
    *,
    changes: Mapping[str, Any],
    effect: Mapping[str, Any],
    participants: int,
    seed: int = 0,
    at_once: int = 4,
) -> dict[str, Any]:
    """Let simulated participants take a study in the browser with one kill, check what is stored, and export it.

    Parameters
    ----------
    name : str
        A shipped study, or a file.
    folder : Path
        For session, exports and analysis.
    changes : mapping
        Values of the study, by dotted key.
    effect : mapping
        Of `SimulatedEffect`.
    participants, seed, at_once : int
        See `run`; the seed is that of their answers.

    Raises
    ------
    DataError
        If an answer was lost, stored twice, or stored otherwise than it was given.
    """
    study, session = Study.load(name, changes=changes), folder / "session"
    put_in = SimulatedEffect(**effect)
    with SessionStore(session, study) as store:
        if store.participants():
            raise DataError(f"{session}: was begun already; delete it, or give another folder")
        who = [
            store.enrol(
                f"S{number:03d}", language=study.languages[number % len(study.languages)], simulated=True
            )
            for number in range(1, participants + 1)
        ]
    told = [f"{key}={json.dumps(value)}" for key, value in changes.items()]
    server = StudyServer(name, session, [one.code for one in who], told)
    began = time.monotonic()
    server.start()
    try:
        expected = participants * (study.trials + 2)
        sitting = take_all(
            server,
            study,
            who,
            put_in,
            seed=seed,
            at_once=at_once,
            kill_at=max(1, expected // 2 - 1),
            progress=_say,
        )
    finally:
        server.kill()
    seconds = time.monotonic() - began
    with SessionStore(session) as store:
        answers = store.answers()
        unfinished = [one for one in store.progress() if one["status"] != "finished"]
    if not sitting.killed:
        raise DataError(f"{name}: was at its end before the server was to be killed")
    _check(sitting.wrong, unfinished, answers.rows, sitting.given)
    _verb(
        "study", "export", str(session), "--out", str(folder / "answers.csv"), "--bids", str(folder / "bids")
    )
    return {
        "study": name,
        "simulated": True,
        "participants": participants,
        "changes": dict(changes),
        "effect": dict(effect),
        "seed": seed,
        "pages": sitting.pages,
        "answers": len(answers),
        "killed": sitting.killed,
        "reloads": sitting.reloads,
        "lost": 0,
        "twice": 0,
        "seconds": round(seconds, 1),
        "bids_problems": _bids_problems(folder / "bids"),
    }


def analysis_of(place: Path, *, draws: int = 2000) -> dict[str, Any]:
    """Return what ``study analyse`` says of an export; what it said before is not asked again."""
    said = place / "analysis" / "analysis.json"
    if not said.is_file():
        answers = str(place / "answers.csv")
        _verb("study", "analyse", answers, "--out", str(said.parent), "--draws", str(draws))
    analysis: dict[str, Any] = json.loads(said.read_text(encoding="utf-8"))
    return analysis


def _check(
    wrong: Sequence[str], unfinished: Sequence[Any], rows: Sequence[Any], given: Mapping[tuple[str, str], Any]
) -> None:
    """Hold what is stored against what was answered."""
    if wrong:
        raise DataError(f"a page failed: {wrong[0]}")
    if unfinished:
        raise DataError(f"participant {unfinished[0]['participant']} is not at the end")
    stored: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        stored.setdefault((row.participant, row.more["token"]), []).append(row.answer)
    if lost := set(given) ^ set(stored):
        raise DataError(f"{len(lost)} pages were answered and not stored, or stored and not answered")
    for key, answers in given.items():
        if len(answers) != len(stored[key]) or not all(map(_same, answers, stored[key])):
            raise DataError(f"{key[0]} answered {answers} to {key[1]}, and {stored[key]} is stored")


def _same(given: str, stored: str) -> bool:
    """Return whether an answer is the one that was given; a mark on a line is set to a pixel."""
    if given == stored:
        return True
    try:
        return abs(float(given) - float(stored)) < 0.3
    except ValueError:
        return False


def _verb(*arguments: str) -> dict[str, Any]:
    done = subprocess.run(
        [sys.executable, "-m", "tactogram", *arguments, "--json"],
        check=False,
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise DataError(f"tactogram {' '.join(arguments[:2])} failed: {done.stderr.strip()[-300:]}")
    result: dict[str, Any] = json.loads(done.stdout)
    return result


def _bids_problems(folder: Path) -> list[str]:
    """Return the codes of the errors that the BIDS validator finds."""
    imported("bids_validator_deno", extra="dev", what="the BIDS validator")
    validator = Path(sys.executable).with_name("bids-validator-deno")
    done = subprocess.run(
        [validator, folder, "--format", "json"], check=False, capture_output=True, text=True
    )
    issues = json.loads(done.stdout)["issues"]["issues"]
    return sorted({issue["code"] for issue in issues if issue["severity"] == "error"})


def _table(found: Mapping[str, Any]) -> str:
    """Return both tables in Markdown: what was recovered, and how it was taken."""
    lines = [
        "Simulated participants in a real browser; the server was killed (SIGKILL) in the middle and started again.",
        "No measure of touch: who answered, and what was felt, is simulated.",
        "",
        *_row(RECOVERY),
        *_row(["---"] * len(RECOVERY)),
    ]
    for name, kinds in found.items():
        for kind, facts in kinds.items():
            for one in facts["recovery"]:
                lines += _row([name, "effect" if kind == "effect" else "none", *_recovered(one)])
    lines += ["", *NOTES, "", *_row(COLUMNS), *_row(["---"] * len(COLUMNS))]
    for name, kinds in found.items():
        for facts in kinds.values():
            counts = [facts[key] for key in ("participants", "pages", "killed", "reloads", "lost", "twice")]
            asked = json.dumps(facts["changes"]) if facts["changes"] else "every trial"
            cells = [json.dumps(facts["effect"]), facts["seed"], *counts, len(facts["bids_problems"]), asked]
            lines += _row([name, *cells])
    return "\n".join(lines)


def _recovered(one: Mapping[str, Any]) -> list[str]:
    """Return the cells of what was looked at."""
    p = "-" if one["p"] is None else p_text(one["p"])
    equal = f"±{one['margin']:g}: {p_text(one['equivalence_p'])}" if one["equivalence_p"] is not None else "-"
    others = (
        f"{one['others_shown']} shown, {one['others_equivalent']} equivalent, of {one['others']}"
        if one["others"]
        else "-"
    )
    interval = f"{one['estimate']:.3f} ({one['low']:.3f} to {one['high']:.3f})"
    covers = "yes" if one["covers"] else "no"
    of = f"{one['of']} [{one['test']}]"
    return [of, f"{one['put_in']:.3f} {one['unit']}", interval, covers, p, equal, one["outcome"], others]


def _row(cells: Sequence[Any]) -> list[str]:
    return ["| " + " | ".join(str(cell).replace("|", "/") for cell in cells) + " |"]


def _say(text: str) -> None:
    sys.stderr.write(f"{text}\n")
    sys.stderr.flush()

"""Each shipped study taken by simulated participants in a real browser, its server killed in the middle, and analysed.

Once with an effect that was put in, once without. No measure of touch: participants, stimuli and answers are simulated.
What is shown is that the way from the page to the verdict loses nothing, and says what is there, and what is not.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.experiments.browser_participants import StudyServer, take_all
from benchmarks.experiments.study_recovery import recoveries
from tactogram.errors import DataError, ParameterError
from tactogram.extras import imported
from tactogram.signal.io.atomic import write_text
from tactogram.study.analysis.findings import p_text
from tactogram.study.session.store import SessionStore
from tactogram.study.simulated_participants import SimulatedEffect
from tactogram.study.study_file import Study
from tactogram.workflows.progress import ProgressCallback


@dataclass(frozen=True)
class Taken:
    """How one shipped study is taken.

    Parameters
    ----------
    effect : mapping
        Of `SimulatedEffect`: what is put in.
    bench : mapping
        Values of the study that are changed for two cores, by dotted key; reported with the result.
    people : mapping
        Of `SimulatedEffect`, too: what is true of them with an effect and without.
    """

    effect: Mapping[str, Any]
    bench: Mapping[str, Any]
    people: Mapping[str, Any] = field(default_factory=dict)


ALIKE: Mapping[str, Any] = {"typical_sd": 0.0}
"""Items that are alike to all, so that what was not put in is not there: where items are compared, not conditions."""
STUDIES: Mapping[str, Taken] = {
    "plate-words": Taken({"shift": {"plate01": 1.5}}, {}, ALIKE),
    "evoked-words": Taken({"shift": {"image001": 2.0}}, {"design.set_size": 16, "grid.count": 16}, ALIKE),
    "abx": Taken({"d_prime": 2.0}, {"design.repeats": 4}),
    "display-words": Taken({"shift": {"A": 1.0}}, {"grid.count": 3}),
    "image-words": Taken({"shift": {"1000": 1.0}}, {"grid.count": 3}),
    "magnitude": Taken({"exponent": 0.8}, {}),
    "two-area": Taken({"d_prime": 1.5, "shift": {"generated": -10.0}}, {"design.repeats": 1}),
    "preference": Taken({"shift": {"carpet": 1.5}}, {"design.comparisons": 30}),
    "threshold": Taken(
        {"threshold_db": -25.0, "shift": {"tile": 8.0}}, {"design.reversals": 6, "design.most_trials": 40}
    ),
}
"""What is put in, of each that is shipped."""
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
    """Return what the analysis says of each study, with an effect that was put in and without.

    Parameters
    ----------
    folder, progress
        As of every experiment. What was done already is in ``folder`` and is not done again.
    paper : bool
        Every trial of each study; else the changes of `STUDIES`, for two cores.
    studies : str
        Which, joined by commas; by default all that are shipped.
    participants, at_once : int
        Simulated ones, and how many of them at the same time.
    draws : int
        Of the bootstraps.
    """
    chosen = [name.strip() for name in studies.split(",") if name.strip()] or list(STUDIES)
    if unknown := set(chosen) - set(STUDIES):
        raise ParameterError(f"studies must be of {', '.join(STUDIES)}, got {', '.join(sorted(unknown))}")
    found: dict[str, Any] = {}
    for name in chosen:
        for kind, seed in SEEDS.items():
            place, of = folder / f"{name}-{kind}", STUDIES[name]
            if not (place / "taken.json").is_file():
                facts = take_study(
                    name,
                    place,
                    changes={} if paper else of.bench,
                    effect={**(of.effect if kind == "effect" else {}), **of.people},
                    participants=participants,
                    seed=seed,
                    at_once=at_once,
                )
                write_text(place / "taken.json", json.dumps(facts, ensure_ascii=False, indent=1) + "\n")
            taken = json.loads((place / "taken.json").read_text(encoding="utf-8"))
            analysis = analysis_of(place, draws=draws)
            study = Study.load(name, changes=taken["changes"])
            recovery = recoveries(name, analysis, study, taken["effect"], seed=taken["seed"], kind=kind)
            found.setdefault(name, {})[kind] = {**taken, "recovery": recovery}
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
        [sys.executable, "-m", "tactogram.cli", *arguments, "--json"],
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

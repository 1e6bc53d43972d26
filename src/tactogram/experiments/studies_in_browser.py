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
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError
from tactogram.experiments._browser_participants import StudyServer, take_all
from tactogram.study.session_store import SessionStore
from tactogram.study.simulated import SimulatedEffect
from tactogram.study.study_file import Study
from tactogram.training.run import write_text


@dataclass(frozen=True)
class Taken:
    """How one shipped study is taken.

    Parameters
    ----------
    effect : mapping
        Of `SimulatedEffect`: what is put in.
    bench : mapping
        Values of the study that are changed for two cores, by dotted key; reported with the result.
    """

    effect: Mapping[str, Any]
    bench: Mapping[str, Any]


STUDIES: Mapping[str, Taken] = {
    "plate-words": Taken({"shift": {"plate01": 1.5}}, {}),
    "preference": Taken({"shift": {"carpet": 1.5}}, {}),
    "magnitude": Taken({"exponent": 0.8}, {}),
    "abx": Taken({"d_prime": 2.0}, {"design.repeats": 4}),
    "threshold": Taken({"threshold_db": -25.0}, {"design.reversals": 4, "design.most_trials": 30}),
    "two-area": Taken({"d_prime": 1.5, "shift": {"generated": -10.0}}, {"design.repeats": 1}),
    "display-words": Taken({"shift": {"A": 1.0}}, {"grid.count": 2}),
    "image-words": Taken({"shift": {"1000": 1.0}}, {"grid.count": 3}),
    "evoked-words": Taken({"shift": {"image001": 2.0}}, {"design.set_size": 8, "grid.count": 8}),
}
"""The cheap ones first."""
COLUMNS = (
    *("study", "put in", "participants (simulated)", "pages", "reloads", "lost", "twice"),
    *("BIDS problems", "shown of tested", "first findings"),
)


def run(
    jobs: Any,
    folder: Path,
    *,
    paper: bool,
    studies: str = "",
    participants: int = 20,
    at_once: int = 4,
    draws: int = 2000,
) -> dict[str, Any]:
    """Return what the analysis says of each study, with an effect that was put in and without.

    Parameters
    ----------
    jobs, folder
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
        for kind in ("effect", "none"):
            place = folder / f"{name}-{kind}"
            if not (place / "taken.json").is_file():
                changes = {} if paper else STUDIES[name].bench
                effect = STUDIES[name].effect if kind == "effect" else {}
                facts = take_study(
                    name,
                    place,
                    changes=changes,
                    effect=effect,
                    participants=participants,
                    at_once=at_once,
                    draws=draws,
                )
                write_text(place / "taken.json", json.dumps(facts, ensure_ascii=False, indent=1) + "\n")
            taken = json.loads((place / "taken.json").read_text(encoding="utf-8"))
            analysis = json.loads((place / "analysis" / "analysis.json").read_text(encoding="utf-8"))
            found.setdefault(name, {})[kind] = {**taken, "findings": _findings(analysis)}
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
    at_once: int = 4,
    draws: int = 2000,
) -> dict[str, Any]:
    """Let simulated participants take a study in the browser with one kill, export, check and analyse it.

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
    participants, at_once, draws : int
        See `run`.

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
            server, study, who, put_in, at_once=at_once, kill_at=max(1, expected // 2 - 1), progress=_say
        )
    finally:
        server.kill()
    seconds = time.monotonic() - began
    with SessionStore(session) as store:
        answers = store.answers()
        unfinished = [one for one in store.progress() if one["status"] != "finished"]
    _check(sitting.wrong, unfinished, answers.rows, sitting.given)
    exported = _verb(
        "study", "export", str(session), "--out", str(folder / "answers.csv"), "--bids", str(folder / "bids")
    )
    _verb(
        "study",
        "analyse",
        str(folder / "answers.csv"),
        "--out",
        str(folder / "analysis"),
        "--draws",
        str(draws),
    )
    return {
        "study": name,
        "simulated": True,
        "participants": participants,
        "changes": dict(changes),
        "effect": dict(effect),
        "pages": sitting.pages,
        "answers": len(answers),
        "killed": sitting.killed,
        "reloads": sitting.reloads,
        "lost": 0,
        "twice": 0,
        "seconds": round(seconds, 1),
        "bids_problems": exported["bids_problems"],
    }


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


def _findings(analysis: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what decides: the confirmatory findings of each section, or its means where nothing is compared."""
    kept = (
        "of",
        "test",
        "measure",
        "estimate",
        "low",
        "high",
        "p",
        "verdict",
        "participants",
        "n",
        "correction",
    )
    found = []
    for section in analysis["sections"]:
        place = {"section": section["title"], "question": section["question"]}
        decide = [one for one in section["findings"] if one["role"] == "confirmatory"]
        found += [{**place, **{key: one[key] for key in kept}} for one in decide]
        if not decide:
            found += [
                {
                    **place,
                    "of": row.get("condition") or "all",
                    "measure": title,
                    "estimate": row["mean"],
                    "verdict": "",
                }
                | {"low": row["low"], "high": row["high"]}
                for title, rows in section["tables"].items()
                for row in rows
                if {"mean", "low", "high"} <= set(row) and "word" not in row
            ]
    return found


def _table(found: Mapping[str, Any]) -> str:
    """Return the table in Markdown."""
    lines = [
        "Simulated participants in a real browser; the server was killed (SIGKILL) in the middle and started again.",
        "",
        "| " + " | ".join(COLUMNS) + " |",
        "| --- " * len(COLUMNS) + "|",
    ]
    for name, kinds in found.items():
        for facts in kinds.values():
            findings = facts["findings"]
            tested = [one["verdict"] for one in findings if one["verdict"]]
            shown = f"{tested.count('shown')} of {len(tested)}" if tested else "nothing is compared"
            first = "; ".join(_line(one) for one in findings[:2]) or "-"
            effect = json.dumps(facts["effect"]) if facts["effect"] else "none"
            counts = [facts[key] for key in ("participants", "pages", "reloads", "lost", "twice")]
            cells = [name, effect, *counts, len(facts["bids_problems"]), shown, first]
            lines.append("| " + " | ".join(map(str, cells)) + " |")
    changed = {name: STUDIES[name].bench for name in found if any(k["changes"] for k in found[name].values())}
    lines += [
        "",
        f"Changed for two cores: {json.dumps(changed)}" if changed else "Every trial of each study.",
    ]
    return "\n".join(lines)


def _line(one: Mapping[str, Any]) -> str:
    interval = f" ({one['low']:.3g} to {one['high']:.3g})" if one["low"] is not None else ""
    return f"{one['of']}: {one['measure']} {one['estimate']:.3g}{interval}, {one['verdict']}".replace(
        "|", "/"
    )


def _say(text: str) -> None:
    sys.stderr.write(f"{text}\n")
    sys.stderr.flush()

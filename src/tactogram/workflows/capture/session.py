"""Recording sessions: the plan, the source, the store and, where asked for, a classifier that listens along."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TextIO
from urllib.parse import quote

from tactogram.capture import Source, open_source
from tactogram.capture.catalogue import parse_address
from tactogram.capture.session.console import Console, LineConsole
from tactogram.capture.session.journal import Journal
from tactogram.capture.session.metronome import (
    BellMetronome,
    LoudspeakerMetronome,
    Metronome,
    SilentMetronome,
)
from tactogram.capture.session.plan import SessionPlan, shipped_plans
from tactogram.capture.session.session import Recognise, RecordingSession, session_folder
from tactogram.capture.source import PlanFollower
from tactogram.capture.stream.monitor import BlockListener, TappedSource
from tactogram.datasets import open_store
from tactogram.errors import TactogramError
from tactogram.extras import device_errors, imported
from tactogram.signal import Signal


def plans() -> dict[str, str]:
    """Return the session plans that come with the package: a line on each, by name."""
    return {name: SessionPlan.load(name).title for name in shipped_plans()}


def capture(
    plan: Path | str,
    address: str,
    data: Path | str,
    *,
    session: str = "",
    changes: Mapping[str, Any] | None = None,
    yes: bool = False,
    answers: TextIO | None = None,
    recognise: Path | str | None = None,
    sound: bool = True,
    console: Console | None = None,
    metronome: Metronome | None = None,
    heard: BlockListener | None = None,
) -> dict[str, Any]:
    """Run a session plan, or go on with one; every accepted take is in the store before the next one begins.

    Parameters
    ----------
    plan : path or str
        A TOML file, or one of `plans` by name.
    address : str
        What is recorded; see `tactogram.capture.open_source`.
    data : path
        The store; made with the first take.
    session : str, optional
        What the session is called; by default as the plan says, else the plan's own name and the subject.
    changes : mapping, optional
        Values of the plan that differ from its file, by key.
    yes : bool
        Ask nobody: begin every take, accept a good one, make a bad one again, and skip it after three.
    answers : text file, optional
        Where answers come from if there is no terminal; by default stdin.
    recognise : path, optional
        A classifier run that says what each take sounds like.
    sound : bool
        Whether the metronome may be heard; else it is silent.
    console : Console, optional
        Where the session is shown and asked, if not on the terminal.
    metronome : Metronome, optional
        What beats instead of a loudspeaker.
    heard : callable, optional
        Called with the source and each block as it is read; see `TappedSource`.

    Returns
    -------
    dict
        ``store``, ``session``, ``folder`` (diary and raw logs), ``accepted``, ``redone``, ``skipped``, ``left``,
        ``stopped``, ``recordings`` (in the store), ``sha256`` of the store, ``simulated``, ``source`` (its facts).
    """
    known = dict(changes or {})
    values = SessionPlan.load(plan, changes=known)
    store = Path(data)
    name = session or values.session or "-".join(filter(None, (Path(plan).stem, values.subject)))
    folder = session_folder(store, name)
    listening = None if recognise is None else _listening(recognise)
    with ExitStack() as stack:
        journal = stack.enter_context(Journal(folder))
        log = _next_log(folder)
        try:
            opened = open_source(with_log(address, log))
            source = stack.enter_context(opened if heard is None else TappedSource(opened, heard))
        except BaseException:
            # It was made before the device did not open, and holds nothing.
            log.unlink(missing_ok=True)
            raise
        if console is None:
            console = stack.enter_context(_console(yes, answers))
        if metronome is None:
            metronome = _metronome(console) if sound and values.metronome else SilentMetronome()
        run = RecordingSession(
            values, store, name, source, console, journal,
            metronome=metronome, recognise=listening, on_trial=_on_trial(opened), log=log.name if log.exists() else "",
        )  # fmt: skip
        result = run.run()
        facts = source.facts()
    there = open_store(store) if store.exists() else None
    return {
        "store": str(store),
        "session": name,
        "folder": str(folder),
        **result,
        "recordings": 0 if there is None else len(there),
        "sha256": None if there is None else there.sha256,
        "simulated": bool(facts.get("simulated")),
        "source": facts,
    }


def with_log(address: str, log: Path) -> str:
    """Return an address whose source keeps every byte in ``log``, where it is of a kind that has bytes to keep."""
    _, _, options = parse_address(address)
    if not hasattr(options, "log") or options.log is not None:
        return address
    return f"{address}{'&' if '?' in address else '?'}log={quote(str(log))}"


def _next_log(folder: Path) -> Path:
    """Return a name that is free: a log is of one connection, so each run of a session has its own."""
    numbers = [int(path.stem.partition("-")[2]) for path in folder.glob("raw-[0-9]*.log")]
    return folder / f"raw-{max(numbers, default=0) + 1:03d}.log"


def _listening(run: Path | str) -> Recognise:
    # Torch is imported for this alone: a session without it begins at once.
    from tactogram.workflows.training.loaded_run import load_run

    loaded = load_run(run)

    def recognise(signal: Signal) -> Mapping[str, float]:
        probabilities = loaded.classifier.probabilities(loaded.prepare(signal))
        return dict(zip(loaded.kind.materials, probabilities.tolist(), strict=True))

    return recognise


def _console(yes: bool, answers: TextIO | None) -> Any:
    """Return a context that gives a console: a panel with keys on a terminal, lines elsewhere."""
    keys = importlib.util.find_spec("termios") is not None  # Windows has none: answers are lines there
    if keys and not yes and answers is None and sys.stdin.isatty() and sys.stderr.isatty():
        from tactogram.capture.session.terminal import TerminalConsole

        return TerminalConsole()
    return LineConsole(None if yes else answers or sys.stdin)


def _metronome(console: Console) -> Metronome:
    """Return what beats: a loudspeaker where there is one, else the terminal's bell, else nothing."""
    try:
        sounddevice = imported("sounddevice", extra="devices", what="a metronome that is heard")
        with device_errors("loudspeaker", library="sounddevice"):
            sounddevice.query_devices(kind="output")
    except TactogramError as error:
        if not sys.stderr.isatty():
            console.say("no loudspeaker and no terminal: the metronome is silent")
            return SilentMetronome()
        console.say(f"the metronome is the terminal's bell ({error})")
        return BellMetronome()

    def play(signal: Signal) -> None:
        sounddevice.play(signal.samples[0], int(signal.rate))

    return LoudspeakerMetronome(play, sounddevice.stop)


def _on_trial(source: Source) -> Callable[[Any], None] | None:
    """Return what tells a simulated device what to stroke; None for real ones."""
    return source.on_trial if isinstance(source, PlanFollower) else None

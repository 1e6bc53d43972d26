"""Recording sessions: the plan, the source, the store and optionally a classifier of each take."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, TextIO
from urllib.parse import quote

from tactogram.datasets import open_store
from tactogram.errors import TactogramError
from tactogram.extras import device_errors, imported
from tactogram.signal import Signal
from tactogram.workflows import takes
from tactogram_capture import Source, open_source
from tactogram_capture.catalogue import parse_address
from tactogram_capture.session.console import Console, LineConsole
from tactogram_capture.session.journal import Journal
from tactogram_capture.session.metronome import Metronome
from tactogram_capture.session.plan import SessionPlan, shipped_plans
from tactogram_capture.session.session import Recognise, RecordingSession, session_folder
from tactogram_capture.source import PlanFollower, TappedSource
from tactogram_capture.workflows.requests import CaptureRequest


def plans() -> dict[str, str]:
    """Return the titles of the session plans that come with the package, by name."""
    return {name: SessionPlan.load(name).title for name in shipped_plans()}


@takes(CaptureRequest)
def capture(request: CaptureRequest) -> dict[str, Any]:
    """Run or continue a recording session; every accepted take is stored before the next one begins.

    Keys of the result: ``store``, ``session``, ``folder`` (journal and raw logs), ``accepted``, ``redone``,
    ``skipped``, ``left``, ``stopped``, ``recordings`` (in the store), ``sha256`` of the store, ``simulated``,
    ``source`` (its facts).
    """
    subject = {"subject": request.subject} if request.subject else {}
    values = SessionPlan.load(request.plan, changes={**(request.changes or {}), **subject})
    store = Path(request.data)
    stem = Path(request.plan).stem
    name = request.session or values.session or "-".join(filter(None, (stem, values.subject)))
    folder = session_folder(store, name)
    recognise = None if request.recognise is None else _recogniser(request.recognise)
    with ExitStack() as stack:
        journal = stack.enter_context(Journal(folder))
        log = _next_log(folder)
        try:
            opened = open_source(with_log(request.source, log))
            source = stack.enter_context(
                opened if request.heard is None else TappedSource(opened, request.heard)
            )
        except BaseException:
            # The log was made before the device failed to open, and is empty.
            log.unlink(missing_ok=True)
            raise
        console = request.console
        if console is None:
            console = stack.enter_context(_console(request.yes, request.answers))
        metronome = request.metronome
        if metronome is None:
            audible = request.sound and values.metronome
            metronome = _metronome(console) if audible else Metronome()
        run = RecordingSession(
            values, store, name, source, console, journal,
            metronome=metronome, recognise=recognise, on_trial=_on_trial(opened), log=log.name if log.exists() else "",
        )  # fmt: skip
        result = run.run()
        facts = source.facts()
    written = open_store(store) if store.exists() else None
    return {
        "store": str(store),
        "session": name,
        "folder": str(folder),
        **result,
        "recordings": 0 if written is None else len(written),
        "sha256": None if written is None else written.sha256,
        "simulated": bool(facts.get("simulated")),
        "source": facts,
    }


def with_log(address: str, log: Path) -> str:
    """Return an address whose source writes every byte to ``log``, if its kind reads bytes."""
    _, _, options = parse_address(address)
    if not hasattr(options, "log") or options.log is not None:
        return address
    return f"{address}{'&' if '?' in address else '?'}log={quote(str(log))}"


def _next_log(folder: Path) -> Path:
    """Return a free name: a log is of one connection, so each run of a session has its own."""
    numbers = [int(path.stem.partition("-")[2]) for path in folder.glob("raw-[0-9]*.log")]
    return folder / f"raw-{max(numbers, default=0) + 1:03d}.log"


def _recogniser(run: Path | str) -> Recognise:
    # Imports torch: a session without a classifier begins at once.
    from tactogram.workflows import load_run

    loaded = load_run(run)

    def recognise(signal: Signal) -> Mapping[str, float]:
        probabilities = loaded.classifier.probabilities(loaded.prepare(signal))
        return dict(zip(loaded.kind.materials, probabilities.tolist(), strict=True))

    return recognise


def _console(yes: bool, answers: TextIO | None) -> Any:
    """Return the context of a console: a panel with keys on a terminal, lines elsewhere."""
    keys = importlib.util.find_spec("termios") is not None  # Windows has none: answers are lines there
    if keys and not yes and answers is None and sys.stdin.isatty() and sys.stderr.isatty():
        from tactogram_capture.session.terminal import TerminalConsole

        return TerminalConsole()
    return LineConsole(None if yes else answers or sys.stdin)


def _metronome(console: Console) -> Metronome:
    """Return a metronome on a loudspeaker if there is one, else silence."""
    try:
        sounddevice = imported("sounddevice", extra="devices", what="an audible metronome")
        with device_errors("loudspeaker", library="sounddevice"):
            sounddevice.query_devices(kind="output")
    except TactogramError as error:
        console.say(f"the metronome is silent: {error}")
        return Metronome()

    def play(signal: Signal) -> None:
        sounddevice.play(signal.samples[0], int(signal.rate))

    return Metronome(play, sounddevice.stop)


def _on_trial(source: Source) -> Callable[[Any], None] | None:
    """Return a callback that tells a simulated device its next stroke; None for real ones."""
    return source.on_trial if isinstance(source, PlanFollower) else None

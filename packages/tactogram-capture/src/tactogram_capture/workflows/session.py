"""Recording sessions: the plan, the source, the store and optionally a classifier of each take."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO
from urllib.parse import quote

from tactogram.errors import TactogramError
from tactogram.extras import device_errors, imported
from tactogram.parameters import checked
from tactogram_capture.catalogue import open_source, parse_address
from tactogram_capture.session.plan import SessionPlan, shipped_plans
from tactogram_capture.source import TappedSource

if TYPE_CHECKING:
    from tactogram.signal import Signal
    from tactogram_capture.session.console import Console
    from tactogram_capture.session.metronome import Metronome
    from tactogram_capture.session.session import Recognise
    from tactogram_capture.source import BlockListener


def plans() -> dict[str, str]:
    """Return the titles of the session plans that come with the package, by name."""
    return {name: SessionPlan.load(name).title for name in shipped_plans()}


@checked
def capture(
    plan: Path | str,
    *,
    source: str,
    data: Path | str,
    session: str = "",
    subject: str | None = None,
    changes: Mapping[str, Any] | None = None,
    recognise: Path | str | None = None,
    yes: bool = False,
    silent: bool = False,
    answers: TextIO | None = None,
    console: Console | None = None,
    metronome: Metronome | None = None,
    heard: BlockListener | None = None,
) -> dict[str, Any]:
    """Record a session by a plan, or continue one; every accepted take is stored before the next one begins.

    ``answers`` is the source of answers without a terminal, by default stdin; ``console`` and ``metronome`` take the
    place of those of the terminal. ``heard`` receives the source and each block as it is read, see `TappedSource`.

    Parameters
    ----------
    plan : Path or str
        A session plan: a TOML file, or one of --list.
    source : str
        Source of the samples: twelite:/dev/ttyUSB0, serial:PORT, lsl:NAME, audio:NAME, ni:Dev1/ai0:2, digilent:,
        log:FILE, played:STORE.
    data : Path or str
        The store; made with the first take.
    session : str
        Name of the session (default: the plan and the subject).
    subject : str, optional
        Who strokes, as a code, since the store keeps it.
    changes : mapping, optional
        Change a value of the plan, as KEY=VALUE.
    recognise : Path or str, optional
        Run of a classifier that recognises each take.
    yes : bool
        Ask no questions: accept good takes, redo bad ones, skip after three.
    silent : bool
        No metronome.

    Returns
    -------
    dict
        ``store``, ``session``, ``folder`` (journal and raw logs), ``accepted``, ``redone``, ``skipped``, ``left``,
        ``stopped``, ``recordings`` (in the store), ``sha256`` of the store, ``simulated``, ``source`` (its facts).

    Raises
    ------
    ParameterError
        If there is no such plan or kind of source, or a value of them is wrong.
    DeviceError
        If the source cannot be opened, or disappears; accepted takes are in the store.
    DataError
        If the session was begun with another plan, or another process uses it.
    """
    from tactogram.datasets import open_store
    from tactogram_capture.session.journal import Journal
    from tactogram_capture.session.metronome import Metronome
    from tactogram_capture.session.session import RecordingSession, session_folder

    of_subject = {"subject": subject} if subject else {}
    values = SessionPlan.load(plan, changes={**(changes or {}), **of_subject})
    store = Path(data)
    name = session or values.session or "-".join(filter(None, (Path(plan).stem, values.subject)))
    folder = session_folder(store, name)
    classify = None if recognise is None else _recogniser(recognise)
    with ExitStack() as stack:
        journal = stack.enter_context(Journal(folder))
        log = _next_log(folder)
        try:
            device = open_source(with_log(source, log))
            opened = stack.enter_context(device if heard is None else TappedSource(device, heard))
        except BaseException:
            # The log was made before the device failed to open, and is empty.
            log.unlink(missing_ok=True)
            raise
        if console is None:
            console = stack.enter_context(_console(yes, answers))
        if metronome is None:
            metronome = Metronome() if silent or not values.metronome else _metronome(console)
        run = RecordingSession(
            values, store, name, opened, console, journal,
            metronome=metronome, recognise=classify, log=log.name if log.exists() else "",
            on_trial=getattr(device, "on_trial", None),  # of a simulated source that follows the plan
        )  # fmt: skip
        result = run.run()
        facts = opened.facts()
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
    from tactogram_capture.session.console import LineConsole

    keys = importlib.util.find_spec("termios") is not None  # Windows has none: answers are lines there
    if keys and not yes and answers is None and sys.stdin.isatty() and sys.stderr.isatty():
        from tactogram_capture.session.console import TerminalConsole

        return TerminalConsole()
    return LineConsole(None if yes else answers or sys.stdin)


def _metronome(console: Console) -> Metronome:
    """Return a metronome on a loudspeaker if there is one, else silence."""
    from tactogram_capture.session.metronome import Metronome

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

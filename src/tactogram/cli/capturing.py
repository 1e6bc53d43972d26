"""Verbs that record: sessions by a plan, and what a trained classifier makes of a sensor as it comes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from tactogram.cli.options import Verbs, models_option
from tactogram.cli.printing import Arguments, columns, print_result, text_of

if TYPE_CHECKING:
    from tactogram.capture.live.recognition import WindowClassification
    from tactogram.workflows.capture.live import LiveClassifier

SOURCE = "twelite:/dev/ttyUSB0, serial:PORT, lsl:NAME, audio:NAME, ni:Dev1/ai0:2, digilent:, log:FILE, played:STORE"


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("capture", capture)
    add("plan", metavar="PLAN", nargs="?", help="a session plan: a TOML file, or one of --list")
    add("--list", action="store_true", help="list the plans that come with the package")
    add("--source", metavar="ADDRESS", help=f"what is recorded: {SOURCE}")
    add("--data", metavar="DIR", help="the store; made with the first take")
    add(
        "--session",
        default="",
        metavar="NAME",
        help="name of the session (default: the plan and the subject)",
    )
    add("--subject", metavar="CODE", help="who strokes, as a code, since the store keeps it")
    add("--set", action="append", default=[], metavar="KEY=VALUE", help="change a value of the plan")
    add("--recognise", metavar="RUN", help="classifier that recognises each take")
    add(
        "--yes",
        action="store_true",
        help="ask no questions: accept good takes, redo bad ones, skip after three",
    )
    add("--silent", action="store_true", help="no metronome")
    models_option(add)

    add = verbs.add("live", live)
    add("run_folder", metavar="RUN")
    add("--source", required=True, metavar="ADDRESS", help=SOURCE)
    add("--window", type=float, metavar="S", help="length of a window (default: the network's input)")
    add(
        "--hop",
        type=float,
        metavar="S",
        help="time from one window to the next (default: a quarter of a window)",
    )
    add("--rate", type=float, metavar="HZ", help="the source's rate, where it states none")
    add("--seconds", type=float, metavar="S", help="stop after this time (default: at Ctrl-C)")
    models_option(add)


def capture(a: Arguments) -> None:
    """Record a session by a plan, or continue one; every accepted take is stored at once."""
    from tactogram.errors import ParameterError
    from tactogram.recipe import parse_changes
    from tactogram.workflows.capture.session import capture, plans

    if a.list:
        found = plans()
        print_result(a, found, columns(list(found.items())))
        return
    for name in ("plan", "source", "data"):
        if getattr(a, name) is None:
            raise ParameterError(
                f"capture needs {name if name == 'plan' else '--' + name}; --list names the plans"
            )
    changes = parse_changes(a.set) | ({"subject": a.subject} if a.subject else {})
    result = capture(
        a.plan,
        a.source,
        a.data,
        session=a.session,
        changes=changes,
        yes=a.yes,
        recognise=a.recognise,
        sound=not a.silent,
    )
    print_result(a, result, _session_text(result))


def live(a: Arguments) -> None:
    """Classify what a sensor touches, live."""
    from tactogram.workflows.capture.live import live

    with _shown(a) as (begin, show):
        result = live(
            a.run_folder,
            a.source,
            window=a.window,
            hop=a.hop,
            rate=a.rate,
            seconds=a.seconds,
            show=show,
            begin=begin,
        )
    print_result(a, {"summary": result} if a.json else result, _live_text(result))


@contextmanager
def _shown(
    a: Arguments,
) -> Iterator[tuple[Callable[[LiveClassifier], None], Callable[[WindowClassification], None]]]:
    """Give what shows windows: JSON lines on stdout, a panel on a terminal's stderr, or lines there."""
    import json
    import sys

    from tactogram.capture.live.recognition import Latencies
    from tactogram.capture.live.terminal_view import line, panel

    latencies = Latencies()

    def begin(listener: LiveClassifier) -> None:
        facts = f"window {listener.window_s:.2f} s of {len(listener.loaded.kind.materials)} materials"
        sys.stderr.write(f"listening: {facts}; Ctrl-C ends it\n")

    def as_json(guess: WindowClassification) -> None:
        sys.stdout.write(json.dumps(guess.facts(), ensure_ascii=False) + "\n")
        sys.stdout.flush()

    def as_line(guess: WindowClassification) -> None:
        sys.stderr.write(line(guess) + "\n")

    if a.json or not sys.stderr.isatty():
        yield begin, as_json if a.json else as_line
        return
    from rich.console import Console
    from rich.live import Live

    with Live(console=Console(stderr=True), auto_refresh=False) as display:

        def as_panel(guess: WindowClassification) -> None:
            latencies.add(guess)
            display.update(panel(guess, latencies, title=a.source), refresh=True)

        yield begin, as_panel


def _session_text(result: dict[str, Any]) -> str:
    done = f"{result['accepted']} takes accepted, {result['redone']} redone, {result['skipped']} skipped"
    why = f" ({result['stopped']})" if result["stopped"] else ""
    simulated = " (simulated source)" if result["simulated"] else ""
    lines = [f"session {result['session']}{simulated}: {done}, {result['left']} left{why}"]
    lines.append(f"store: {result['store']}, {result['recordings']} recordings")
    lines.append(f"journal and raw logs: {result['folder']}")
    if result["left"]:
        lines.append("run the same command to continue")
    return "\n".join(lines)


def _live_text(result: dict[str, Any]) -> str:
    latency, none = result["latency"], result["none_of_these"]
    simulated = " (simulated)" if result["simulated"] else ""
    lines = [
        f"{result['judged']} of {result['windows']} windows classified{simulated}, {result['skipped']} skipped"
        + ("" if none is None else f", {none} like none of these")
    ]
    lines += [f"  {name:24} {count}" for name, count in result["materials"].items()]
    if latency["p50_ms"] is not None:
        lines.append(
            f"latency, last sample to probabilities: p50 {text_of(latency['p50_ms'])} ms, "
            f"p99 {text_of(latency['p99_ms'])} ms, max {text_of(latency['max_ms'])} ms"
        )
    return "\n".join(lines)

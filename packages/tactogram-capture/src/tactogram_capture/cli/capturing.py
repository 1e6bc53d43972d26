"""Verbs that record sessions, classify a sensor's signal live, test devices, and import logs."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

from tactogram.cli.printing import Printer, columns, text_of
from tactogram.cli.verbs import Verb, flags_of, with_options
from tactogram.workflows import Argument, Option, Request
from tactogram_capture.workflows.requests import CaptureRequest, LiveRequest, LogRequest

if TYPE_CHECKING:
    from tactogram_capture import Block, Source
    from tactogram_capture.live.recognition import WindowClassification
    from tactogram_capture.workflows.live import LiveClassifier


@dataclass(frozen=True)
class _SourcesRequest(Request):
    find_s: Annotated[float, Option("time to search for streams on the network", "S", "--find")] = 0.5


@dataclass(frozen=True)
class _DeviceRequest(Request):
    name: Annotated[
        str, Argument("serial, lsl, daq, dwf (or digilent), audio, null, osc or mouse", metavar="DEVICE")
    ]


def _capture(request: CaptureRequest, show: Printer) -> None:
    from tactogram_capture.workflows.session import capture

    result = capture(**vars(request))
    show(result, _session_text(result))


def _plans(show: Printer) -> None:
    from tactogram_capture.workflows.session import plans

    titles = plans()
    show(titles, columns(list(titles.items())))


def _live(request: LiveRequest, show: Printer) -> None:
    from tactogram_capture.workflows.live import live

    said: list[str] = []

    def heard(source: "Source", _: "Block | None") -> None:
        for note in getattr(source, "notes", ())[len(said) :]:
            said.append(note)
            sys.stderr.write(f"note: {note}\n")

    with _window_printer(request, show) as (begin, show_window):
        result = live(**vars(request) | {"show": show_window, "begin": begin, "heard": heard})
    show({"summary": result} if show.json else result, _live_text(result))


def _sources(request: _SourcesRequest, show: Printer) -> None:
    from tactogram_capture import find_sources

    sources = find_sources(find_s=request.find_s)
    rows = [(one["address"] or f"({one['kind']})", one["missing"] or one["what"]) for one in sources]
    show(sources, columns(rows))


def _device(request: _DeviceRequest, show: Printer) -> None:
    from tactogram_capture.workflows.devices import try_device

    facts = try_device(request.name)
    lines = [f"{facts['device']}: {facts['state']}: {facts['line']}"]
    lines += [f"  {name}: {text_of(value)}" for name, value in facts["facts"].items()]
    lines += [
        f"  {path['title']} ({path['direction']}): tested by simulation with: {path['simulated']}; "
        f"real hardware: {path['hardware']}"
        for path in facts["paths"]
    ]
    lines.append(f"  tactogram {facts['tactogram']}, Python {facts['python']}, {facts['platform']}")
    show(facts, "\n".join(lines))


def _capture_log(request: LogRequest, show: Printer) -> None:
    from tactogram_capture.workflows.logs import capture_log

    result = capture_log(**vars(request))
    show(result, _log_text(result))


@contextmanager
def _window_printer(
    request: LiveRequest, show: Printer
) -> Iterator["tuple[Callable[[LiveClassifier], None], Callable[[WindowClassification], None]]"]:
    """Yield callbacks for the first and each window: JSON lines on stdout, a panel or lines on stderr."""
    import json

    from tactogram_capture.live.recognition import Latencies
    from tactogram_capture.live.terminal_view import line, panel

    latencies = Latencies()

    def begin(classifier: "LiveClassifier") -> None:
        facts = f"window {classifier.window_s:.2f} s of {len(classifier.loaded.kind.materials)} materials"
        sys.stderr.write(f"listening: {facts}; Ctrl-C ends it\n")

    def as_json(guess: "WindowClassification") -> None:
        sys.stdout.write(json.dumps(guess.facts(), ensure_ascii=False) + "\n")
        sys.stdout.flush()

    def as_line(guess: "WindowClassification") -> None:
        sys.stderr.write(line(guess) + "\n")

    if show.json or not sys.stderr.isatty():
        yield begin, as_json if show.json else as_line
        return
    from rich.console import Console
    from rich.live import Live

    with Live(console=Console(stderr=True), auto_refresh=False) as display:

        def as_panel(guess: "WindowClassification") -> None:
            latencies.add(guess)
            display.update(panel(guess, latencies, title=request.source), refresh=True)

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


def _log_text(result: dict[str, Any]) -> str:
    lines = [f"{result['path']}{', simulated' if result['simulated'] else ''}"]
    for one in result["sensors"]:
        facts, rate = one["facts"], one["facts"]["rate"]
        measured = (
            "not measured" if rate is None else f"{rate['hz']:.6g} Hz ({rate['low']:.6g}–{rate['high']:.6g})"
        )
        share = facts["lost"] / max(1, facts["lost"] + facts["samples"])
        lines.append(
            f"{one['name']}: {one['seconds']:.4g} s of {'/'.join(one['axes'])} in {one['unit']} at "
            f"{one['rate']:.6g} Hz, measured {measured}"
        )
        lines.append(
            f"  lost {facts['lost']} samples ({100 * share:.2g} %), rejected {text_of(facts['rejected']) or 0}"
        )
        lines += [
            f"  note: {with_options(note, flags_of(VERBS['capture-log']))}" for note in facts.get("notes", ())
        ]
        if one["filled"] is not None:
            lines.append(f"  filled {text_of(one['filled'])}")
        else:
            lines.append(f"  {len(one['signals'])} pieces between gaps, {one['short']} shorter ones left out")
        lines += [f"  {signal['file']}" for signal in one["signals"] if signal["file"]]
    if "data" in result:
        lines.append(f"{result['data']}: {result['added']} added, {result['recordings']} recordings")
    return "\n".join(lines)


VERBS = {
    "capture": Verb(
        CaptureRequest,
        _capture,
        folders=("models",),
        listing=("list the plans that come with the package", _plans),
    ),
    "live": Verb(LiveRequest, _live, folders=("models",)),
    "sources": Verb(_SourcesRequest, _sources),
    "device": Verb(_DeviceRequest, _device),
    "capture-log": Verb(LogRequest, _capture_log),
}

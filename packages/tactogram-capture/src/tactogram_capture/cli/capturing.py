"""Verbs that record sessions, classify a sensor's signal live, test devices, and import logs."""

from collections.abc import Iterator
from typing import Any

from tactogram.cli.printing import Printer, columns, text_of
from tactogram.cli.verbs import Verb
from tactogram.errors import Message


def _plans(show: Printer) -> None:
    from tactogram_capture.workflows.session import plans

    titles = plans()
    show(titles, columns(list(titles.items())))


def _sources_text(sources: list[dict[str, Any]]) -> str:
    return columns([(row["address"] or f"({row['kind']})", row["missing"] or row["what"]) for row in sources])


def _device_text(facts: dict[str, Any]) -> str:
    lines = [f"{facts['device']}: {facts['state']}: {facts['line']}"]
    lines += [f"  {name}: {text_of(value)}" for name, value in facts["facts"].items()]
    lines += [
        f"  {path['title']} ({path['direction']}): tested by simulation with: {path['simulated']}; "
        f"real hardware: {path['hardware']}"
        for path in facts["paths"]
    ]
    lines.append(f"  tactogram {facts['tactogram']}, Python {facts['python']}, {facts['platform']}")
    return "\n".join(lines)


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


def _log_text(result: dict[str, Any]) -> str:
    lines = [f"{result['path']}{', simulated' if result['simulated'] else ''}"]
    for log in result["sensors"]:
        facts, rate = log["facts"], log["facts"]["rate"]
        measured = (
            "not measured" if rate is None else f"{rate['hz']:.6g} Hz ({rate['low']:.6g}–{rate['high']:.6g})"
        )
        share = facts["lost"] / max(1, facts["lost"] + facts["samples"])
        lines.append(
            f"{log['name']}: {log['seconds']:.4g} s of {'/'.join(log['axes'])} in {log['unit']} at "
            f"{log['rate']:.6g} Hz, measured {measured}"
        )
        lines.append(
            f"  lost {facts['lost']} samples ({100 * share:.2g} %), rejected {text_of(facts['rejected']) or 0}"
        )
        if log["filled"] is not None:
            lines.append(f"  filled {text_of(log['filled'])}")
        else:
            lines.append(f"  {len(log['signals'])} pieces between gaps, {log['short']} shorter ones left out")
        lines += [f"  {signal['file']}" for signal in log["signals"] if signal["file"]]
    if "data" in result:
        lines.append(f"{result['data']}: {result['added']} added, {result['recordings']} recordings")
    return "\n".join(lines)


def _log_notes(result: dict[str, Any]) -> Iterator[str]:
    for log in result["sensors"]:
        yield from (Message(note, place=log["name"]) for note in log["facts"].get("notes", ()))


WORKFLOWS = "tactogram_capture.workflows"

VERBS = {
    "capture": Verb(
        f"{WORKFLOWS}.session:capture",
        _session_text,
        folders=("models",),
        listing=("list the plans that come with the package", _plans),
    ),
    "live": Verb("tactogram_capture.cli.live_view:live_on_terminal", str, folders=("models",)),
    "sources": Verb("tactogram_capture.catalogue:find_sources", _sources_text),
    "device": Verb(f"{WORKFLOWS}.devices:try_device", _device_text),
    "capture-log": Verb(f"{WORKFLOWS}.logs:capture_log", _log_text, _log_notes),
}

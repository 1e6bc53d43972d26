"""Verbs on sources of samples and their logs."""

from __future__ import annotations

from typing import Any

from tactogram.cli.options import Verbs
from tactogram.cli.printing import Arguments, columns, print_result, text_of


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("sources", sources)
    add("--find", type=float, default=0.5, metavar="S", help="time to search for streams on the network")

    add = verbs.add("capture-log", capture_log)
    add("file", metavar="FILE", help="a log of a TWE-Lite receiver or a board, or an .xdf file")
    add("--out", metavar="F", help="a file, by suffix; several signals are numbered")
    add("--data", metavar="DIR", help="a store; created if it does not exist")
    add("--material", help="material touched (required with --data)")
    add("--speed", type=float, metavar="MM_S")
    add("--force", type=float, metavar="N")
    add("--contactor", help="what touched it, e.g. finger or pen")
    add("--kind", choices=("twelite", "serial"), help="what wrote the log, where it is not evident")
    add("--sender", metavar="SID", help="only this sensor")
    add("--rate", type=float, metavar="HZ", help="nominal rate; needed where the log has no times")
    add(
        "--fill",
        choices=("linear", "hold"),
        help="fill gaps (default: one signal for each stretch between them)",
    )
    add("--most", type=float, default=0.1, metavar="S", help="longest gap that is filled")
    add("--least", type=float, default=0.5, metavar="S", help="omit shorter stretches")
    add(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="for a board: time, unit, scale, axes, …",
    )


def sources(a: Arguments) -> None:
    """List the sources that can be recorded from, and what each lacks."""
    from tactogram.capture import find_sources

    found = find_sources(find_s=a.find)
    rows = [(one["address"] or f"({one['kind']})", one["missing"] or one["what"]) for one in found]
    print_result(a, found, columns(rows))


def capture_log(a: Arguments) -> None:
    """Import a sensor's log into files or a store, with its gaps."""
    from tactogram.recipe import parse_changes
    from tactogram.workflows.capture.logs import capture_log

    known: dict[str, Any] = {
        "material": a.material,
        "speed_mm_s": a.speed,
        "force_n": a.force,
        "contactor": a.contactor,
    }
    result = capture_log(
        a.file,
        out=a.out,
        data=a.data,
        kind=a.kind,
        sender=a.sender,
        rate=a.rate,
        fill=a.fill,
        most_s=a.most,
        least_s=a.least,
        options=parse_changes(a.set),
        **known,
    )
    print_result(a, result, _text(result))


def _text(result: dict[str, Any]) -> str:
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
        if one["filled"] is not None:
            lines.append(f"  filled {text_of(one['filled'])}")
        else:
            lines.append(f"  {len(one['signals'])} pieces between gaps, {one['short']} shorter ones left out")
        lines += [f"  {signal['file']}" for signal in one["signals"] if signal["file"]]
    if "data" in result:
        lines.append(f"{result['data']}: {result['added']} added, {result['recordings']} recordings")
    return "\n".join(lines)

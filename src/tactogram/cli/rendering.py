"""Verbs that render signals for displays and measure displays."""

from __future__ import annotations

from typing import Any

from tactogram.cli.options import Add, Verbs, signal_arguments, signal_options
from tactogram.cli.printing import Arguments, columns, lines_of, print_result, text_of


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("displays", displays)
    add("name", nargs="?", metavar="NAME|FILE", help="display to show (default: list all)")
    _changes_option(add)

    add = verbs.add("render", render)
    add("file", metavar="FILE", help="the signal")
    add("--display", required=True, metavar="NAME|FILE", help="one of `displays`, or a TOML file")
    add(
        "--level",
        required=True,
        metavar="LEVEL",
        help="physical, sensation, sensation=DB, gain=FACTOR or peak=SHARE",
    )
    add(
        "--out",
        required=True,
        metavar="F",
        help="the drive: .wav, .csv, .npz …; F.report.json is written beside it",
    )
    add(
        "--as",
        dest="how",
        metavar="WAY",
        help="how axes become one: dft321, mean, channels or the name of an axis",
    )
    add("--speed", type=float, metavar="MM_S", help="finger speed, for a signal over displacement")
    add(
        "--calibration",
        metavar="F.toml",
        help="calibration of an electrovibration display, as `calibrate` wrote it",
    )
    add("--person", metavar="NAME", help="person, where the calibration holds several")
    add("--figure", action="store_true", help="also draw the report: F.report.png")
    signal_options(add)
    _changes_option(add)

    add = verbs.add("sweep", sweep)
    add("display", metavar="NAME|FILE")
    add("--out", required=True, metavar="F")
    add("--seconds", type=float, default=10.0, help="length of the sweep, s (default %(default)g)")
    add(
        "--share",
        type=float,
        default=0.25,
        help="amplitude as a share of the display's limit (default %(default)g)",
    )
    add("--band", type=float, nargs=2, metavar=("LO", "HI"), help="Hz; by default the display's")
    _changes_option(add)

    add = verbs.add("response", response)
    add("played", metavar="PLAYED", help="the sweep, as `sweep` wrote it")
    add("recorded", nargs="+", metavar="RECORDED", help="the measured output; several takes are averaged")
    add("--out", required=True, metavar="F.csv")
    add("--axis", help="axis of the recordings")
    add("--band", type=float, nargs=2, metavar=("LO", "HI"), help="Hz; by default the sweep's")
    signal_options(add)


def displays(a: Arguments) -> None:
    """List the displays, or show one."""
    from tactogram.recipe import parse_changes
    from tactogram.workflows.rendering.render import list_displays, show_display

    if a.name is None:
        found = list_displays()
        rows = [(name, d["family"], f"{d['rate']:g} Hz", d["unit"], d["title"]) for name, d in found.items()]
        print_result(a, found, columns([("name", "family", "rate", "unit", ""), *rows]))
        return
    facts = show_display(a.name, changes=parse_changes(a.set))
    print_result(a, facts, lines_of({name: _shown(value) for name, value in facts.items()}))


def render(a: Arguments) -> None:
    """Render a signal to the drive of a display, with a report of what changed."""
    from tactogram.recipe import parse_changes
    from tactogram.workflows.rendering.render import render

    result = render(
        a.file,
        a.display,
        a.out,
        level=a.level,
        how=a.how,
        speed_mm_s=a.speed,
        changes=parse_changes(a.set),
        calibration=a.calibration,
        person=a.person,
        report_figure=a.figure,
        **signal_arguments(a),
    )
    lines = [result.pop("text"), f"drive: {result['file']}", f"report: {result['report_file']}"]
    lines += [f"figure: {result['figure']}"] if "figure" in result else []
    print_result(a, result, "\n".join(lines))


def sweep(a: Arguments) -> None:
    """Write the sweep that measures a display's response."""
    from tactogram.recipe import parse_changes
    from tactogram.workflows.rendering.render import write_sweep

    facts = write_sweep(
        a.display,
        a.out,
        seconds=a.seconds,
        share=a.share,
        band=tuple(a.band) if a.band else None,
        changes=parse_changes(a.set),
    )
    print_result(a, facts, lines_of(facts))


def response(a: Arguments) -> None:
    """Identify a display's response from a played sweep and its recording."""
    from tactogram.workflows.rendering.render import write_identified

    facts = write_identified(
        a.played,
        a.recorded,
        a.out,
        band=tuple(a.band) if a.band else None,
        axis=a.axis,
        **signal_arguments(a),
    )
    print_result(a, facts, lines_of(facts))


def _changes_option(add: Add) -> None:
    add(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a value of the display, e.g. limit=2",
    )


def _shown(value: Any) -> str:
    """Return a value in one line; a table of points as how many there are."""
    if isinstance(value, dict) and value.get("points"):
        return text_of({**value, "points": f"({len(value['points'])} measured)"})
    return text_of(value)

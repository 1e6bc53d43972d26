"""Verbs on files of signals."""

from __future__ import annotations

from tactogram.cli.options import Verbs, signal_arguments, signal_options
from tactogram.cli.printing import Arguments, lines_of, print_result


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("convert", convert)
    add("source", metavar="A")
    add("target", metavar="B")
    signal_options(add)
    add("--columns", help="columns to read from a table, e.g. ax,ay,az")
    add("--time", metavar="COLUMN", help="the table's column of time stamps")
    add("--sheet", help="the sheet of an .xlsx file")
    add("--full-scale", type=float, metavar="X", help="what integer full scale means, in the unit")
    add("--play-at", type=float, metavar="MM_S", help="speed at which a signal over displacement is met")
    add("--resample", type=float, metavar="HZ", help="rate of B")
    add("--subtype", help="sample format of B, e.g. PCM_16, PCM_24, FLOAT")


def convert(a: Arguments) -> None:
    """Convert a signal from one file format to another."""
    from tactogram.jobs.convert import convert

    facts = convert(
        a.source,
        a.target,
        **signal_arguments(a),
        columns=a.columns.split(",") if a.columns else None,
        time=a.time,
        sheet=a.sheet,
        full_scale=a.full_scale,
        play_at=a.play_at,
        resample_to=a.resample,
        subtype=a.subtype,
    )
    print_result(a, facts, lines_of(facts))

"""Verbs on files of signals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactogram.cli.options import Verbs, signal_arguments, signal_options
from tactogram.cli.printing import Arguments, columns, lines_of, print_result, text_of


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("convert", convert)
    add("source", metavar="A", nargs="?", help="a signal, a haptic file, or a folder of them")
    add("target", metavar="B", nargs="?", help="a file, by suffix; a folder if A is one")
    add("--list", action="store_true", help="list the formats")
    add("--check", action="store_true", help="only validate A, and list what is wrong with it")
    add(
        "--format",
        "--to",
        help="format of B, one of --list: if several share its suffix (.json), or for a folder",
    )
    add("--axis", metavar="NAME|dft321|mean", help="write one axis")
    signal_options(add)
    add("--columns", help="columns to read from a table, e.g. ax,ay,az")
    add("--time", metavar="COLUMN", help="the table's column of time stamps")
    add("--sheet", help="the sheet of an .xlsx file")
    add(
        "--full-scale",
        type=float,
        metavar="X",
        help="value of 1 in a haptic B, or of integer full scale in A, in the signal's unit",
    )
    add("--modality", help='of HJIF and formats like it, e.g. "Vibrotactile Texture" (default: by unit)')
    add("--play-at", type=float, metavar="MM_S", help="finger speed for a signal over displacement")
    add("--resample", type=float, metavar="HZ", help="rate of B")
    add("--subtype", help="sample format of B, e.g. PCM_16, PCM_24, FLOAT")


def convert(a: Arguments) -> int:
    """Convert a signal from one file format to another, a folder of them, or check a haptic file."""
    from pathlib import Path

    from tactogram.errors import ParameterError
    from tactogram.workflows.data import convert as jobs
    from tactogram.workflows.progress import shown

    if a.list:
        formats = jobs.list_formats()
        rows = [(name, facts["suffix"], facts["title"], facts["holds"]) for name, facts in formats.items()]
        print_result(a, formats, columns([("name", "suffix", "", "holds"), *rows]))
        return 0
    if a.source is None:
        raise ParameterError("convert needs A and B; --check takes A alone, --list neither")
    if a.check:
        if a.target is not None:
            raise ParameterError("--check takes one file and writes none; omit B")
        facts = jobs.check(a.source, format=a.format)
        print_result(a, facts, _checked_text(facts))
        return 0 if facts["valid"] else 1
    if a.target is None:
        raise ParameterError("convert needs A and B; --check takes A alone, --list neither")
    options = {
        **signal_arguments(a),
        "columns": a.columns.split(",") if a.columns else None,
        "time": a.time,
        "sheet": a.sheet,
        "full_scale": a.full_scale,
        "play_at": a.play_at,
        "resample_to": a.resample,
        "subtype": a.subtype,
        "axis": a.axis,
        "modality": a.modality,
    }
    if not Path(a.source).is_dir():
        facts = jobs.convert(a.source, a.target, format=a.format, **options)
        print_result(a, facts, _converted_text(facts))
        return 0
    if a.format is None:
        raise ParameterError("a folder needs --to FORMAT, one of --list")
    with shown() as progress:
        facts = jobs.convert_folder(a.source, a.target, format=a.format, progress=progress, **options)
    print_result(a, facts, _folder_text(facts))
    return 1 if facts["failed"] else 0


def _checked_text(facts: Mapping[str, Any]) -> str:
    if facts["valid"]:
        return f"{facts['file']}: valid ({facts['format']})"
    count = len(facts["problems"])
    head = f"{facts['file']}: not valid ({facts['format']}), {count} problem{'s' if count > 1 else ''}"
    return "\n".join([head, *facts["problems"]])


def _converted_text(facts: Mapping[str, Any]) -> str:
    written = facts.get("written") or {}
    own = {name: value for name, value in facts.items() if name != "written"}
    lines = [lines_of(own), lines_of({k: v for k, v in written.items() if k not in ("reduced_by", "loss")})]
    if loss := written.get("loss"):
        by_axis = loss if isinstance(next(iter(loss.values())), Mapping) else {"": loss}
        for axis, values in by_axis.items():
            known = {name: value for name, value in values.items() if value is not None}
            lines.append(f"loss{f' of {axis}' if axis else ''}: {text_of(known)}")
    return "\n".join(line for line in lines if line)


def _folder_text(facts: Mapping[str, Any]) -> str:
    rows = [("file", "s", "full scale", "envelope correlation", "level, dB", "made one by")]
    for file in facts["files"]:
        written = file.get("written") or {}
        loss = written.get("loss") or {}
        seconds = file["samples"] / file["rate_hz"] if "rate_hz" in file else None
        cells = (written.get("full_scale"), loss.get("envelope_correlation"), loss.get("level_db"))
        rows.append(
            (
                file["target"],
                text_of(seconds),
                *(text_of(cell) for cell in cells),
                text_of(file.get("reduced_by")),
            )
        )
    failed = [f"failed: {why}" for why in facts["failed"].values()]
    end = f"{len(facts['files'])} written, {len(facts['failed'])} failed, {facts['left_out']} of no known format"
    return "\n".join([columns(rows), *failed, end])

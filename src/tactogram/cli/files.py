"""Verbs on files of signals."""

from collections.abc import Mapping
from typing import Any

from tactogram.cli.hints import with_options
from tactogram.cli.printing import Printer, columns, lines_of, text_of
from tactogram.cli.verbs import Verb, flags_of


def _text(facts: Mapping[str, Any]) -> str:
    if "failed" in facts:
        return _folder_text(facts)
    return _checked_text(facts) if "valid" in facts else _converted_text(facts)


def _line(message: str) -> str:
    return with_options(message, flags_of(VERBS["convert"]))


def _status(facts: Mapping[str, Any]) -> int:
    return 1 if facts.get("failed") or not facts.get("valid", True) else 0


def _formats(show: Printer) -> None:
    from tactogram.workflows.data.convert import list_formats

    formats = list_formats()
    rows = [(name, facts["suffix"], facts["title"], facts["holds"]) for name, facts in formats.items()]
    show(formats, columns([("name", "suffix", "", "holds"), *rows]))


def _checked_text(facts: Mapping[str, Any]) -> str:
    rows = [
        (
            use["heading"],
            " ".join(filter(None, (use["stream"], use["role"]))),
            use["unit"] or "",
            use["reason"] or "",
        )
        for use in facts.get("columns", [])
    ]
    table = [columns([("column", "read as", "unit", ""), *rows])] if rows else []
    notes = [f"note: {_line(note)}" for note in facts.get("notes", [])]
    notes += [f"warning: {line}" for line in facts.get("warnings", [])]
    if facts["valid"]:
        return "\n".join([f"{facts['file']}: valid ({facts['format']})", *table, *notes])
    count = len(facts["problems"])
    head = f"{facts['file']}: not valid ({facts['format']}), {count} problem{'s' if count > 1 else ''}"
    return "\n".join([head, *map(_line, facts["problems"]), *table, *notes])


_TOLD = ("reduced_by", "loss", "events", "holds", "told", "verdict")
DRAWN = "Drawn from brightness, bright as high: a design, no prediction of how the material feels."


def _converted_text(facts: Mapping[str, Any]) -> str:
    written = facts.get("written") or {}
    other = {name: value for name, value in facts.items() if name not in ("written", "notes")}
    lines = [
        lines_of(other),
        lines_of({k: v for k, v in written.items() if k not in _TOLD}),
    ]
    drawn = "mapped" in facts and facts["mapped"]["by"] == "relief"
    notes = [f"note: {_line(note)}" for note in facts.get("notes", [])]
    return "\n".join([*filter(None, lines), *notes, *[DRAWN] * drawn, *loss_lines(written)])


def loss_lines(written: Mapping[str, Any]) -> list[str]:
    """Return what a haptic file keeps and loses, and the verdict, a line each; ``written`` as of `write_haptic`."""
    return [*written["told"], f"Verdict: {written['verdict']}."] if written else []


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
    beside = [f"not converted: {signal}, beside {designed}" for signal, designed in facts["beside"].items()]
    failed = [f"failed: {_line(why)}" for why in facts["failed"].values()]
    notes = [f"skipped, no table of numbers: {', '.join(facts['notes'])}"] if facts["notes"] else []
    end = f"{len(facts['files'])} written, {len(facts['failed'])} failed, {facts['left_out']} of no known format"
    return "\n".join([columns(rows), *beside, *failed, *notes, end])


def _effect_text(facts: Mapping[str, Any]) -> str:
    if "effect" not in facts:
        rows = [(name, f"{each['seconds']:.2f}", each["about"]) for name, each in facts.items()]
        return columns([("name", "s", ""), *rows])
    lines = [f"{facts['effect']}: {facts['about']}", f"{facts['file']}: {text_of(facts['seconds'])} s"]
    return "\n".join([*lines, *loss_lines(facts.get("written", {}))])


VERBS = {
    "convert": Verb(
        "tactogram.workflows.data.convert:convert",
        _text,
        status=_status,
        listing=("list the formats", _formats),
    ),
    "effect": Verb("tactogram.workflows.rendering.effect:write_effect", _effect_text),
}

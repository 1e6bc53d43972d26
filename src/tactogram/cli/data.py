"""Verbs on data sets: import, inspect, check, extend, rate."""

from __future__ import annotations

from typing import Any

from tactogram.cli.hints import with_options
from tactogram.cli.printing import columns, lines_of, ratings_text, shortened
from tactogram.cli.verbs import Verb, flags_of

WORKFLOWS = "tactogram.workflows.data"


def _list_text(facts: dict[str, Any]) -> str:
    from tactogram.datasets.importer import IMPORTERS

    rows = [(name, one["title"], one["licence"]) for name, one in facts["import"].items()]
    lines = ["import:", columns(rows), *filter(None, [IMPORTERS.further_extra()])]
    if facts["simulate"]:
        lines += ["simulate:", columns(list(facts["simulate"].items()))]
    return "\n".join(lines)


_IN_MAPPING = "in the mapping that `--preview --save-mapping mapping.toml` writes"
ADVICE = {
    "`axes=NAME,NAME`": _IN_MAPPING,
    "`mapping=FILE.toml`": _IN_MAPPING,
    "time=": _IN_MAPPING,
    "sheet=": "by saving that one as a file of its own",
    "`rate`": "--set rate=…, or state it in recordings.csv for the files that lack it",
    "`unit`": "--set unit=…, or state it in recordings.csv for the files that lack it",
}
"""Advice of an import, which reads many files, instead of the arguments by which one is read."""


def _import_text(report: dict[str, Any]) -> str:
    from tactogram.cli.import_preview import preview_text, several_rates
    from tactogram.datasets.reading import in_one_line

    flags = flags_of(VERBS["data import"])
    said = [
        f"{head}: {in_one_line({**kind, 'text': with_options(kind['text'], flags)})}"
        for head, kinds in (("skipped", report["problems"]), ("note", report["notes"]))
        for kind in kinds
    ]
    said += [f"to answer: {with_options(report['question'], flags)}"] if report.get("question") else []
    if "layouts" in report:
        return preview_text(report, said)
    listed = ("skipped", "problems", "notes", "duplicates", "several_rates_hz")
    lines = [lines_of({name: value for name, value in report.items() if name not in listed})]
    lines += [
        f"duplicate: {each['dropped']} has the same samples as {each['kept']}"
        for each in report["duplicates"]
    ]
    return "\n".join([*lines, *said, *several_rates(report["several_rates_hz"])])


def _info_text(facts: dict[str, Any]) -> str:
    text = lines_of({name: shortened(value) for name, value in facts.items() if name != "ratings"})
    return text + ("" if facts["ratings"] is None else f"\n{ratings_text(facts['ratings'])}")


def _like_text(facts: dict[str, Any]) -> str:
    rows = [("material", "distance", "recording")]
    rows += [(f["material"] or "", f"{f['distance']:.2f} dB", f["id"]) for f in facts["nearest"]]
    return f"{facts['measure']}\n{columns(rows)}"


def _rate_text(facts: dict[str, Any]) -> str:
    known = {name: shortened(value) for name, value in facts.items() if name != "notes"}
    flags = flags_of(VERBS["data rate"])
    return "\n".join([lines_of(known), *(with_options(note, flags) for note in facts["notes"])])


VERBS = {
    "data list": Verb(f"{WORKFLOWS}.stores:list_sets", _list_text),
    "data import": Verb(
        f"{WORKFLOWS}.stores:import_store",
        _import_text,
        status=lambda report: 1 if report.get("question") or report.get("needs_skip_bad") else 0,
        advice=ADVICE,
    ),
    "data export": Verb(f"{WORKFLOWS}.stores:export_store", lines_of),
    "data info": Verb(f"{WORKFLOWS}.stores:store_info", _info_text),
    "data check": Verb(
        f"{WORKFLOWS}.stores:check_store", lines_of, status=lambda facts: 0 if facts["ok"] else 1
    ),
    "data copy": Verb(f"{WORKFLOWS}.stores:copy", lines_of),
    "data add": Verb(f"{WORKFLOWS}.stores:add_signal", lines_of),
    "data like": Verb("tactogram.workflows.recognition.files:find_similar_to_file", _like_text),
    "data rate": Verb(f"{WORKFLOWS}.rating_tables:rate_store", _rate_text),
    "data ratings": Verb(f"{WORKFLOWS}.rating_tables:export_ratings", lines_of),
}

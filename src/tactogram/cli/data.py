"""Verbs on data sets: import, simulate, inspect, check, extend, rate."""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated

from tactogram.cli.printing import Printer, columns, lines_of, ratings_text, shortened
from tactogram.cli.verbs import UsageError, Verb
from tactogram.workflows.data.requests import (
    AdditionRequest,
    DataExportRequest,
    ImportRequest,
    RatingRequest,
    SimulationRequest,
)
from tactogram.workflows.request import Argument, Option, Request
from tactogram.workflows.signal_options import SignalOptions


@dataclass(frozen=True)
class _ListRequest(Request):
    pass


@dataclass(frozen=True)
class _StoreRequest(Request):
    path: Annotated[str, Argument(metavar="DIR")]


@dataclass(frozen=True)
class _CopyRequest(Request):
    source: Annotated[str, Argument(metavar="STORE")]
    target: Annotated[str, Argument("a folder, or a URL such as s3://bucket/path", "TARGET")]


@dataclass(frozen=True)
class _LikeRequest(SignalOptions):
    path: Annotated[str, Argument(metavar="DIR")]
    file: Annotated[str, Argument(metavar="FILE")]
    _: KW_ONLY
    stream: Annotated[str | None, Option("stream to search (default: as in training)")] = None
    count: Annotated[int, Option("number of results")] = 5


@dataclass(frozen=True)
class _RatingsRequest(Request):
    path: Annotated[str, Argument(metavar="DIR")]
    out: Annotated[str, Option(".csv, .tsv or .parquet", "FILE")]
    wide: Annotated[
        bool,
        Option("one row per rater and item and one column per word, instead of one row per score"),
    ] = False


def _list(request: _ListRequest, show: Printer) -> None:
    from tactogram.workflows.data.stores import list_sets

    facts = list_sets()
    rows = [(name, s["title"], s["licence"]) for name, s in facts["import"].items()]
    text = "import:\n" + columns(rows)
    text += "\nsimulate:\n" + columns(list(facts["simulate"].items()))
    show(facts, text)


def _import(request: ImportRequest, show: Printer) -> int:
    from tactogram.cli.import_preview import preview_text, several_rates
    from tactogram.cli.import_remedies import in_words_of_the_command, said_of_files
    from tactogram.errors import DataError
    from tactogram.workflows.data.stores import import_store

    if request.out is None and not request.preview:
        raise UsageError("the following arguments are required: --out (or --preview)")
    verb = VERBS["data import"]
    try:
        with show.progress() as progress:
            report = import_store(**vars(request) | {"progress": progress})
    except DataError as error:
        raise DataError(in_words_of_the_command(str(error), verb)) from error
    said = said_of_files(report, verb)
    if request.preview:
        show(report, preview_text(report, said))
        return 1 if report["question"] or (report["needs_skip_bad"] and not request.skip_bad) else 0
    listed = ("skipped", "problems", "notes", "duplicates", "several_rates_hz")
    lines = [lines_of({name: value for name, value in report.items() if name not in listed})]
    lines += [
        f"duplicate: {each['dropped']} has the same samples as {each['kept']}"
        for each in report["duplicates"]
    ]
    lines += said
    lines += several_rates(report["several_rates_hz"])
    show(report, "\n".join(lines))
    return 0


def _simulate(request: SimulationRequest, show: Printer) -> None:
    from tactogram.workflows.data.simulate import simulate_to_store

    with show.progress() as progress:
        report = simulate_to_store(**vars(request) | {"progress": progress})
    show(report, lines_of(report))


def _export(request: DataExportRequest, show: Printer) -> None:
    from tactogram.workflows.data.export import export_store

    show(facts := export_store(**vars(request)), lines_of(facts))


def _info(request: _StoreRequest, show: Printer) -> None:
    from tactogram.workflows.data.stores import store_info

    facts = store_info(request.path)
    ratings = facts["ratings"]
    text = lines_of({name: shortened(value) for name, value in facts.items() if name != "ratings"})
    show(facts, text if ratings is None else f"{text}\n{ratings_text(ratings)}")


def _check(request: _StoreRequest, show: Printer) -> int:
    from tactogram.workflows.data.stores import check_store

    show(facts := check_store(request.path), lines_of(facts))
    return 0 if facts["ok"] else 1


def _copy(request: _CopyRequest, show: Printer) -> None:
    from tactogram.workflows.data.stores import copy

    with show.progress() as progress:
        facts = copy(request.source, request.target, progress=progress)
    show(facts, lines_of(facts))


def _add(request: AdditionRequest, show: Printer) -> None:
    from tactogram.workflows.data.stores import add_signal

    show(facts := add_signal(**vars(request)), lines_of(facts))


def _like(request: _LikeRequest, show: Printer) -> None:
    from tactogram.signal.io import read_signal
    from tactogram.workflows.recognition.spectral_search import find_similar

    signal = read_signal(request.file, **request.reading)
    facts = find_similar(request.path, signal, stream=request.stream, count=request.count)
    rows = [("material", "distance", "recording")]
    rows += [(f["material"] or "", f"{f['distance']:.2f} dB", f["id"]) for f in facts["nearest"]]
    show(facts, facts["measure"] + "\n" + columns(rows))


def _rate(request: RatingRequest, show: Printer) -> None:
    from tactogram.workflows.data.rating_tables import rate_store

    facts = rate_store(**vars(request))
    known = {name: shortened(value) for name, value in facts.items() if name != "notes"}
    show(facts, "\n".join([lines_of(known), *facts["notes"]]))


def _ratings(request: _RatingsRequest, show: Printer) -> None:
    from tactogram.workflows.data.rating_tables import export_ratings

    facts = export_ratings(request.path, request.out, form="wide" if request.wide else "long")
    show(facts, lines_of(facts))


VERBS = {
    "data list": Verb(_ListRequest, _list),
    "data import": Verb(ImportRequest, _import),
    "data simulate": Verb(SimulationRequest, _simulate),
    "data export": Verb(DataExportRequest, _export),
    "data info": Verb(_StoreRequest, _info),
    "data check": Verb(_StoreRequest, _check),
    "data copy": Verb(_CopyRequest, _copy),
    "data add": Verb(AdditionRequest, _add),
    "data like": Verb(_LikeRequest, _like),
    "data rate": Verb(RatingRequest, _rate),
    "data ratings": Verb(_RatingsRequest, _ratings),
}

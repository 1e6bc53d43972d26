"""Verbs that classify, score and search recordings."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Annotated

from tactogram.cli.printing import Printer, columns, text_of
from tactogram.cli.verbs import Verb
from tactogram.workflows.request import Argument, Option
from tactogram.workflows.signal_options import SignalOptions


@dataclass(frozen=True)
class _FilesRequest(SignalOptions):
    run: Annotated[str, Argument(metavar="RUN")]
    files: Annotated[Sequence[str], Argument("signals; `score` also takes images", "FILE")]


@dataclass(frozen=True)
class _SearchRequest(SignalOptions):
    run: Annotated[str, Argument(metavar="RUN")]
    file: Annotated[str, Argument(metavar="FILE")]
    _: KW_ONLY
    data: Annotated[
        str | None,
        Option("data set to search, added recordings included (default: the training data)", "DIR"),
    ] = None
    count: Annotated[int, Option("number of results")] = 5


def _classify(request: _FilesRequest, show: Printer) -> None:
    from tactogram.signal.io import read_signal
    from tactogram.workflows.recognition.classify import classify
    from tactogram.workflows.training.loaded_run import load_run

    loaded = load_run(request.run)
    results = {file: classify(loaded, read_signal(file, **request.reading)) for file in request.files}
    rows = [("file", "material", "probability", "")]
    rows += [
        (file, r["material"], f"{r['probability']:.3f}", "none of these?" if r["none_of_these"] else "")
        for file, r in results.items()
    ]
    show({"files": results}, columns(rows))


def _score(request: _FilesRequest, show: Printer) -> None:
    from tactogram.workflows.recognition.score import score_file
    from tactogram.workflows.training.loaded_run import load_run

    loaded = load_run(request.run)
    results = {file: score_file(loaded, file, **request.reading) for file in request.files}
    first = next(iter(results.values()))
    rows = [("file", *first["scores"], "novel")]
    rows += [
        (file, *(f"{value:.2f}" for value in r["scores"].values()), text_of(r["novelty"]))
        for file, r in results.items()
    ]
    low, high = first["scale"]
    head = f"predicted by a {first['predicted_by']}, scale {low:g} to {high:g}"
    show({"files": results}, f"{head}\n{columns(rows)}")


def _search(request: _SearchRequest, show: Printer) -> None:
    from tactogram.signal.io import read_signal
    from tactogram.workflows.recognition.search import search

    signal = read_signal(request.file, **request.reading)
    result = search(request.run, signal, data=request.data, count=request.count)
    verdict = "none of these" if result["none_of_these"] else "known"
    rows = [("material", "distance", "recording")]
    rows += [(f["material"], f"{f['distance']:.2f}", f["id"]) for f in result["nearest"]]
    head = f"{verdict}: nearest at {result['distance']:.2f}, threshold {result['threshold']:.2f}"
    show(result, head + "\n" + columns(rows))


VERBS = {
    "classify": Verb(_FilesRequest, _classify, folders=("models",)),
    "score": Verb(_FilesRequest, _score, folders=("models",)),
    "search": Verb(_SearchRequest, _search, folders=("models",)),
}

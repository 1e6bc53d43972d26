"""Verbs that classify, score and search recordings."""

from __future__ import annotations

from tactogram.cli.options import Verbs, models_option, signal_arguments, signal_options
from tactogram.cli.printing import Arguments, columns, print_result, text_of


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("classify", classify)
    add("run_folder", metavar="RUN")
    add("files", metavar="FILE", nargs="+")
    models_option(add)
    signal_options(add)

    add = verbs.add("score", score)
    add("run_folder", metavar="RUN")
    add("files", metavar="FILE", nargs="+", help="signals, or images for a run trained on images")
    models_option(add)
    signal_options(add)

    add = verbs.add("search", search)
    add("run_folder", metavar="RUN")
    add("file", metavar="FILE")
    add(
        "--data",
        metavar="DIR",
        help="data set to search, added recordings included (default: the training data)",
    )
    add("--count", type=int, default=5, help="number of results (default %(default)s)")
    models_option(add)
    signal_options(add)


def classify(a: Arguments) -> None:
    """Classify the material of recordings."""
    from tactogram.signal.io import read_signal
    from tactogram.workflows.recognition.classify import classify
    from tactogram.workflows.training.loaded_run import load_run

    loaded = load_run(a.run_folder)
    results = {file: classify(loaded, read_signal(file, **signal_arguments(a))) for file in a.files}
    rows = [
        (file, r["material"], f"{r['probability']:.3f}", "none of these?" if r["none_of_these"] else "")
        for file, r in results.items()
    ]
    print_result(a, {"files": results}, columns(rows))


def score(a: Arguments) -> None:
    """Predict word scores of recordings, generated signals or images with a rater model."""
    from tactogram.workflows.recognition.score import score_file
    from tactogram.workflows.training.loaded_run import load_run

    loaded = load_run(a.run_folder, model_folders=a.models)
    results = {file: score_file(loaded, file, **signal_arguments(a)) for file in a.files}
    first = next(iter(results.values()))
    rows = [("file", *first["scores"], "novel")]
    rows += [
        (file, *(f"{value:.2f}" for value in r["scores"].values()), text_of(r["novelty"]))
        for file, r in results.items()
    ]
    low, high = first["scale"]
    head = f"predicted by a {first['predicted_by']}, scale {low:g} to {high:g}"
    print_result(a, {"files": results}, f"{head}\n{columns(rows)}")


def search(a: Arguments) -> None:
    """Find the recordings nearest to a file, or report none of these."""
    from tactogram.signal.io import read_signal
    from tactogram.workflows.recognition.search import search

    signal = read_signal(a.file, **signal_arguments(a))
    result = search(a.run_folder, signal, data=a.data, count=a.count)
    verdict = "none of these" if result["none_of_these"] else "known"
    rows = [(f["material"], f"{f['distance']:.4f}", f["id"]) for f in result["nearest"]]
    head = f"{verdict}: nearest at {result['distance']:.4f}, threshold {result['threshold']:.4f}"
    print_result(a, result, head + "\n" + columns(rows))

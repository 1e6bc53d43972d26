"""Verbs that train and evaluate models, and pack runs."""

from typing import Any

from tactogram.cli.printing import accuracies, columns, lines_of, text_of
from tactogram.cli.verbs import Verb

TRAINING = "tactogram.workflows.training"
EVALUATION = "tactogram.workflows.evaluation"


def _trained(result: dict[str, Any]) -> str:
    lines = [f"run: {result['run']}"]
    if values := result["validation"]:
        lines.append("validation: " + ", ".join(f"{name} {value:.3f}" for name, value in values.items()))
    return "\n".join([*lines, *(f"note: {note}" for note in result["notes"])])


def _crossvalidated(result: dict[str, Any]) -> str:
    if "per_word" in result:
        of = " of simulated raters" if result["data"]["simulated"] else ""
        low, high = result["scale"]
        head = f"mean absolute error{of}, points of a scale of {low:g} to {high:g}\n{_words_text(result)}"
    else:
        head = accuracies(result)
    return f"{head}\nsplit: {result['split']}\nreport: {result['report']}"


def _evaluated(result: dict[str, Any]) -> str:
    if "window_accuracy" in result:
        lines = [accuracies(result)]
    elif "per_word" in result:
        lines = [_words_text(result)]
    elif "spread" in result:
        lines = _images_lines(result)
    elif "told_by" in result:
        lines = [f"mean absolute error to the surfaces' scores, rated by {result['told_by']}"]
        lines += [
            f"{name}: {text_of(row['mae'])} (of {row['targets']} surfaces)"
            for name, row in result["conditions"].items()
        ]
        lines += [f"{name}: {text_of(value)}" for name, value in result["beside"].items()]
        lines += [f"{item}: {why}" for item, why in result["failed"].items()]
    else:
        lines = [result["summary"]] if "summary" in result else []
        lines += [
            f"{measure}: " + ", ".join(f"{column} {text_of(value)}" for column, value in row.items())
            for measure, row in result.get("measures", {}).items()
        ]
        published = result.get("as_published") or {}
        alone = result.get("pictures", {}).get("values", {}) | published.get("mean", {})
        lines += [f"{name}: {text_of(value)}" for name, value in alone.items()]
        lines += [result["as_published_missing"]] if "as_published_missing" in result else []
    return "\n".join([*lines, f"report: {result['report']}"])


def _exported(facts: dict[str, Any]) -> str:
    """Return the facts; of networks their files, with how far onnxruntime is from the package."""
    if "networks" not in facts:
        return lines_of(facts)
    rows = [("network", "file", "KiB", "output", "largest difference")]
    for name, each in facts["networks"].items():
        for output, difference in each["difference"].items():
            rows.append((name, each["file"], f"{each['bytes'] / 1024:.0f}", output, f"{difference:.1g}"))
    return f"{columns(rows)}\nfolder: {facts['folder']}"


def _compared(result: dict[str, Any]) -> str:
    rows = [("", *result["runs"])]
    for part in ("facts", "settings", "results"):
        rows += [(name, *map(text_of, values)) for name, values in result[part].items()]
    return "\n".join([columns(rows), *(f"note: {note}" for note in result["notes"])])


def _images_lines(result: Any) -> list[str]:
    """Return the spread and the label fidelity of a generator's images, as lines."""
    lines = []
    if spread := result["spread"]:
        lines = [
            f"two images differ by {spread['noise_spread']:.3g} (same label, other noise) and "
            f"{spread['label_spread']:.3g} (same noise, other label); two real ones by {spread['real_spread']:.3g}",
            f"collapsed: {result['collapse'] or 'no'}",
        ]
    if "following" in result:
        fidelity = result["following"]
        lines.append(
            f"label fidelity, scored by {result['told_by']}: correlation {fidelity['correlation']:.2f}, slope "
            f"{fidelity['slope']:.2f}, error {fidelity['error']:.3f}, "
            f"to other labels {fidelity['error_of_others']:.3f} (of 1)"
        )
    else:
        lines.append("for label fidelity give --rater RUN, a rater model trained on rated images")
    return [*lines, f"evaluated on: {result['data']['split']}"]


def _words_text(result: dict[str, Any]) -> str:
    from tactogram.workflows.evaluation.rating_crossval import COLUMNS

    rows = [("word", *COLUMNS.values())]
    rows += [
        (word, *(text_of(row[name]) for name in COLUMNS))
        for word, row in (*result["per_word"].items(), ("mean", result["mean"]))
    ]
    return columns(rows)


VERBS = {
    "train": Verb("tactogram.cli.combined:train_or_resume", _trained, bare=("resume",)),
    "crossval": Verb(f"{EVALUATION}.crossval:crossval", _crossvalidated, named=("data",)),
    "evaluate": Verb(f"{EVALUATION}.evaluate:evaluate", _evaluated, folders=("models",)),
    "compare": Verb(f"{TRAINING}.run_comparison:compare_runs", _compared),
    "run export": Verb(f"{TRAINING}.export:export", _exported),
    "run import": Verb(f"{TRAINING}.export:import_from", lines_of),
}

"""Verbs that classify, score and search recordings."""

from typing import Any

from tactogram.cli.printing import columns, text_of
from tactogram.cli.verbs import Verb

FILES = "tactogram.workflows.recognition.files"


def _classes(result: dict[str, Any]) -> str:
    known = any(r["candidates"] for r in result["files"].values())
    rows = [("file", "material", "probability", "or (95 %)" if known else "", "")]
    for file, r in result["files"].items():
        others = ", ".join(name for name in r["candidates"] or () if name != r["material"])
        doubt = "none of these?" if r["none_of_these"] else ""
        rows.append((file, r["material"], f"{r['probability']:.3f}", others, doubt))
    return columns(rows)


def _scores(result: dict[str, Any]) -> str:
    files = result["files"]
    first = next(iter(files.values()))
    rows = [("file", *first["scores"], "novel")]
    rows += [
        (file, *(f"{value:.2f}" for value in r["scores"].values()), text_of(r["novelty"]))
        for file, r in files.items()
    ]
    low, high = first["scale"]
    return f"predicted by a {first['predicted_by']}, scale {low:g} to {high:g}\n{columns(rows)}"


def _nearest(result: dict[str, Any]) -> str:
    verdict = "none of these" if result["none_of_these"] else "known"
    rows = [("material", "distance", "recording")]
    rows += [(f["material"], f"{f['distance']:.2f}", f["id"]) for f in result["nearest"]]
    head = f"{verdict}: nearest at {result['distance']:.2f}, threshold {result['threshold']:.2f}"
    return head + "\n" + columns(rows)


VERBS = {
    "classify": Verb(f"{FILES}:classify_files", _classes, folders=("models",)),
    "score": Verb(f"{FILES}:score_files", _scores, folders=("models",)),
    "search": Verb(f"{FILES}:search_file", _nearest, folders=("models",)),
}

"""Printed results: one JSON object, or lines and columns for people."""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tactogram.workflows.progress import ProgressCallback


class Printer:
    """Prints the result of a verb: as JSON where ``--json`` is given, else as text; progress unless ``--quiet``."""

    def __init__(self, *, json: bool, quiet: bool = False) -> None:
        self.json, self.quiet = json, quiet

    def __call__(self, result: Any, text: str) -> None:
        """Print one of the two."""
        sys.stdout.write((json.dumps(result, ensure_ascii=False) if self.json else text) + "\n")

    def notes(self, lines: Iterable[str]) -> None:
        """Print notes on a result on stderr, with ``--json`` and ``--quiet``, too."""
        sys.stderr.writelines(f"note: {line}\n" for line in lines)

    @contextmanager
    def progress(self) -> Iterator[ProgressCallback]:
        """Show progress on stderr meanwhile, unless quiet."""
        from tactogram.workflows.progress import shown, silent

        if self.quiet:
            yield silent
            return
        with shown() as progress:
            yield progress


def accuracies(result: Mapping[str, Any]) -> str:
    """Return the accuracies of a classifier as a line."""
    low, high = result["recording_accuracy_95"]
    return (
        f"recording accuracy {100 * result['recording_accuracy']:.1f} % (95 %: {100 * low:.1f}–{100 * high:.1f}) "
        f"of {result['recordings']}, window accuracy {100 * result['window_accuracy']:.1f} % of {result['windows']}"
    )


def lines_of(facts: Mapping[str, Any]) -> str:
    """Return a line per fact that is not empty."""
    return "\n".join(
        f"{name}: {text_of(value)}" for name, value in facts.items() if value not in (None, [], {})
    )


def text_of(value: Any) -> str:
    """Return a value as text for people."""
    if value is None:
        return "-"
    if isinstance(value, float):
        # Frequencies and rates are copied: not 2.82e+04.
        return f"{value:.7g}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {text_of(inner)}" for name, inner in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(text_of(inner) for inner in value)
    return str(value)


def columns(rows: Sequence[Sequence[str]], *, width: int | None = None) -> str:
    """Return rows of cells as columns of one width each; beyond ``width`` the widest columns are cut."""
    rows = [[str(cell) for cell in row] for row in rows]
    if not rows:
        return "none"
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    gaps = 2 * (len(widths) - 1)
    while width is not None and sum(widths) + gaps > width and max(widths) > 1:
        widths[widths.index(max(widths))] -= 1
    return "\n".join(
        "  ".join(
            (c if len(c) <= w else f"{c[: w - 1]}…").ljust(w) for c, w in zip(row, widths, strict=True)
        ).rstrip()
        for row in rows
    )


def terminal_width() -> int | None:
    """Return the columns of the terminal that stdout is; None of a file or pipe."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else None


def shortened(value: Any) -> Any:
    """Return the first entries of a long list or mapping, and their number."""
    if isinstance(value, Mapping) and len(value) > 40:
        return dict(list(value.items())[:10]) | {"…": f"({len(value)} in all)"}
    if isinstance(value, list) and len(value) > 12:
        return [*value[:10], f"… ({len(value)} in all)"]
    return value


def ratings_text(facts: Mapping[str, Any]) -> str:
    """Return the content, gaps and reliability of ratings, with a row per word."""
    scale, missing, agreed = facts["scale"], facts["missing"], facts["reliability"]
    lines = [
        f"ratings: {facts['scores']} scores of {facts['items']} items by {facts['raters']} raters, "
        f"{scale['name']} ({scale['low']:g} to {scale['high']:g})"
    ]
    most = sorted(missing["blank_by_rater"].items(), key=lambda entry: -entry[1])
    by_rater = (
        f" by {len(most)} raters ({text_of(dict(most[:5]))}{', …' if len(most) > 5 else ''})" if most else ""
    )
    lines.append(
        f"missing: {missing['blank']} left blank{by_rater}; {missing['not_met']} of "
        f"{facts['items'] * facts['raters']} pairs of rater and item without any score"
    )
    names = ("mean", "sd", "alpha", "icc_single", "icc_average")
    rows = [("word", "mean", "sd", f"alpha, {agreed['level']}", "ICC(2,1)", "ICC(2,k)", "of items x raters")]
    for word, known in agreed["words"].items():
        size = "-" if known["icc_items"] is None else f"{known['icc_items']} x {known['icc_raters']}"
        cells = ["-" if known[name] is None else f"{known[name]:.2f}" for name in names]
        rows.append((word, *cells, size))
    lacking = [f"no alpha: {agreed['alpha_missing']}"] if "alpha_missing" in agreed else []
    return "\n".join([*lines, columns(rows), *lacking])

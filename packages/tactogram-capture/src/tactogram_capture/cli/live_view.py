"""Live recognition on a terminal, the verb `live`: a bar per material, "none of these", level and latency."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from tactogram.cli.printing import Printer, text_of
from tactogram.parameters import Positive, checked
from tactogram_capture.live.classifier import LiveClassifier
from tactogram_capture.live.recognition import Latencies, WindowClassification
from tactogram_capture.source import Block, Source
from tactogram_capture.workflows.live import live

MOST_SHOWN = 8
"""Materials with a bar, most probable first."""
WIDTH = 40


def panel(guess: WindowClassification, latencies: Latencies, *, title: str, unit: str = "") -> RenderableType:
    """Return the panel of one window."""
    parts: list[RenderableType] = [_head(guess)]
    if guess.classification is not None:
        table = Table.grid(padding=(0, 1))
        ranked = sorted(guess.classification.probabilities.items(), key=lambda entry: -entry[1])
        style = "dim" if guess.classification.none_of_these else "cyan"
        for name, probability in ranked[:MOST_SHOWN]:
            bar = ProgressBar(
                total=1.0, completed=probability, width=WIDTH, complete_style=style, finished_style=style
            )
            table.add_row(name, bar, f"{probability:5.3f}")
        parts.append(table)
    parts.append(Text(_foot(guess, latencies, unit), style="dim"))
    return Panel(Group(*parts), title=title, title_align="left")


def line(guess: WindowClassification) -> str:
    """Return one window as a line."""
    head = f"{guess.time_s:8.2f} s  "
    if guess.classification is None:
        return f"{head}not classified: {100 * guess.lost:.0f} % of the window was lost"
    name = guess.material or ""
    odd = "  none of these?" if guess.classification.none_of_these else ""
    late = "" if guess.latency_s is None else f"  {1e3 * guess.latency_s:.0f} ms"
    return f"{head}{name:24} {guess.classification.probabilities[name]:.3f}{late}{odd}"


def _head(guess: WindowClassification) -> Text:
    if guess.classification is None:
        return Text(f"not classified: {100 * guess.lost:.0f} % of the window was lost", style="bold red")
    if guess.classification.none_of_these:
        return Text("none of these", style="bold yellow")
    return Text(guess.material or "", style="bold green")


def _foot(guess: WindowClassification, latencies: Latencies, unit: str) -> str:
    facts = latencies.facts()
    took = (
        ""
        if facts["p50_ms"] is None
        else f"latency p50 {facts['p50_ms']:.0f} ms  p99 {facts['p99_ms']:.0f} ms  "
    )
    return f"{took}level {guess.level:.3g} {unit}  lost {100 * guess.lost:.1f} % of the window"


@contextmanager
def _window_printer(
    show: Printer, *, title: str
) -> Iterator[tuple[Callable[[LiveClassifier], None], Callable[[WindowClassification], None]]]:
    """Yield callbacks for the first and each window: JSON lines on stdout, a panel or lines on stderr."""
    latencies = Latencies()

    def begin(classifier: LiveClassifier) -> None:
        facts = f"window {classifier.window_s:.2f} s of {len(classifier.loaded.kind.materials)} materials"
        sys.stderr.write(f"listening: {facts}; Ctrl-C ends it\n")

    def as_json(guess: WindowClassification) -> None:
        sys.stdout.write(json.dumps(guess.facts(), ensure_ascii=False) + "\n")
        sys.stdout.flush()

    def as_line(guess: WindowClassification) -> None:
        sys.stderr.write(line(guess) + "\n")

    if show.json or not sys.stderr.isatty():
        yield begin, as_json if show.json else as_line
        return
    with Live(console=Console(stderr=True), auto_refresh=False) as display:

        def as_panel(guess: WindowClassification) -> None:
            latencies.add(guess)
            display.update(panel(guess, latencies, title=title), refresh=True)

        yield begin, as_panel


@checked
def live_on_terminal(
    run: Path | str,
    *,
    source: str,
    window: Positive | None = None,
    hop: Positive | None = None,
    rate: Positive | None = None,
    seconds: Positive | None = None,
    show: Printer,
) -> None:
    """Classify what a sensor touches, live: each window is shown, and a summary at the end.

    Parameters
    ----------
    run, source, window, hop, rate, seconds
        As of `live`.
    """
    said: list[str] = []

    def heard(opened: Source, _: Block | None) -> None:
        for note in getattr(opened, "notes", ())[len(said) :]:
            said.append(note)
            sys.stderr.write(f"note: {note}\n")

    options = {"window": window, "hop": hop, "rate": rate, "seconds": seconds}
    with _window_printer(show, title=source) as (begin, on_window):
        result = live(run, source=source, **options, on_window=on_window, begin=begin, heard=heard)
    show({"summary": result} if show.json else result, _live_text(result))


def _live_text(result: dict[str, Any]) -> str:
    latency, none = result["latency"], result["none_of_these"]
    simulated = " (simulated)" if result["simulated"] else ""
    lines = [
        f"{result['judged']} of {result['windows']} windows classified{simulated}, {result['skipped']} skipped"
        + ("" if none is None else f", {none} like none of these")
    ]
    lines += [f"  {name:24} {count}" for name, count in result["materials"].items()]
    if latency["p50_ms"] is not None:
        lines.append(
            f"latency, last sample to probabilities: p50 {text_of(latency['p50_ms'])} ms, "
            f"p99 {text_of(latency['p99_ms'])} ms, max {text_of(latency['max_ms'])} ms"
        )
    return "\n".join(lines)

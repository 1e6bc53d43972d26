"""Live recognition on a terminal: a bar per material, "none of these", level and latency."""

from __future__ import annotations

from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from tactogram_capture.live.recognition import Latencies, WindowClassification

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

"""Session console: prompts, questions and their answers, from keys on a terminal, or from lines."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from math import log10
from typing import Any, Protocol, Self, TextIO

from rich.console import Console as RichConsole, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from tactogram_capture.session.feed import MeterReading


@dataclass(frozen=True)
class CaptureStatus:
    """Status of a recording session."""

    place: str
    """The take, its number and the total."""
    phase: str
    """``"countdown"``, ``"waiting"``, ``"recording"`` or ``"question"``."""
    text: str
    """The question, or the remaining time."""
    share: float = 0.0
    """Finished share of the phase, 0 to 1."""
    levels: MeterReading | None = None


class Console(Protocol):
    """Console that shows a session and answers its questions."""

    def show(self, status: CaptureStatus) -> None:
        """Show the status; called many times a second."""
        ...

    def say(self, text: str) -> None:
        """Write a permanent line."""
        ...

    def ask(self, question: str, keys: Mapping[str, str], *, default: str, idle: Callable[[], None]) -> str:
        """Return one of ``keys``, whose values are their meanings; ``idle`` is called while waiting."""
        ...


class LineConsole:
    """Lines on stderr; answers from the lines of a file or pipe, or always the default (``answers`` None).

    A line answers by its first letter; an empty one is the default, the end of the file is ``q``.
    """

    def __init__(self, answers: TextIO | None, out: TextIO | None = None) -> None:
        self._answers = answers
        self._read = bytearray()
        self._out = sys.stderr if out is None else out
        self._shown: tuple[str, str] = ("", "")

    def show(self, status: CaptureStatus) -> None:
        """Write a line when a phase begins."""
        if (status.place, status.phase) != self._shown and status.phase == "recording":
            self.say(f"{status.place}: recording")
        self._shown = (status.place, status.phase)

    def say(self, text: str) -> None:
        """Write a line."""
        self._out.write(text + "\n")
        self._out.flush()

    def ask(self, question: str, keys: Mapping[str, str], *, default: str, idle: Callable[[], None]) -> str:
        """Return the default, or the next answer that is one of ``keys``."""
        if self._answers is None:
            idle()
            return default
        choices = ", ".join(f"{key} {meaning}" for key, meaning in keys.items())
        while True:
            self.say(f"{question} ({choices}; default {default})")
            line = self._line(idle)
            if line is None:
                return "q"
            answer = line.strip().lower()[:1] or default
            if answer in keys:
                return answer
            self.say(f"answer must be one of {', '.join(keys)}, got {line.strip()!r}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Leave everything open: it was before."""

    def _line(self, idle: Callable[[], None]) -> str | None:
        """Return the next line, None at the end; ``idle`` runs while there is none yet."""
        idle()
        number = _handle(self._answers)
        if self._answers is None or number is None:
            line = self._answers.readline() if self._answers is not None else ""
            return line or None
        # readline would read ahead, which select does not notice.
        while b"\n" not in self._read:
            if not select.select([number], [], [], 0)[0]:
                idle()
                continue
            if not (more := os.read(number, 4096)):
                break
            self._read += more
        line_read, newline, rest = bytes(self._read).partition(b"\n")
        self._read = bytearray(rest)
        return line_read.decode(errors="replace") + newline.decode() or None


def _handle(answers: TextIO | None) -> int | None:
    """Return a file's descriptor; None for text in memory, and where select waits for sockets only."""
    if sys.platform == "win32":
        return None
    try:
        return None if answers is None else answers.fileno()
    except (OSError, ValueError):
        return None


FLOOR_DB, TOP_DB = -40.0, 0.0
"""Range of the meter, dB relative to full scale; without a full scale, relative to `NO_FULL_SCALE`."""
NO_FULL_SCALE = 100.0
WIDTH = 44


def meter(levels: MeterReading) -> RenderableType:
    """Return the level meter: a bar of the rms, the peak, clipping, rate and losses."""
    top = levels.full_scale or NO_FULL_SCALE
    share = (20 * log10(max(levels.rms, 1e-9) / top) - FLOOR_DB) / (TOP_DB - FLOOR_DB)
    bar = ProgressBar(
        total=1.0, completed=min(1.0, max(0.0, share)), width=WIDTH,
        complete_style="red" if levels.clipped else "green", finished_style="red",
    )  # fmt: skip
    table = Table.grid(padding=(0, 1))
    table.add_row("level", bar, f"{levels.rms:8.3f} rms  peak {levels.peak:8.2f}")
    rate = "unknown yet" if levels.rate is None else f"{levels.rate:.2f} Hz"
    clip = Text(" CLIPPED ", style="bold white on red") if levels.clipped else Text("")
    table.add_row("rate", Text(f"{rate}   lost so far {levels.lost}"), clip)
    return table


def panel(status: CaptureStatus) -> RenderableType:
    """Return the panel of a session's current status."""
    parts: list[RenderableType] = []
    if status.phase == "question":
        parts.append(Text(status.text, style="bold yellow"))
    else:
        bar = ProgressBar(total=1.0, completed=min(1.0, max(0.0, status.share)), width=WIDTH)
        row = Table.grid(padding=(0, 1))
        row.add_row(Text(status.phase, style="bold"), bar, status.text)
        parts.append(row)
    if status.levels is not None:
        parts.append(meter(status.levels))
    return Panel(Group(*parts), title=status.place, title_align="left")


class TerminalConsole:
    """A panel redrawn ten times a second, and answers by single keys; a context manager."""

    def __init__(self) -> None:
        self._rich = RichConsole(stderr=True)
        self._live: Live | None = None
        self._status: CaptureStatus | None = None

    def __enter__(self) -> Self:
        self._live = Live(console=self._rich, refresh_per_second=10, transient=True)
        self._live.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        if self._live is not None:
            self._live.__exit__(*error)
            self._live = None

    def show(self, status: CaptureStatus) -> None:
        """Redraw the panel."""
        self._status = status
        if self._live is not None:
            self._live.update(panel(status))

    def say(self, text: str) -> None:
        """Write a line above the panel."""
        self._rich.print(text, markup=False, highlight=False)

    def ask(self, question: str, keys: Mapping[str, str], *, default: str, idle: Callable[[], None]) -> str:
        """Return the pressed key; Enter and space give the default, Ctrl-C and Ctrl-D give ``q``."""
        choices = "   ".join(f"[{key}] {meaning}" for key, meaning in keys.items())
        text = f"{question}\n{choices}   (Enter: {keys[default]})"
        with _single_keys() as pressed:
            while True:
                idle()
                levels = self._status.levels if self._status is not None else None
                place = self._status.place if self._status is not None else ""
                self.show(CaptureStatus(place, "question", text, levels=levels))
                key = pressed()
                if key in ("\r", "\n", " "):
                    return default
                if key in ("\x03", "\x04"):
                    return "q"
                if key and key.lower() in keys:
                    return key.lower()


@contextmanager
def _single_keys() -> Iterator[Callable[[], str]]:
    """Yield a function that returns the pressed key ("" if none), and restore the terminal afterwards."""
    import termios
    import tty

    number = sys.stdin.fileno()
    before: Any = termios.tcgetattr(number)
    tty.setcbreak(number)

    def pressed() -> str:
        if not select.select([number], [], [], 0)[0]:
            return ""
        # A closed terminal reads as empty input, and no answer will follow.
        return os.read(number, 8).decode(errors="replace")[:1] or "\x04"

    try:
        yield pressed
    finally:
        termios.tcsetattr(number, termios.TCSADRAIN, before)

"""Session console: prompts, questions and their answers, from a person or from a script."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol, Self, TextIO

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

"""A recording session's console on a page: what `tactogram.capture.session.terminal` is for a terminal."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from threading import Lock
from time import monotonic
from typing import Any

from tactogram.capture.session.console import CaptureStatus

LINES = 40
"""That are kept of what a session says."""


@dataclass(frozen=True)
class ConsoleQuestion:
    """Question of a session to the person who records.

    Parameters
    ----------
    number : int
        From 1; an answer says which question it is to.
    text : str
    keys : mapping
        What each key means.
    default : str
        One of ``keys``.
    """

    number: int
    text: str
    keys: Mapping[str, str]
    default: str

    def facts(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return {
            "number": self.number,
            "text": self.text,
            "keys": dict(self.keys),
            "default": self.default,
        }


class PageConsole:
    """Keeps what a session shows, and waits for answers of any number of pages; see `Console`."""

    def __init__(self) -> None:
        self.status: CaptureStatus | None = None
        self.question: ConsoleQuestion | None = None
        self.lines: deque[str] = deque(maxlen=LINES)
        self._asked = 0
        self._answer: str | None = None
        self._ended = False
        self._changed = Lock()

    def show(self, status: CaptureStatus) -> None:
        """Keep it for whoever looks."""
        self.status = status

    def say(self, text: str) -> None:
        """Keep a line."""
        self.lines.append(text)

    def ask(self, question: str, keys: Mapping[str, str], *, default: str, idle: Callable[[], None]) -> str:
        """Return what a page answers; ``q`` once the session is to end."""
        with self._changed:
            self._asked += 1
            self._answer = None
            self.question = ConsoleQuestion(self._asked, question, dict(keys), default)
        try:
            while True:
                answered = self._answered()
                if answered is not None:
                    return answered
                idle()
        finally:
            with self._changed:
                self.question = None

    def _answered(self) -> str | None:
        with self._changed:
            return self._answer or ("q" if self._ended else None)

    def answer(self, number: int, key: str) -> bool:
        """Answer question ``number``; False if it is not the one that is asked, so that nothing is answered twice."""
        with self._changed:
            asked = self.question
            if asked is None or asked.number != number or key not in asked.keys or self._answer is not None:
                return False
            self._answer = key
            return True

    def end(self) -> None:
        """Answer every question from now on with ``q``."""
        with self._changed:
            self._ended = True


class PageMetronome:
    """A beat that pages show and sound; see `tactogram.capture.session.metronome.Metronome`.

    Parameters
    ----------
    clock : callable
        As ``time.monotonic``.
    """

    def __init__(self, clock: Callable[[], float] = monotonic) -> None:
        self._clock = clock
        self._beat: tuple[int, float, float, float, bool] | None = None
        self._count = 0

    def start(self, interval_s: float, seconds: float, *, back_and_forth: bool) -> None:
        """Beat from now on."""
        self._count += 1
        self._beat = (self._count, self._clock(), interval_s, seconds, back_and_forth)

    def stop(self) -> None:
        """Stop."""
        self._beat = None

    def facts(self) -> dict[str, Any] | None:
        """Return ``number``, ``elapsed_s``, ``interval_s``, ``back_and_forth``; None while it is silent."""
        beat = self._beat
        if beat is None:
            return None
        number, began, interval_s, seconds, back_and_forth = beat
        elapsed = self._clock() - began
        if elapsed > seconds:
            return None
        return {
            "number": number,
            "elapsed_s": round(elapsed, 4),
            "interval_s": interval_s,
            "back_and_forth": back_and_forth,
        }

"""Console of a recording session on a page, as `tactogram_capture.session.console` is on a terminal."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from threading import Lock
from time import monotonic
from typing import Any

from tactogram_capture.session.console import CaptureStatus
from tactogram_capture.session.metronome import Metronome

MOST_LINES = 40


@dataclass(frozen=True)
class ConsoleQuestion:
    """Question of a session to the person who records; ``keys`` maps each key to its meaning."""

    number: int
    text: str
    keys: dict[str, str]
    default: str

    def facts(self) -> dict[str, Any]:
        """Return JSON values."""
        return asdict(self)


class PageConsole:
    """Stores a session's output and waits for answers from any number of pages; see `Console`."""

    def __init__(self) -> None:
        self.status: CaptureStatus | None = None
        self.question: ConsoleQuestion | None = None
        self.lines: deque[str] = deque(maxlen=MOST_LINES)
        self._count = 0
        self._answer: str | None = None
        self._ended = False
        self._changed = Lock()

    def show(self, status: CaptureStatus) -> None:
        """Store the status."""
        self.status = status

    def say(self, text: str) -> None:
        """Store a line."""
        self.lines.append(text)

    def ask(self, question: str, keys: Mapping[str, str], *, default: str, idle: Callable[[], None]) -> str:
        """Return a page's answer, calling ``idle`` meanwhile; ``q`` once the session is ending."""
        with self._changed:
            self._count += 1
            self._answer = None
            self.question = ConsoleQuestion(self._count, question, dict(keys), default)
        try:
            while (answer := self._current_answer()) is None:
                idle()
            return answer
        finally:
            with self._changed:
                self.question = None

    def _current_answer(self) -> str | None:
        with self._changed:
            return self._answer or ("q" if self._ended else None)

    def answer(self, number: int, key: str) -> bool:
        """Answer question ``number`` once; False if it is not the open question, or the key is not one of its keys."""
        with self._changed:
            question = self.question
            if question is None or question.number != number or key not in question.keys or self._answer:
                return False
            self._answer = key
            return True

    def end(self) -> None:
        """Answer every question from now on with ``q``."""
        with self._changed:
            self._ended = True


class PageMetronome(Metronome):
    """Beat that pages show and play."""

    def __init__(self, clock: Callable[[], float] = monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._beat: tuple[int, float, float, float, bool] | None = None
        self._count = 0

    def start(self, interval_s: float, seconds: float, *, back_and_forth: bool) -> None:
        """Start the beat."""
        self._count += 1
        self._beat = (self._count, self._clock(), interval_s, seconds, back_and_forth)

    def stop(self) -> None:
        """Stop the beat."""
        self._beat = None

    def facts(self) -> dict[str, Any] | None:
        """Return ``number``, ``elapsed_s``, ``interval_s`` and ``back_and_forth``; None without a beat."""
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

"""Console and metronome of a session, and traces of a sensor, as any number of tabs show them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from threading import Lock
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram_capture.session.console import CaptureStatus
from tactogram_capture.session.metronome import Metronome

MOST_LINES = 40
MOST_PENDING = 2_000_000
"""Samples per axis that wait for the rate."""


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


@dataclass
class Traces:
    """Bins of ``bin_s`` (at least one sample) over the last ``kept_s``, numbered from 0; thread-safe."""

    bin_s: float = 0.01
    kept_s: float = 10.0
    rate: float | None = None
    """Rate when the first bin was made, Hz; None while unknown."""
    _waiting: list[NDArray[np.float32]] = field(default_factory=list, repr=False)
    _bins: deque[tuple[NDArray[np.float32], NDArray[np.float32], bool]] = field(
        default_factory=deque, repr=False
    )
    _next: int = 0
    _lock: Lock = field(default_factory=Lock, repr=False)

    @property
    def per_bin(self) -> int:
        """Samples in a bin; 0 while the rate is unknown."""
        return 0 if self.rate is None else max(1, round(self.bin_s * self.rate))

    def add(self, samples: NDArray[np.float32], rate: float | None) -> None:
        """Add samples (axis, n), NaN where lost, at a rate in Hz, None if unknown."""
        with self._lock:
            self._waiting.append(samples)
            if self.rate is None:
                self.rate = rate
            if self.rate is None:
                if sum(x.shape[1] for x in self._waiting) > MOST_PENDING:
                    self._waiting.pop(0)
                return
            self._bin()

    def _bin(self) -> None:
        x = np.concatenate(self._waiting, axis=1)
        per, count = self.per_bin, x.shape[1] // self.per_bin
        self._waiting = [x[:, count * per :]]
        if not count:
            return
        cut = x[:, : count * per].reshape(len(x), count, per)
        lost: NDArray[np.bool_] = np.asarray(np.isnan(cut).any(axis=2).any(axis=0), np.bool_)
        low = np.where(np.isnan(cut), np.inf, cut).min(axis=2)
        high = np.where(np.isnan(cut), -np.inf, cut).max(axis=2)
        self._bins.extend((low[:, i], high[:, i], bool(lost[i])) for i in range(count))
        self._next += count
        keep = max(1, round(self.kept_s * float(self.rate or 1.0) / per))
        while len(self._bins) > keep:
            self._bins.popleft()

    def since(self, after: int) -> Mapping[str, Any]:
        """Return the bins from number ``after`` on that are still stored, as JSON values.

        Keys of the result: ``from`` (number of the first), ``next`` (number of the next new one), ``bin_s``, ``low``
        and ``high`` (by axis and bin; None where all samples were lost), ``lost`` (by bin, 1 if a sample was lost).
        """
        with self._lock:
            first = max(after, self._next - len(self._bins), 0)
            first = first if first <= self._next else self._next - len(self._bins)
            bins = list(self._bins)[len(self._bins) - (self._next - first) :]
            seconds = 0.0 if self.rate is None else self.per_bin / self.rate
            end = self._next
        low = [[_number(v) for v in row] for row in zip(*(b[0].tolist() for b in bins), strict=True)]
        high = [[_number(v) for v in row] for row in zip(*(b[1].tolist() for b in bins), strict=True)]
        lost = [int(b[2]) for b in bins]
        return {"from": first, "next": end, "bin_s": seconds, "low": low, "high": high, "lost": lost}


def _number(value: float) -> float | None:
    """Return four significant digits, enough for a picture; None if the sample was lost."""
    return float(f"{value:.4g}") if np.isfinite(value) else None

"""Live recognition: a classifier on a window that slides over a source, and how long the answer takes.

The classifier comes in as a function of a Signal. A window is judged by what came last: where more has come than can be
judged, windows are skipped, not queued, so that what is shown is never old.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.capture.session.feed import Feed
from tactogram.capture.session.take import bridged
from tactogram.capture.session.take_checks import level
from tactogram.capture.source import Block, SourceEnded
from tactogram.errors import ParameterError
from tactogram.signal import Signal

MOST_LOST = 0.25
"""Share of a window that may be lost for it to be judged: what is bridged by straight lines is not what was felt."""
LIVE_S = 60.0
"""An arrival that is further away is by another clock: a log's. It has no latency, and nothing of it is skipped."""
RATE_STEP = 0.1
"""Hz to which a measured rate is rounded: an estimate that moves in its last digits must not change the resampler."""


@dataclass(frozen=True)
class Classification:
    """Classification of one window.

    Parameters
    ----------
    probabilities : mapping from str to float
        By material; sum 1.
    none_of_these : bool or None
        Whether it is unlike all that the classifier knows; None where that cannot be told.
    """

    probabilities: Mapping[str, float]
    none_of_these: bool | None = None


ClassifyWindow = Callable[[Signal], Classification]
"""Judges a window as it was recorded; preparing it is its business."""


@dataclass(frozen=True)
class WindowClassification:
    """One judged window.

    Parameters
    ----------
    end_index : int
        Place of the sample after its last, counted from the source's first.
    time_s : float
        When its last sample arrived, s after the first block.
    heard : Heard or None
        None if too much of the window was lost.
    lost : float
        Share of its samples that did not come.
    level : float
        rms about the mean, root of the sum of squares over axes, the source's unit.
    latency_s : float or None
        From the arrival of its last sample to the probabilities; None for a source without a clock.
    skipped : int
        Windows that were due since the one before and were not judged.
    """

    end_index: int
    time_s: float
    heard: Classification | None
    lost: float
    level: float
    latency_s: float | None
    skipped: int

    def facts(self) -> dict[str, Any]:
        """Return it as JSON knows it."""
        facts = asdict(self)
        heard = facts.pop("heard") or {"probabilities": None, "none_of_these": None}
        named = self.heard and max(self.heard.probabilities, key=self.heard.probabilities.__getitem__)
        return {"material": named, **heard, **facts}


@dataclass
class Latencies:
    """Latency statistics of a run."""

    seconds: list[float] = field(default_factory=list)

    def add(self, guess: WindowClassification) -> None:
        """Count one window."""
        if guess.latency_s is not None:
            self.seconds.append(guess.latency_s)

    def facts(self) -> dict[str, Any]:
        """Return ``p50_ms``, ``p99_ms``, ``max_ms`` and ``windows``; None where no window had a clock."""
        if not self.seconds:
            return {"windows": 0, "p50_ms": None, "p99_ms": None, "max_ms": None}
        p50, p99 = np.percentile(self.seconds, [50, 99]) * 1e3
        worst = max(self.seconds) * 1e3
        return {"windows": len(self.seconds), "p50_ms": float(p50), "p99_ms": float(p99), "max_ms": worst}


def guesses(
    feed: Feed,
    listen: ClassifyWindow,
    *,
    window_s: float,
    hop_s: float,
    seconds: float | None = None,
    most_lost: float = MOST_LOST,
    clock: Callable[[], float] = monotonic,
) -> Iterator[WindowClassification]:
    """Yield a `WindowClassification` each ``hop_s``, until the source ends or ``seconds`` of it were heard.

    Parameters
    ----------
    feed : Feed
        Of an open source.
    listen : callable
        See `ClassifyWindow`.
    window_s : float
        What is judged: the last so many seconds.
    hop_s : float
        From one window to the next.
    most_lost : float
        See `MOST_LOST`.
    clock : callable
        The one that the source's arrivals are by.

    Raises
    ------
    ParameterError
        If window or hop is not > 0.
    SourceLost
        If the source goes away.
    """
    if not (window_s > 0 and hop_s > 0):
        raise ParameterError(f"window and hop must be > 0 s, got {window_s:g} and {hop_s:g}")
    feed.keep_s = window_s
    first = judged = None
    while True:
        try:
            block = feed.poll()
            while block is not None and hop_s < _age(block, clock) and (more := feed.poll(0.0)) is not None:
                block = more
        except SourceEnded:
            return
        rate = feed.rate
        if block is None or rate is None:
            continue
        first = feed.first_arrival_s if first is None else first
        heard_s = feed.next_index / rate
        due = feed.next_index - (judged if judged is not None else feed.next_index - hop_s * rate)
        if feed.next_index >= window_s * rate and due >= hop_s * rate:
            samples = feed.recent(window_s)
            signal, lost = window_signal(samples, rate, feed.source.unit, feed.source.axes)
            heard = listen(signal) if signal is not None and lost <= most_lost else None
            age = _age(block, clock)
            skipped = 0 if judged is None else max(0, int(due / (hop_s * rate)) - 1)
            judged = feed.next_index
            latency = age if np.isfinite(age) else None
            yield WindowClassification(
                feed.next_index, block.arrival_s - first, heard, lost, level(samples), latency, skipped
            )
        if seconds is not None and heard_s >= seconds:
            return


def _age(block: Block, clock: Callable[[], float]) -> float:
    """Return how long ago a block arrived, s; NaN where its time is by another clock."""
    age = clock() - block.arrival_s
    return age if 0 <= age < LIVE_S else float("nan")


def window_signal(
    samples: NDArray[np.float32], rate: float, unit: str, axes: Sequence[str]
) -> tuple[Signal | None, float]:
    """Return a window as a Signal, losses bridged, and the share that was lost; None if nothing came.

    Parameters
    ----------
    samples : float32 array, shape (axis, time)
        NaN where lost.
    rate : float, Hz
        Rounded to `RATE_STEP`.
    unit, axes
        As in `Signal`.
    """
    lost = float(np.isnan(samples).any(axis=0).mean())
    if lost == 1.0:
        return None, lost
    return Signal(bridged(samples)[0], round(rate / RATE_STEP) * RATE_STEP, unit, tuple(axes)), lost

"""Live recognition: a classifier on a window that slides over a source, and its latency.

The classifier is passed in as a function of a Signal. It gets the latest samples: if they arrive faster than it
can classify them, windows are skipped rather than queued, so that the result is never old.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram_capture.session.feed import Feed
from tactogram_capture.session.take import level
from tactogram_capture.source import Block, SourceEnded
from tactogram_capture.stream.gaps import bridged

MOST_LOST = 0.25
"""Largest lost share of a window that is classified: bridged samples are not measured ones."""
LIVE_S = 60.0
"""Older arrivals are on another clock, that of a log: they have no latency, and no window is skipped."""
RATE_STEP = 0.1
"""Step of the rate, Hz: small changes of the estimate must not change the resampler."""


@dataclass(frozen=True)
class Classification:
    """Classification of one window."""

    probabilities: Mapping[str, float]
    """By material; sum 1."""
    none_of_these: bool | None = None
    """Whether the window is too far from all materials of the classifier; None if unknown."""


ClassifyWindow = Callable[[Signal], Classification]
"""Function that prepares and classifies a window as recorded."""


@dataclass(frozen=True)
class WindowClassification:
    """One window and its classification."""

    end_index: int
    """Position of the sample after its last, counted from the source's first."""
    time_s: float
    """Arrival of its last sample, s after the first block."""
    classification: Classification | None
    """None if too much of the window was lost."""
    lost: float
    """Lost share of its samples."""
    level: float
    """rms about the mean, root of the sum of squares over axes, the source's unit."""
    latency_s: float | None
    """From the arrival of its last sample to the probabilities; None for a source without a clock."""
    skipped: int
    """Windows skipped since the preceding one."""

    def facts(self) -> dict[str, Any]:
        """Return JSON values."""
        facts = asdict(self)
        classification = facts.pop("classification") or {"probabilities": None, "none_of_these": None}
        return {"material": self.material, **classification, **facts}

    @property
    def material(self) -> str | None:
        """The most probable material; None if the window was not classified."""
        if self.classification is None:
            return None
        probabilities = self.classification.probabilities
        return max(probabilities, key=probabilities.__getitem__)


@dataclass
class Latencies:
    """Latency statistics of a run."""

    seconds: list[float] = field(default_factory=list)

    def add(self, guess: WindowClassification) -> None:
        """Count one window."""
        if guess.latency_s is not None:
            self.seconds.append(guess.latency_s)

    def facts(self) -> dict[str, Any]:
        """Return ``p50_ms``, ``p99_ms``, ``max_ms`` and ``windows``; None if no window had a clock."""
        if not self.seconds:
            return {"windows": 0, "p50_ms": None, "p99_ms": None, "max_ms": None}
        p50, p99 = np.percentile(self.seconds, [50, 99]) * 1e3
        worst = max(self.seconds) * 1e3
        return {"windows": len(self.seconds), "p50_ms": float(p50), "p99_ms": float(p99), "max_ms": worst}


def classify_windows(
    feed: Feed,
    classify: ClassifyWindow,
    *,
    window_s: float,
    hop_s: float,
    seconds: float | None = None,
    most_lost: float = MOST_LOST,
    clock: Callable[[], float] = monotonic,
) -> Iterator[WindowClassification]:
    """Yield a window of ``window_s`` every ``hop_s``, until the source ends or ``seconds`` of it have arrived.

    ``most_lost`` is as `MOST_LOST`; ``clock`` is that of the source's arrivals. Raises `ParameterError` if window or
    hop is not > 0, `SourceLost` if the source disappears.
    """
    if not (window_s > 0 and hop_s > 0):
        raise ParameterError(f"window and hop must be > 0 s, got {window_s:g} and {hop_s:g}")
    feed.keep_s = window_s
    first = classified = None
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
        received_s = feed.next_index / rate
        due = hop_s * rate if classified is None else feed.next_index - classified
        if feed.next_index >= window_s * rate and due >= hop_s * rate:
            samples = feed.recent(window_s)
            signal, lost = window_signal(samples, rate, feed.source.unit, feed.source.axes)
            result = classify(signal) if signal is not None and lost <= most_lost else None
            age = _age(block, clock)
            skipped = 0 if classified is None else max(0, int(due / (hop_s * rate)) - 1)
            classified = feed.next_index
            latency = age if np.isfinite(age) else None
            yield WindowClassification(
                feed.next_index, block.arrival_s - first, result, lost, level(samples), latency, skipped
            )
        if seconds is not None and received_s >= seconds:
            return


def _age(block: Block, clock: Callable[[], float]) -> float:
    """Return the time since a block arrived, s; NaN if its arrival is on another clock."""
    age = clock() - block.arrival_s
    return age if 0 <= age < LIVE_S else float("nan")


def window_signal(
    samples: NDArray[np.float32], rate: float, unit: str, axes: Sequence[str]
) -> tuple[Signal | None, float]:
    """Return a window as a Signal with losses bridged (None if all was lost), and the lost share.

    ``samples`` is float32, shape (axis, time), NaN where lost; ``rate`` (Hz) is rounded to `RATE_STEP`.
    """
    lost = float(np.isnan(samples).any(axis=0).mean())
    if lost == 1.0:
        return None, lost
    return Signal(bridged(samples)[0], round(rate / RATE_STEP) * RATE_STEP, unit, tuple(axes)), lost

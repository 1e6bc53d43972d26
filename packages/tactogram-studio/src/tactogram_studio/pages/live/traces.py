"""Sensor traces of the last seconds: minimum and maximum per hundredth of a second."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST_PENDING = 2_000_000
"""Samples per axis that wait for the rate."""


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

"""Gap handling: signals from samples with gaps, either in segments or with the gaps filled and counted.

A `Signal` must be finite, because every filter would spread a NaN over the whole signal. A recording with
losses therefore becomes either its gap-free segments, in which every sample was measured, or one signal whose gaps are
filled on request and reported. Segments are the default of everything that reads a log: a packet of ten lost samples
cannot be reconstructed from its neighbours.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal

Filling = Literal["linear", "hold"]


@dataclass(frozen=True, eq=False)
class GapFreeSegment:
    """Samples between two gaps; ``first_index`` counts lost samples, too."""

    signal: Signal
    first_index: int


@dataclass(frozen=True)
class GapFillSummary:
    """Summary of filled gaps."""

    how: str
    """``"linear"`` or ``"hold"``."""
    samples: int
    """Number of filled samples."""
    gaps: int
    longest: int
    """Samples of the longest gap."""
    share: float
    """Filled share of all samples."""

    def facts(self) -> dict[str, Any]:
        """Return JSON values."""
        return asdict(self)


def gaps(samples: NDArray[np.float32]) -> list[tuple[int, int]]:
    """Return start and stop of each run of NaN (in any axis) in ``samples``, shape (axis, time), in order."""
    return runs(_missing(samples))


def gap_free(
    samples: NDArray[np.float32],
    rate: float,
    unit: str,
    axes: tuple[str, ...] = (),
    *,
    least_s: float = 0.0,
) -> list[GapFreeSegment]:
    """Return the segments between the gaps, in order; those shorter than ``least_s`` are left out.

    ``samples`` is float32, shape (axis, time), ``unit``, NaN where lost; ``rate`` is in Hz, ``unit`` and ``axes`` as in
    `Signal`.
    """
    least = max(1, round(least_s * rate))
    return [
        GapFreeSegment(Signal(samples[:, start:stop], rate, unit, axes), start)
        for start, stop in runs(~_missing(samples))
        if stop - start >= least
    ]


def filled(
    samples: NDArray[np.float32],
    rate: float,
    unit: str,
    axes: tuple[str, ...] = (),
    *,
    how: Filling,
    most_s: float = 0.1,
) -> tuple[Signal, GapFillSummary]:
    """Return one signal with its gaps filled, and a summary; gaps at either end are cut off.

    Parameters
    ----------
    samples, rate, unit, axes
        As in `gap_free`.
    how : {"linear", "hold"}
        A straight line between the samples around a gap, or the sample before it.
    most_s : float
        Longest gap that may be filled, s.

    Raises
    ------
    ParameterError
        If ``how`` is neither.
    DataError
        If all samples are missing, or a gap is longer.
    """
    if how not in ("linear", "hold"):
        raise ParameterError(f"how must be 'linear' or 'hold', got {how!r}")
    received = np.flatnonzero(~_missing(samples))
    if not len(received):
        raise DataError("all samples are missing: no gap can be filled")
    x = np.array(samples[:, received[0] : received[-1] + 1])
    holes = gaps(x)
    longest = max((stop - start for start, stop in holes), default=0)
    if longest > most_s * rate:
        raise DataError(
            f"a gap of {longest / rate:.3g} s is longer than the limit for filling ({most_s:g} s); "
            "take the segments between the gaps instead"
        )
    missing = _missing(x)
    places, valid = np.arange(x.shape[1]), np.flatnonzero(~missing)
    if how == "hold":
        x = x[:, np.maximum.accumulate(np.where(missing, 0, places))]
    else:
        for row in x:
            row[missing] = np.interp(places[missing], valid, row[valid])
    count = int(missing.sum())
    return Signal(x, rate, unit, axes), GapFillSummary(how, count, len(holes), longest, count / len(missing))


def _missing(samples: NDArray[np.float32]) -> NDArray[np.bool_]:
    return np.asarray(np.isnan(samples).any(axis=0), dtype=np.bool_)


def runs(where: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return start and stop of each run of True, in order."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], where.astype(np.int8), [0]])))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]

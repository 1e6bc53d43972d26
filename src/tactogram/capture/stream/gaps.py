"""Gap handling: signals from samples with gaps, either in segments or with the gaps filled and counted.

A `Signal` refuses what is not finite, because every filter would spread one NaN over everything. So a recording with
losses becomes either its gap-free pieces, in which every sample was measured, or one signal whose gaps are filled on
request, and the report says how many samples that were. Which of the two is never decided silently: pieces are the
default of everything that reads a log, because ten samples say nothing band-limited about the ten between them.
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
    """Samples between two gaps.

    Parameters
    ----------
    signal : Signal
    first_index : int
        Place of its first sample, lost ones included.
    """

    signal: Signal
    first_index: int


@dataclass(frozen=True)
class GapFillSummary:
    """Summary of filled gaps.

    Parameters
    ----------
    how : {"linear", "hold"}
    samples, gaps : int
        How many samples, in how many gaps.
    longest : int
        Samples of the longest gap.
    share : float
        Of all samples.
    """

    how: str
    samples: int
    gaps: int
    longest: int
    share: float

    def facts(self) -> dict[str, Any]:
        """Return it as JSON knows it."""
        return asdict(self)


def gaps(samples: NDArray[np.float32]) -> list[tuple[int, int]]:
    """Return first sample and the one after the last of each run of NaN (in any axis), in order.

    Parameters
    ----------
    samples : float32 array, shape (axis, time)
    """
    return _runs(_missing(samples))


def gap_free(
    samples: NDArray[np.float32],
    rate: float,
    unit: str,
    axes: tuple[str, ...] = (),
    *,
    least_s: float = 0.0,
) -> list[GapFreeSegment]:
    """Return the pieces between the gaps, in order.

    Parameters
    ----------
    samples : float32 array, shape (axis, time), ``unit``
        NaN where lost.
    rate : float, Hz
    unit, axes
        As in `Signal`.
    least_s : float
        Shorter pieces are left out.
    """
    least = max(1, round(least_s * rate))
    return [
        GapFreeSegment(Signal(samples[:, start:stop], rate, unit, axes), start)
        for start, stop in _runs(~_missing(samples))
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
    """Return one signal whose gaps are filled, and how much of it is.

    Gaps at either end are cut off, not filled.

    Parameters
    ----------
    samples, rate, unit, axes
        As in `gap_free`.
    how : {"linear", "hold"}
        A straight line from the sample before a gap to the one behind it, or the sample before it.
    most_s : float
        The longest gap that may be filled.

    Raises
    ------
    DataError
        If there is no sample, or a gap is longer.
    """
    if how not in ("linear", "hold"):
        raise ParameterError(f"a gap is filled by 'linear' or 'hold', got {how!r}")
    came = np.flatnonzero(~_missing(samples))
    if not len(came):
        raise DataError("no sample came: there is nothing to fill between")
    kept = np.array(samples[:, came[0] : came[-1] + 1])
    holes = gaps(kept)
    longest = max((stop - start for start, stop in holes), default=0)
    if longest > most_s * rate:
        raise DataError(
            f"a gap of {longest / rate:.3g} s is longer than what may be filled ({most_s:g} s); "
            "take the pieces between the gaps instead"
        )
    missing = _missing(kept)
    places, known = np.arange(kept.shape[1]), np.flatnonzero(~missing)
    if how == "hold":
        kept = kept[:, np.maximum.accumulate(np.where(missing, 0, places))]
    else:
        for row in kept:
            row[missing] = np.interp(places[missing], known, row[known])
    count = int(missing.sum())
    return Signal(kept, rate, unit, axes), GapFillSummary(
        how, count, len(holes), longest, count / len(missing)
    )


def _missing(samples: NDArray[np.float32]) -> NDArray[np.bool_]:
    return np.asarray(np.isnan(samples).any(axis=0), dtype=np.bool_)


def _runs(where: NDArray[np.bool_]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], where.astype(np.int8), [0]])))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]

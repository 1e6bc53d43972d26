"""Gap handling: signals from samples with gaps, either in segments or with the gaps filled and counted.

A `Signal` must be finite, because every filter would spread a NaN over the whole signal. A recording with
losses therefore becomes either its gap-free segments, in which every sample was measured, or one signal whose gaps are
filled on request and reported. Segments are the default of everything that reads a log: a packet of ten lost samples
cannot be reconstructed from its neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.signal import Signal


@dataclass(frozen=True, eq=False)
class GapFreeSegment:
    """Samples between two gaps; ``first_index`` counts lost samples, too."""

    signal: Signal
    first_index: int


def gaps(samples: NDArray[np.float32]) -> list[tuple[int, int]]:
    """Return start and stop of each run of NaN (in any axis) in ``samples``, shape (axis, time), in order."""
    return runs(_missing(samples))


def gap_free(
    samples: NDArray[np.float32], rate: float, unit: str, axes: tuple[str, ...] = ()
) -> list[GapFreeSegment]:
    """Return the segments between the gaps, in order.

    ``samples`` is float32, shape (axis, time), ``unit``, NaN where lost; ``rate`` is in Hz, ``unit`` and ``axes`` as in
    `Signal`.
    """
    return [
        GapFreeSegment(Signal(samples[:, start:stop], rate, unit, axes), start)
        for start, stop in runs(~_missing(samples))
    ]


def bridged(samples: NDArray[np.float32]) -> tuple[NDArray[np.float32], list[tuple[int, int]]]:
    """Return ``samples`` with losses bridged by straight lines, and the start and stop of each loss.

    A packet of ten lost samples cannot be reconstructed from its neighbours, so nothing more elaborate is tried; at
    an end the nearest sample is repeated. ``samples`` is float32, shape (axis, time), with NaN in every axis where a
    sample was lost; the result is finite. Raises `DataError` if all samples were lost.
    """
    missing = _missing(samples)
    if missing.all():
        raise DataError(f"all {samples.shape[1]} samples were lost")
    lost = runs(missing)
    if not lost:
        return samples, lost
    places = np.arange(samples.shape[1])
    whole = samples.copy()
    for axis in whole:
        axis[missing] = np.interp(places[missing], places[~missing], axis[~missing])
    return whole, lost


def filled(
    samples: NDArray[np.float32], rate: float, unit: str, axes: tuple[str, ...] = (), *, most_s: float = 0.1
) -> tuple[Signal, dict[str, Any]]:
    """Return one signal with its gaps bridged, and facts; gaps at either end are cut off.

    ``samples``, ``rate``, ``unit`` and ``axes`` are as in `gap_free`; ``most_s`` is the longest gap that may be filled,
    s. The facts are the number of filled ``samples``, that of ``gaps``, the samples of the ``longest`` one, and the
    filled ``share``. Raises `DataError` if all samples are missing, or a gap is longer.
    """
    received = np.flatnonzero(~_missing(samples))
    inner = samples[:, received[0] : received[-1] + 1] if len(received) else samples
    whole, lost = bridged(inner)
    lengths = [stop - start for start, stop in lost]
    longest, count = max(lengths, default=0), sum(lengths)
    if longest > most_s * rate:
        raise DataError(
            f"a gap of {longest / rate:.3g} s is longer than the limit for filling ({most_s:g} s); "
            "take the segments between the gaps instead"
        )
    facts = {"samples": count, "gaps": len(lost), "longest": longest, "share": count / whole.shape[1]}
    return Signal(whole, rate, unit, axes), facts


def _missing(samples: NDArray[np.float32]) -> NDArray[np.bool_]:
    return np.asarray(np.isnan(samples).any(axis=0), dtype=np.bool_)


def runs(where: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return start and stop of each run of True, in order."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], where.astype(np.int8), [0]])))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]

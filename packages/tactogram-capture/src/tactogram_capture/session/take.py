"""One take: the samples between start and stop, and its recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Recording
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal
from tactogram_capture.source import Block
from tactogram_capture.stream.gaps import bridged

RATE_TOLERANCE = 1e-3
"""Largest relative difference between a measured rate and the reference: the joint error of a crystal and of
the fit to a few seconds of arrivals. A difference of 0.1 % moves 100 Hz by 0.1 Hz."""

RATE_KNOWN = 0.005
"""Half the relative interval of a measured rate at which a take may begin: after some seconds of arrivals."""

RECEIVED = "received"
"""Stream of a take with losses: 1 for a received sample, 0 for a lost one."""

STREAM_OF_UNIT = {"m/s^2": "acceleration", "m/s": "velocity", "m": "position", "N": "force"}


@dataclass(frozen=True, eq=False)
class Take:
    """Samples between start and stop."""

    samples: NDArray[np.float32]
    """float32, shape (axis, time), ``unit``; NaN in every axis where a sample was lost."""
    axes: tuple[str, ...]
    unit: str
    rate: float
    """Hz, see `rate_of`."""
    measured: float | None
    """Rate measured by the source, Hz."""
    first_index: int
    """Position of the first sample since the source was opened, lost ones included, as in the raw log."""

    def __len__(self) -> int:
        """Return the number of samples per axis, lost ones included."""
        return int(self.samples.shape[1])

    @property
    def seconds(self) -> float:
        """Length in s."""
        return len(self) / self.rate

    @property
    def received(self) -> NDArray[np.bool_]:
        """Whether each sample was received, bool, shape (time,)."""
        return np.asarray(~np.isnan(self.samples).any(axis=0))

    @property
    def lost(self) -> int:
        """Number of lost samples."""
        return int(len(self) - np.count_nonzero(self.received))


def joined(blocks: Sequence[Block], *, start: int, stop: int) -> NDArray[np.float32]:
    """Return samples ``start`` to ``stop`` (exclusive) of a source's blocks, float32, shape (axis, time).

    Raises `DataError` if there are none, or the blocks are not consecutive.
    """
    inside = [b for b in blocks if b.first_index < stop and b.first_index + len(b) > start]
    if not inside:
        raise DataError("no samples arrived between start and stop")
    for before, after in pairwise(inside):
        if after.first_index != before.first_index + len(before):
            raise DataError(
                f"blocks must be consecutive, got one at sample {after.first_index} after one that ended at "
                f"{before.first_index + len(before)}"
            )
    samples = np.concatenate([b.samples for b in inside], axis=1)
    first = inside[0].first_index
    return samples[:, max(0, start - first) : stop - first]


def rate_of(measured: Mapping[str, float] | None, reference: float | None) -> float | None:
    """Return the rate to write a take with, Hz; None while unknown.

    It is ``reference`` until a measurement contradicts it: one with an interval within `RATE_KNOWN` that excludes
    the reference, and a difference of more than `RATE_TOLERANCE`. A few arrivals on a busy computer are not enough.
    Without a reference it is the measured rate, once its interval is as narrow. ``measured`` has ``hz``, ``low`` and
    ``high``, as in a source's facts.
    """
    if measured is None:
        return reference
    hz, low, high = measured["hz"], measured["low"], measured["high"]
    if high - low > 2 * RATE_KNOWN * hz:
        return reference
    agrees = reference is not None and (abs(hz / reference - 1) <= RATE_TOLERANCE or low <= reference <= high)
    return reference if agrees else hz


def recording_of(
    take: Take, *, stream: str = "", what: Mapping[str, Any], simulated: bool, notes: Sequence[str] = ()
) -> Recording:
    """Return ``take`` as a recording for the store, with the fields ``what`` besides streams and history.

    A store holds finite samples. Losses are bridged by straight lines and marked in `RECEIVED`, and ``history``
    gives their number and positions after the source's ``notes``, so that users can exclude them. The stream is named
    by the unit by default.
    """
    samples, lost = bridged(take.samples)
    name = stream or STREAM_OF_UNIT.get(take.unit, "signal")
    if name == RECEIVED:
        raise ParameterError(f"stream must not be called {RECEIVED!r}: that is where losses are marked")
    streams = {name: Signal(samples, take.rate, take.unit, take.axes)}
    history = [*notes, rate_text(take)]
    if lost:
        mask = take.received[None].astype(np.float32)
        streams[RECEIVED] = Signal(mask, take.rate, "1", (RECEIVED,))
        history.append(loss_text(take, lost))
    return Recording(streams=streams, history=tuple(history), simulated=simulated, **what)


def restored(recording: Recording, *, stream: str = "") -> NDArray[np.float32]:
    """Return the samples of a `recording_of` a take with NaN for the lost ones, float32, shape (axis, time)."""
    name = stream or next(name for name in recording.streams if name != RECEIVED)
    samples = np.array(recording.stream(name).samples)
    if RECEIVED in recording.streams:
        samples[:, recording.stream(RECEIVED).samples[0] == 0] = np.nan
    return samples


def rate_text(take: Take) -> str:
    """Return a line about the rate."""
    if take.measured is None:
        return f"{take.rate:g} Hz as the source says; not measured"
    if take.measured == take.rate:
        return f"{take.rate:.8g} Hz as measured"
    return f"{take.rate:g} Hz; measured {take.measured:.6g} Hz ({1e6 * (take.measured / take.rate - 1):+.0f} ppm)"


def loss_text(take: Take, lost: Sequence[tuple[int, int]]) -> str:
    """Return a line about the losses: their number, and the positions of the first ten."""
    places = ", ".join(f"{a / take.rate:.3f}-{b / take.rate:.3f}" for a, b in lost[:10])
    more = ", …" if len(lost) > 10 else ""
    return (
        f"lost {take.lost} of {len(take)} samples in {len(lost)} gaps (s: {places}{more}); bridged by straight lines, "
        f"marked in stream {RECEIVED}"
    )

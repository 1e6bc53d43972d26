"""One take: the samples between start and stop, its recording, and the checks of its quality."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Recording
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal
from tactogram_capture.session.plan import TakeLimits
from tactogram_capture.source import Block
from tactogram_capture.stream.gaps import bridged, gaps, runs

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
        raise ParameterError.must("stream", f"not be called {RECEIVED!r}: that is where losses are marked")
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


LEAST_RMS = {"m/s^2": 0.12}
"""Default of `TakeLimits.least_rms` by unit."""
STUCK_SAMPLES = 3
"""Consecutive samples at a take's extreme that count as clipping if full scale is unknown."""
COARSE_STEPS = 16
"""Range in a sensor's steps within which rounding alone repeats a value."""
FLAT_S = 0.5
"""An axis that does not change for this time is broken: even the noise of a working sensor changes."""


@dataclass(frozen=True)
class TakeCheck:
    """Result of one check."""

    name: str
    """``length``, ``losses``, ``clipping``, ``flat``, ``level`` or ``rate``."""
    verdict: Literal["good", "note", "bad"]
    text: str
    """The value, and the limit if it is exceeded."""


@dataclass(frozen=True)
class TakeAssessment:
    """Result of all checks of a take."""

    findings: tuple[TakeCheck, ...]

    @property
    def good(self) -> bool:
        """Whether no check is bad."""
        return all(finding.verdict != "bad" for finding in self.findings)

    def __str__(self) -> str:
        """Return the failed checks, or else the notes, in a line."""
        bad = [f.text for f in self.findings if f.verdict == "bad"]
        notes = [f.text for f in self.findings if f.verdict == "note"]
        if bad:
            return "bad: " + "; ".join(bad)
        return "good" + (": " + "; ".join(notes) if notes else "")

    def facts(self) -> dict[str, Any]:
        """Return JSON values."""
        return {"good": self.good} | {f.name: {"verdict": f.verdict, "text": f.text} for f in self.findings}


def check_take(
    take: Take,
    limits: TakeLimits,
    *,
    seconds: float,
    nominal: float | None = None,
    full_scale: float | None = None,
) -> TakeAssessment:
    """Return the quality of ``take``, planned to last ``seconds``.

    ``nominal`` is the rate of the source or the plan, Hz; ``limits.full_scale`` overrides the source's
    ``full_scale``.
    """
    findings = [_length(take, limits, seconds), *_losses(take, limits), _rate(take, limits, nominal)]
    if take.lost < len(take):
        findings += [
            _clipping(take, limits, limits.full_scale or full_scale),
            _flat(take),
            _level(take, limits),
        ]
    return TakeAssessment(tuple(findings))


def _length(take: Take, limits: TakeLimits, seconds: float) -> TakeCheck:
    verdict: Literal["good", "bad"] = "good" if take.seconds >= limits.shortest * seconds else "bad"
    return TakeCheck("length", verdict, f"{take.seconds:.2f} of {seconds:g} s")


def _losses(take: Take, limits: TakeLimits) -> list[TakeCheck]:
    if take.lost == len(take):
        return [TakeCheck("losses", "bad", "every sample was lost")]
    lost = gaps(take.samples)
    if not lost:
        return [TakeCheck("losses", "good", "nothing lost")]
    share, longest = take.lost / len(take), max(b - a for a, b in lost) / take.rate
    text = f"{100 * share:.2g} % lost in {len(lost)} gaps, the longest {longest:.2g} s"
    bad = share > limits.most_lost or longest > limits.longest_gap_s
    limit = f" (at most {100 * limits.most_lost:g} % and {limits.longest_gap_s:g} s)" if bad else ""
    return [TakeCheck("losses", "bad" if bad else "note", text + limit)]


def _rate(take: Take, limits: TakeLimits, nominal: float | None) -> TakeCheck:
    if take.measured is None:
        return TakeCheck("rate", "note", f"rate not measured, assumed {take.rate:g} Hz")
    text = f"measured {take.measured:.5g} Hz"
    if nominal is None:
        return TakeCheck("rate", "good", text)
    off = abs(take.measured / nominal - 1)
    if off > limits.rate_off:
        return TakeCheck("rate", "bad", f"{text} instead of {nominal:g} Hz")
    return TakeCheck("rate", "good" if take.rate == nominal else "note", f"{text}, nominal {nominal:g} Hz")


def clipped(samples: NDArray[np.float32], full_scale: float | None) -> int:
    """Return the number of ``samples``, shape (axis, time), that are clipped in any axis.

    If full scale is unknown, these are runs of at least `STUCK_SAMPLES` at an axis's largest or smallest value,
    unless that is 0 (a force before contact) or so close to the median that only the sensor's steps show.
    """
    if full_scale is not None:
        return int(np.count_nonzero((np.abs(samples) >= 0.999 * full_scale).any(axis=0)))
    stuck = np.zeros(samples.shape[1], bool)
    for axis in samples:
        finite = axis[np.isfinite(axis)]
        if not finite.size or finite.min() == finite.max():
            continue
        far = COARSE_STEPS * float(np.diff(np.unique(finite)).min())
        for extreme in (finite.min(), finite.max()):
            if extreme != 0 and abs(extreme - np.median(finite)) >= far:
                stuck |= _in_runs(axis == extreme, STUCK_SAMPLES)
    return int(np.count_nonzero(stuck))


def _clipping(take: Take, limits: TakeLimits, full_scale: float | None) -> TakeCheck:
    count = clipped(take.samples, full_scale)
    if not count:
        return TakeCheck("clipping", "good", "no clipping")
    where = f"at {full_scale:g} {take.unit}" if full_scale is not None else "at the take's own extreme"
    bad = count > limits.most_clipped * len(take)
    return TakeCheck("clipping", "bad" if bad else "note", f"{count} samples clipped {where}")


def _flat(take: Take) -> TakeCheck:
    longest = round(FLAT_S * take.rate)
    flat = []
    for name, axis in zip(take.axes, take.samples, strict=True):
        received = axis[np.isfinite(axis)]
        if len(received) > 1 and _in_runs(np.diff(received) == 0, min(longest, len(received) - 1)).any():
            flat.append(name)
    if not flat:
        return TakeCheck("flat", "good", "every axis changes")
    text = f"axis {', '.join(flat)} is constant for {min(FLAT_S, take.seconds):.2g} s"
    return TakeCheck("flat", "bad", text)


def level(samples: NDArray[np.float32]) -> float:
    """Return the rms about the mean, root of the sum of squares over axes, without lost samples."""
    received = samples[:, np.isfinite(samples).all(axis=0)].astype(np.float64)
    return float(np.sqrt(received.var(axis=1).sum())) if received.size else 0.0


def _level(take: Take, limits: TakeLimits) -> TakeCheck:
    least = limits.least_rms if limits.least_rms is not None else LEAST_RMS.get(take.unit)
    rms = level(take.samples)
    text = f"{rms:.3g} {take.unit} rms"
    if least is not None and rms < least:
        return TakeCheck("level", "bad", f"{text}, less than {least:g}: was the surface stroked?")
    return TakeCheck("level", "good", text)


def _in_runs(hits: NDArray[np.bool_], shortest: int) -> NDArray[np.bool_]:
    """Return the elements of ``hits`` in runs of at least ``shortest``."""
    inside = np.zeros(len(hits), bool)
    for begin, end in runs(hits):
        inside[begin:end] = end - begin >= shortest
    return inside

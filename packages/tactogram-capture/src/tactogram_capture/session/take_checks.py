"""Take checks: the quality of a take, reported before it is accepted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram_capture.session.plan import TakeLimits
from tactogram_capture.session.take import Take
from tactogram_capture.stream.gaps import gaps, runs

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
    found = [_length(take, limits, seconds), *_losses(take, limits), _rate(take, limits, nominal)]
    if take.lost < len(take):
        found += [
            _clipping(take, limits, limits.full_scale or full_scale),
            _flat(take),
            _level(take, limits),
        ]
    return TakeAssessment(tuple(found))


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

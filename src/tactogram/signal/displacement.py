"""Displacement domain: signals over time resampled to position, and back at a finger's speed.

A pattern of k cycles per mm that passes at v mm/s is felt at f = v k Hz. Both ways are band-limited: content that the
new rate cannot represent is removed, not folded back.
"""

from __future__ import annotations

import math

import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.errors import ParameterError, UnitError
from tactogram.signal.resampling import check_growth, resample
from tactogram.signal.signal import Signal, check_rate

STANDSTILL = 0.1
"""Share of the median speed below which a finger counts as standing still."""
OVERSAMPLED = 8
"""Oversampling for a cubic spline within 1e-4 of the band-limited signal up to 0.45 of the rate."""


def over_displacement(
    signal: Signal, speed_mm_s: float | Signal, *, rate: float | None = None, standstill: float = STANDSTILL
) -> Signal:
    """Return a signal over time as one over the distance travelled.

    Travel is monotone: the distance is the integral of the magnitude of the speed, so that a stroke back continues
    where the stroke forth ended, over the same ground again. Samples during standstill (slower than ``standstill``
    times the median speed; turning points too) are dropped, and those on both sides become neighbours.

    Raises `UnitError` if the speed is not in m/s; `ParameterError` if ``signal`` or the speed is not over time, their
    durations differ, or nothing moves.

    Parameters
    ----------
    signal : Signal
        Over time.
    speed_mm_s : float or Signal
        A constant speed > 0 in mm/s; or the speed over time, a Signal of one axis in m/s that begins with ``signal``
        and has its duration to within one sample, at any rate; its sign does not matter.
    rate : float, optional
        Samples per mm of the result; by default ``signal.rate`` by the speed (its median), which keeps the information
        recorded at that speed.
    standstill : float, 0 to 1
        Share of the median speed (above a hundredth of the fastest).

    Returns
    -------
    Signal
        Over displacement, of the same unit and axes. Its first sample is where the finger first moves.
    """
    if signal.domain != "time":
        raise ParameterError("signal is over displacement already; expected one over time")
    if not isinstance(speed_mm_s, Signal):
        still = _constant(signal, _speed(speed_mm_s), "displacement")
        return still if rate is None else resample(still, rate)
    if not 0 < standstill < 1:
        raise ParameterError.must("standstill", "be a share above 0 and below 1", standstill)
    speed = np.abs(_over_time_of(signal, speed_mm_s))  # mm/s, at each sample
    fastest = float(speed.max())
    if fastest == 0:
        raise ParameterError("the speed is 0 all the time: nothing moves, there is no displacement")
    median = float(np.median(speed[speed > 0.01 * fastest]))
    least = standstill * median
    moving = speed >= least
    pieces = [
        _travelled(signal.samples[:, start:stop], speed[start:stop], signal.rate, least)
        for start, stop in _runs(moving)
        if stop - start > 1
    ]
    if not pieces:
        raise ParameterError(
            "the finger never moves for two samples on end; check the speed and its unit, m/s"
        )
    fine = signal.with_samples(
        np.concatenate(pieces, axis=1), rate=signal.rate / least, domain="displacement"
    )
    return resample(fine, signal.rate / median if rate is None else rate)


def played(signal: Signal, speed_mm_s: float | Signal, rate: float) -> Signal:
    """Return the signal over time of a finger that moves over a signal over displacement.

    Raises `UnitError` if the speed is not in m/s; `ParameterError` if ``signal`` is over time, the speed is not, or the
    finger leaves the surface.

    Parameters
    ----------
    signal : Signal
        Over displacement.
    speed_mm_s : float or Signal
        A constant speed > 0 in mm/s, over the whole length; or the speed over time, a Signal of one axis in m/s. Its
        sign counts: a returning finger meets the same ground from the other side. It begins at position 0.
    rate : float, Hz
        Of the result. Content above half of it is removed.

    Returns
    -------
    Signal
        Of the same unit and axes; as long as the length takes at a constant speed, or as the speed.
    """
    if signal.domain != "displacement":
        raise ParameterError("signal is over time already; expected one over displacement")
    check_rate(rate)
    if not isinstance(speed_mm_s, Signal):
        return resample(_constant(signal, _speed(speed_mm_s), "time"), rate)
    speed = _checked(speed_mm_s)
    fastest = 1e3 * float(np.abs(speed.samples).max())
    # The finest detail, half a cycle per sample of the surface, at the fastest moment must not fold back.
    inside = rate * max(1, math.ceil(fastest * signal.rate / rate))
    check_growth(
        inside * speed.seconds, len(speed), f"at up to {fastest:g} mm/s over {signal.rate:g} samples per mm"
    )
    count = max(1, round(speed.seconds * inside))
    path = _integral(speed)(np.arange(count) / inside)  # mm
    end = (len(signal) - 1) / signal.rate
    slack = 1 / signal.rate
    if path.min() < -slack or path.max() > end + slack:
        raise ParameterError(
            f"the finger moves over {path.min():.4g} to {path.max():.4g} mm, the signal goes from 0 to {end:.4g}; "
            "give a shorter speed or a longer signal"
        )
    met = _interpolated(signal.samples, np.clip(path, 0, end) * signal.rate)
    return resample(signal.with_samples(met, rate=inside, domain="time"), rate)


def _constant(signal: Signal, speed_mm_s: float, domain: str) -> Signal:
    """Return the same samples over the other domain."""
    rate = signal.rate / speed_mm_s if domain == "displacement" else signal.rate * speed_mm_s
    return signal.with_samples(signal.samples, rate=rate, domain=domain)


def _speed(speed_mm_s: float) -> float:
    if not (speed_mm_s > 0 and math.isfinite(speed_mm_s)):
        raise ParameterError.must("speed", "be > 0 mm/s and finite", speed_mm_s)
    return float(speed_mm_s)


def _checked(speed: Signal) -> Signal:
    if speed.unit != "m/s":
        raise UnitError(f"a speed over time must be a signal in m/s, got {speed.unit}")
    if speed.domain != "time" or len(speed.axes) != 1:
        raise ParameterError(
            f"a speed must be one axis over time, got {len(speed.axes)} axes over {speed.domain}"
        )
    return speed


def _over_time_of(signal: Signal, speed: Signal) -> NDArray[np.float64]:
    """Return the speed at each sample of ``signal``, mm/s, float64, shape (time,)."""
    speed = _checked(speed)
    if abs(speed.seconds - signal.seconds) > 1.5 / min(speed.rate, signal.rate):
        raise ParameterError(
            f"signal and speed must last equally long, got {signal.seconds:g} and {speed.seconds:g} s; cut one"
        )
    times = np.arange(len(signal)) / signal.rate
    return np.asarray(1e3 * np.interp(times, np.arange(len(speed)) / speed.rate, speed.samples[0]))


def _integral(speed: Signal) -> scipy.interpolate.CubicSpline:
    """Return the position over time, mm: the integral of a cubic spline through the speed."""
    v = 1e3 * speed.samples[0].astype(np.float64)
    t = np.arange(len(v)) / speed.rate
    if len(v) == 1:
        return scipy.interpolate.CubicSpline([0, 1 / speed.rate], [0, v[0] / speed.rate])
    return scipy.interpolate.CubicSpline(t, v).antiderivative()


def _runs(moving: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return begin and end of each interval of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], moving, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _travelled(
    samples: NDArray[np.float32], speed: NDArray[np.float64], rate: float, least: float
) -> NDArray[np.float64]:
    """Return an interval without standstill on the grid of its slowest part, for which no detail is too fine."""
    time = np.arange(len(speed))
    if len(time) > 2:
        path = scipy.interpolate.CubicSpline(time, speed / rate).antiderivative()(time)
    else:
        path = time * speed[0] / rate
    path = np.maximum.accumulate(path)
    step = least / rate
    count = max(1, math.floor(path[-1] / step))
    check_growth(
        count, len(speed), "on the grid of the slowest moment; raise standstill, or cut the recording"
    )
    return _interpolated(samples, np.interp(np.arange(count) * step, path, time))


def _interpolated(samples: NDArray[np.float32], positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the band-limited signal through ``samples`` at ``positions`` (in samples), float64, (axis, position)."""
    if samples.shape[1] < 2:
        return np.repeat(samples.astype(np.float64), len(positions), axis=1)
    fine = resample(Signal(samples, 1.0, "1", tuple(map(str, range(len(samples))))), OVERSAMPLED)
    grid = np.arange(len(fine)) / OVERSAMPLED
    return np.asarray(scipy.interpolate.CubicSpline(grid, fine.samples.astype(np.float64), axis=1)(positions))

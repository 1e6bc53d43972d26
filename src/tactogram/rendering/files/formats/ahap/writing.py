"""Writer of AHAP: an envelope becomes continuous events, transients, and the curves that control both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import DocumentHeader
from tactogram.rendering.files.envelope import PULSE_S, STEP_S, Envelope, densified, envelope_of, thinned
from tactogram.rendering.files.formats.ahap.rules import LONGEST_EVENT_S, MOST_POINTS, SPAN
from tactogram.signal import Signal

INTENSITY_STEP, SHARPNESS_STEP = 0.01, 0.02
"""Largest deviation of a curve from the envelope."""
SHORTEST_S = 1e-5
JUMP_S = 0.001
"""Time in which a curve steps to another value, s."""
_DIGITS = 6
_CLOSE = 1e-6


@dataclass(frozen=True)
class _Window:
    """Time (s) of a transient stronger, or duller, than the vibration around it.

    Curves act on all events: here they have the constants ``intensity`` and ``sharpness`` that the transient needs, and
    the continuous event has its ``own``, so that their product and sum are the vibration's mean.
    """

    start: float
    end: float
    intensity: float
    sharpness: float
    own: tuple[float, float]


@dataclass(frozen=True, eq=False)
class _Line:
    """A control over time."""

    times: NDArray[np.float64]
    values: NDArray[np.float64]

    def __call__(self, t: NDArray[np.float64] | float) -> NDArray[np.float64]:
        return np.asarray(np.interp(t, self.times, self.values))

    def stepped(self, start: float, end: float, level: float) -> _Line:
        """Return the line with a constant between two times."""
        t = np.array([start - JUMP_S, start, end - JUMP_S, end])
        values = np.array([self(t[0]), level, level, self(end)])
        first = 0 if t[0] >= 0 else 1
        before, after = self.times < t[first], self.times > end
        return _Line(
            np.concatenate([self.times[before], t[first:], self.times[after]]),
            np.concatenate([self.values[before], values[first:], self.values[after]]),
        )


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal of one axis whose envelope is within 0 to 1."""
    _check_length(signal.seconds)
    # The analysis leaves no transient much stronger than the envelope.
    return _document(envelope_of(signal), header, held=True)


def encode_envelope(envelope: Envelope, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of an envelope from 0 s to its end, within 0 to 1."""
    _check_length(envelope.seconds)
    return _document(envelope, header, held=False)


def _document(envelope: Envelope, header: DocumentHeader, *, held: bool) -> dict[str, Any]:
    """Return the document; all transients are ``held`` by the curves of the vibration, or get windows of their own."""
    # The root of a line is not a line.
    times = densified(envelope.times)
    amplitude = np.interp(times, envelope.times, envelope.amplitude)
    intensity = _Line(times, np.sqrt(np.clip(amplitude, 0, 1)))
    sharpness = _Line(envelope.frequency_times, SPAN.share(envelope.frequency))
    windows = [] if held else _windows(envelope, intensity, sharpness)
    continuous = _continuous_events(envelope, windows, intensity)
    entries = list(continuous)
    if continuous:
        for window in windows:
            intensity = intensity.stepped(window.start, window.end, window.intensity)
            sharpness = sharpness.stepped(window.start, window.end, window.sharpness)
        entries += _curves("HapticIntensityControl", intensity, INTENSITY_STEP)
        entries += _curves("HapticSharpnessControl", sharpness, SHARPNESS_STEP)
    for pulse in envelope.pulses:
        control = float(intensity(pulse.time)) if continuous else 1.0
        above = float(sharpness(pulse.time)) if continuous else 0.0
        strength = np.sqrt(pulse.amplitude) / control if control > 0 else 1.0
        own = float(SPAN.share(pulse.frequency)) - above
        entries.append(_event(pulse.time, "HapticTransient", min(1.0, strength), max(0.0, own)))
    return {
        "Version": 1.0,
        "Metadata": {"Project": "tactogram", "Description": header.description},
        "Pattern": sorted(entries, key=lambda entry: float(next(iter(entry.values()))["Time"])),
    }


def _check_length(seconds: float) -> None:
    if seconds < SHORTEST_S:
        raise ParameterError(f"AHAP needs at least {SHORTEST_S:g} s, got {seconds:g} s")


def _windows(envelope: Envelope, intensity: _Line, sharpness: _Line) -> list[_Window]:
    """Return the times of the transients that the curves of the vibration alone could not hold."""
    windows = []
    starts = [*(pulse.time for pulse in envelope.pulses), envelope.seconds]
    for pulse, following in zip(envelope.pulses, starts[1:], strict=True):
        end = min(pulse.time + PULSE_S, following, envelope.seconds)
        strong, sharp = float(np.sqrt(pulse.amplitude)), float(SPAN.share(pulse.frequency))
        held = strong <= intensity(pulse.time) + _CLOSE and sharp >= sharpness(pulse.time) - _CLOSE
        if held or end - pulse.time <= 2 * JUMP_S:
            continue
        inside = np.linspace(pulse.time, end, 9)
        level, tone = intensity(inside), float(sharpness(inside).mean())
        control, dull = max(strong, float(level.max())), min(sharp, tone)
        own = (float(np.sqrt(np.mean(level**2))) / control if control else 0.0, tone - dull)
        windows.append(_Window(pulse.time, end, control, dull, own))
    return windows


def _continuous_events(envelope: Envelope, windows: list[_Window], intensity: _Line) -> list[dict[str, Any]]:
    """Return the events that vibrate: everything between the windows, and what vibrates within them."""
    pieces, last = [], 0.0
    for window in windows:
        pieces += [(last, window.start, (1.0, 0.0)), (window.start, window.end, window.own)]
        last = window.end
    pieces.append((last, envelope.seconds, (1.0, 0.0)))
    heard = [
        (start, end, own)
        for start, end, own in pieces
        if own[0] > 0 and intensity(np.linspace(start, end, 1 + int((end - start) / STEP_S) + 1)).max() > 0
    ]
    if not heard and not envelope.pulses:
        heard = [(0.0, envelope.seconds, (1.0, 0.0))]
    return [
        _event(at, "HapticContinuous", *own, duration=min(LONGEST_EVENT_S, end - at))
        for start, end, own in heard
        for at in np.arange(start, end, LONGEST_EVENT_S)
        if end - at >= SHORTEST_S
    ]


def _event(
    time: float, kind: str, intensity: float, sharpness: float, *, duration: float | None = None
) -> dict[str, Any]:
    parameters = [("HapticIntensity", intensity), ("HapticSharpness", sharpness)]
    event: dict[str, Any] = {
        "Time": round(float(time), _DIGITS),
        "EventType": kind,
        "EventParameters": [
            {"ParameterID": name, "ParameterValue": round(float(value), 4)} for name, value in parameters
        ],
    }
    return {"Event": event | ({} if duration is None else {"EventDuration": round(duration, _DIGITS)})}


def _curves(name: str, line: _Line, tolerance: float) -> list[dict[str, Any]]:
    """Return curves of at most `MOST_POINTS`; each begins where the previous one ended."""
    times, values = line.times, line.values
    chosen = thinned(times, values, tolerance)
    curves = []
    for first in range(0, max(1, len(chosen) - 1), MOST_POINTS - 1):
        indices = chosen[first : first + MOST_POINTS]
        start = round(float(times[indices[0]]), _DIGITS)
        points = [
            {
                "Time": round(max(0.0, float(times[i]) - start), _DIGITS),
                "ParameterValue": round(float(values[i]), 4),
            }
            for i in indices
        ]
        curve = {"ParameterID": name, "Time": start, "ParameterCurveControlPoints": points}
        curves.append({"ParameterCurve": curve})
    return curves

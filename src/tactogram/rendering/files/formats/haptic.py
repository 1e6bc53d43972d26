"""``.haptic`` version 1, Meta's (formerly Lofelt's) parametric clips: amplitude, frequency, emphasis.

The rules are the ten of `haptic_data` (facebook/meta-haptics-sdk, MIT), in strict mode. The frequencies of 0 and 1
depend on the device: 55 to 200 Hz on Quest controllers (its profile in that SDK).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import (
    MOST_ENTRIES,
    DecodedDocument,
    DocumentHeader,
    DocumentPart,
    has_key,
    problems_of,
)
from tactogram.rendering.files.envelope import (
    Envelope,
    FrequencySpan,
    Pulse,
    carrier,
    densified,
    envelope_of,
    thinned,
)
from tactogram.rendering.files.format import HapticFormat
from tactogram.signal import Signal

SPAN = FrequencySpan(55.0, 200.0)
AMPLITUDE_STEP, FREQUENCY_STEP = 0.005, 0.02
"""Largest deviation of the file's lines from the envelope."""
SHORTEST_S = 1e-5
_DIGITS = 6


class Emphasis(DocumentPart):
    """Emphasis of a breakpoint."""

    amplitude: float
    frequency: float


class AmplitudePoint(DocumentPart):
    """Breakpoint of the amplitude."""

    time: float
    amplitude: float
    emphasis: Emphasis | None = None


class FrequencyPoint(DocumentPart):
    """Breakpoint of the frequency."""

    time: float
    frequency: float


class Envelopes(DocumentPart):
    """Both envelopes."""

    amplitude: tuple[AmplitudePoint, ...] = Field(max_length=MOST_ENTRIES, strict=False)
    frequency: tuple[FrequencyPoint, ...] | None = Field(None, max_length=MOST_ENTRIES, strict=False)


class Continuous(DocumentPart):
    """The only kind of signal."""

    envelopes: Envelopes


class Signals(DocumentPart):
    """Signals of a clip."""

    continuous: Continuous


class Version(DocumentPart):
    """Version of the format."""

    major: int = Field(ge=1, le=1)
    minor: int = Field(ge=0)
    patch: int = Field(ge=0)


class Metadata(DocumentPart):
    """Origin of a clip."""

    editor: str = ""
    author: str = ""
    source: str = ""
    project: str = ""
    tags: tuple[str, ...] = Field((), strict=False)
    description: str = ""


class Clip(DocumentPart):
    """A complete file."""

    version: Version
    metadata: Metadata = Metadata(tags=())
    signals: Signals


def validate(document: Any) -> list[str]:
    """Return the problems of a document, a line each; empty if it is valid."""
    if problems := problems_of(Clip, document):
        return problems
    envelopes = Clip.model_validate(document).signals.continuous.envelopes
    return [*_amplitude_problems(envelopes.amplitude), *_frequency_problems(envelopes)]


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal of one axis whose envelope is within 0 to 1."""
    if signal.seconds < SHORTEST_S:
        raise ParameterError(f".haptic needs at least {SHORTEST_S:g} s, got {signal.seconds:g} s")
    return encode_envelope(envelope_of(signal), header)


def encode_envelope(envelope: Envelope, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of an envelope from 0 s to its end, within 0 to 1."""
    chosen = thinned(envelope.times, envelope.amplitude, AMPLITUDE_STEP)
    times, values = envelope.times[chosen], envelope.amplitude[chosen]
    pulses = {round(pulse.time, _DIGITS): pulse for pulse in envelope.pulses}
    points = []
    for time in sorted({*(round(float(t), _DIGITS) for t in times), *pulses}):
        amplitude = round(min(1.0, float(np.interp(time, times, values))), 4)
        point: dict[str, Any] = {"time": time, "amplitude": amplitude}
        if (pulse := pulses.get(time)) is not None:
            point["emphasis"] = {
                "amplitude": round(min(1.0, amplitude + pulse.amplitude), 4),
                "frequency": round(float(SPAN.share(pulse.frequency)), 4),
            }
        points.append(point)
    # A line that leaves the span has a bend there.
    at = densified(envelope.frequency_times)
    frequency = SPAN.share(np.interp(at, envelope.frequency_times, envelope.frequency))
    frequency_points = [
        {"time": round(float(at[i]), _DIGITS), "frequency": round(float(frequency[i]), 4)}
        for i in thinned(at, frequency, FREQUENCY_STEP)
    ]
    return {
        "version": {"major": 1, "minor": 0, "patch": 0},
        "metadata": Metadata(editor="tactogram", tags=(), description=header.description).model_dump(
            mode="json"
        ),
        "signals": {"continuous": {"envelopes": {"amplitude": points, "frequency": frequency_points}}},
    }


def decode(document: Any, rate: float | None = None) -> DecodedDocument:
    """Return the signal of a valid document, as a carrier of `SPAN`'s frequencies at ``rate``.

    An emphasis adds its excess over the envelope. Without frequencies the middle of the span is used.
    """
    clip = Clip.model_validate(document)
    envelopes = clip.signals.continuous.envelopes
    times = np.array([point.time for point in envelopes.amplitude])
    pulses = tuple(
        Pulse(p.time, p.emphasis.amplitude - p.amplitude, float(SPAN.hz(p.emphasis.frequency)))
        for p in envelopes.amplitude
        if p.emphasis is not None
    )
    frequency = envelopes.frequency or (FrequencyPoint(time=0.0, frequency=0.5),)
    envelope = Envelope(
        float(times[-1]),
        times,
        np.array([point.amplitude for point in envelopes.amplitude]),
        np.array([point.time for point in frequency]),
        SPAN.hz(np.array([point.frequency for point in frequency])),
        pulses,
    )
    facts = {
        "carrier_hz": [SPAN.low, SPAN.high],
        "carrier_from": "frequency"
        if envelopes.frequency
        else "nothing in the file: the middle of the device's span",
    }
    return DecodedDocument(carrier(envelope, rate), clip.metadata.description, facts, envelope)


def _amplitude_problems(points: tuple[AmplitudePoint, ...]) -> list[str]:
    problems, last = [], 0.0
    for i, point in enumerate(points):
        where = f"amplitude breakpoint {i} at {point.time:g} s"
        problems += _share_problems(f"{where}:", amplitude=point.amplitude)
        if point.time < last:
            problems.append(f"{where}: out of order, after {last:g} s")
        last = point.time
        if (emphasis := point.emphasis) is None:
            continue
        problems += _share_problems(
            f"{where}: emphasis", amplitude=emphasis.amplitude, frequency=emphasis.frequency
        )
        if emphasis.amplitude < point.amplitude:
            problems.append(
                f"{where}: emphasis amplitude must be at least the envelope's {point.amplitude:g}, "
                f"got {emphasis.amplitude:g}"
            )
    if len(points) < 2:
        problems.append(f"the amplitude envelope must have at least two breakpoints, got {len(points)}")
    elif not points[-1].time - points[0].time > 0:
        problems.append("the amplitude envelope must last longer than 0 s")
    return problems


def _frequency_problems(envelopes: Envelopes) -> list[str]:
    problems, last = [], 0.0
    times = [point.time for point in envelopes.amplitude]
    for i, point in enumerate(envelopes.frequency or ()):
        where = f"frequency breakpoint {i} at {point.time:g} s"
        problems += _share_problems(f"{where}:", frequency=point.frequency)
        if point.time < last:
            problems.append(f"{where}: out of order, after {last:g} s")
        last = point.time
        if times and not times[0] <= point.time <= times[-1]:
            problems.append(f"{where}: outside the amplitude envelope, {times[0]:g} to {times[-1]:g} s")
    return problems


def _share_problems(where: str, **values: float) -> list[str]:
    return [
        f"{where} {name} must be 0 to 1, got {value:g}"
        for name, value in values.items()
        if not 0 <= value <= 1
    ]


FORMAT = HapticFormat(
    name="haptic",
    title=".haptic v1 (Meta)",
    suffix=".haptic",
    holds="envelope",
    encode=encode,
    encode_envelope=encode_envelope,
    decode=decode,
    validate=validate,
    recognise=has_key("signals"),
)

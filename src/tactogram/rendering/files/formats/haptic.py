"""``.haptic`` version 1, Meta's (formerly Lofelt's) parametric clips: amplitude, frequency, emphasis.

What is written keeps the ten rules of `haptic_data` (facebook/meta-haptics-sdk, MIT) in strict mode; clips that its own
libraries ship break some of them. The frequencies of 0 and 1 depend on the device: 55 to 200 Hz on Quest controllers
(its profile in that SDK).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, has_key, in_order
from tactogram.rendering.files.events import (
    PULSE_S,
    Events,
    FrequencySpan,
    Part,
    Transient,
    densified,
    thinned,
)
from tactogram.rendering.files.format import HapticFormat

SPAN = FrequencySpan(55.0, 200.0)
AMPLITUDE_STEP, FREQUENCY_STEP = 0.005, 0.02
"""Largest deviation of the file's lines from the vibration."""
SHORTEST_S = 1e-5
_DIGITS = 6


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1.

    A transient is an emphasis: as strong as the vibration, at least. Of two at the same time the stronger counts.
    """
    ends = [one.time + PULSE_S for one in events.transients[-1:] if one.time >= events.seconds]
    seconds = round(max([events.seconds, *ends]), _DIGITS)
    if seconds < SHORTEST_S:
        raise ParameterError(f".haptic needs at least {SHORTEST_S:g} s, got {events.seconds:g} s")
    span = events.span or SPAN
    whole = events.joined.within(0.0, seconds)
    chosen = thinned(whole.times, whole.amplitude, AMPLITUDE_STEP)
    taps = {round(one.time, _DIGITS): one for one in sorted(events.transients, key=lambda one: one.amplitude)}
    times = {*(round(time, _DIGITS) for time in whole.times[chosen].tolist()), *taps}
    points = []
    for time in sorted(times):
        amplitude = round(min(1.0, float(np.interp(time, whole.times[chosen], whole.amplitude[chosen]))), 4)
        point: dict[str, Any] = {"time": time, "amplitude": amplitude}
        if tap := taps.get(time):
            point["emphasis"] = {
                "amplitude": round(min(1.0, max(tap.amplitude, amplitude)), 4),
                "frequency": round(float(span.share(tap.frequency)), 4),
            }
        points.append(point)
    # A line that leaves the span has a bend there.
    at = densified(whole.times)
    share = span.share(whole.hz(at))
    frequency = [
        {"time": round(float(at[i]), _DIGITS), "frequency": round(float(share[i]), 4)}
        for i in thinned(at, share, FREQUENCY_STEP)
    ]
    about = {"editor": "tactogram", "author": "", "source": "", "project": "", "tags": []}
    return {
        "version": {"major": 1, "minor": 0, "patch": 0},
        "metadata": about | {"description": header.description},
        "signals": {"continuous": {"envelopes": {"amplitude": points, "frequency": frequency}}},
    }


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document. Without frequencies the middle of the span is used."""
    notes, version = document.notes, document.node("version")
    if version.number("major") != 1 and version.has("major"):
        notes.problems.append(f"version.major: must be 1, got {version.value['major']!r}")
    if not (version.has("minor") and version.has("patch")):
        notes.warn("version must have a minor and a patch", done="taken as 0")
    envelopes = document.node("signals").node("continuous").node("envelopes")
    points: list[tuple[float, ...]] = []
    taps = []
    for entry in envelopes.nodes("amplitude"):
        time, amplitude = entry.number("time", None, 0.0), entry.number("amplitude", None, 0.0, 1.0)
        points.append((time, amplitude))
        if entry.has("emphasis"):
            emphasis = entry.node("emphasis")
            tap = Transient(
                time,
                emphasis.number("amplitude", None, 0.0, 1.0),
                float(SPAN.hz(emphasis.number("frequency", 0.5, 0.0, 1.0))),
            )
            taps.append(tap)
            if tap.amplitude < amplitude:
                rule = "the amplitude of an emphasis must be at least the envelope's"
                notes.warn(rule, f"{tap.amplitude:g} of {amplitude:g}")
    tones: list[tuple[float, ...]] = [
        (entry.number("time", None, 0.0), entry.number("frequency", None, 0.0, 1.0))
        for entry in envelopes.nodes("frequency", optional=True)
    ]
    notes.check()
    points = in_order(points, notes, "amplitude breakpoints")
    tones = in_order(tones, notes, "frequency breakpoints")
    if len(points) < 2:
        notes.problems.append(f"the amplitude envelope must have at least two breakpoints, got {len(points)}")
    elif not points[-1][0] > points[0][0]:
        notes.problems.append("the amplitude envelope must last longer than 0 s")
    elif tones and (tones[-1][0] > points[-1][0] or tones[0][0] < points[0][0]):
        rule = f"frequency breakpoints must be within the amplitude envelope, {points[0][0]:g} to {points[-1][0]:g} s"
        notes.warn(rule, f"{tones[-1][0]:g} s", "unused outside")
    notes.check()
    times, amplitude = np.array(points).T
    at, shares = np.array(tones or [(0.0, 0.5)]).T
    part = Part.of(times, amplitude, at, SPAN.hz(shares))
    about = document.value.get("metadata")
    text = about.get("description") if isinstance(about, dict) else None
    given = "frequency" if tones else "nothing in the file: the middle of the device's span"
    facts = {"carrier_hz": [SPAN.low, SPAN.high], "carrier_from": given}
    events = Events.of([part], taps, part.end, SPAN)
    return DecodedDocument(events, text if isinstance(text, str) else "", facts)


FORMAT = HapticFormat(
    name="haptic",
    title=".haptic v1 (Meta)",
    suffix=".haptic",
    holds="envelope",
    encode=encode,
    decode=decode,
    recognise=has_key("signals"),
)

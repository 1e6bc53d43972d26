"""``.haptic`` version 1, Meta's (formerly Lofelt's) parametric clips: amplitude, frequency, emphasis.

What is written keeps the ten rules of `haptic_data` (facebook/meta-haptics-sdk, MIT) in strict mode; clips that its own
libraries ship break some of them. The frequencies of 0 and 1 depend on the device: 55 to 200 Hz on Quest controllers
(its profile in that SDK).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactogram.rendering.files.catalogue import HapticFormat
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, has_key, in_order
from tactogram.rendering.files.events import (
    PULSE_S,
    Events,
    FrequencySpan,
    Part,
    Transient,
    bends,
    densified,
)

SPAN = FrequencySpan(55.0, 200.0)
AMPLITUDE_STEP, FREQUENCY_STEP = 0.005, 0.02
"""Largest deviation of the file's lines from the vibration."""
_DIGITS = 6


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1.

    A transient is an emphasis: as strong as the vibration, at least. Of two at the same time the stronger counts.
    """
    events.check_length(".haptic")
    ends = [last.time + PULSE_S for last in events.transients[-1:] if last.time >= events.seconds]
    span = events.span or SPAN
    whole = events.joined.within(0.0, round(max([events.seconds, *ends]), _DIGITS))
    times, strength = np.array(bends(whole.times, whole.amplitude, AMPLITUDE_STEP)).T
    taps = {round(one.time, _DIGITS): one for one in sorted(events.transients, key=lambda one: one.amplitude)}
    points = []
    for time in sorted({*np.round(times, _DIGITS).tolist(), *taps}):
        amplitude = round(min(1.0, float(np.interp(time, times, strength))), 4)
        point: dict[str, Any] = {"time": time, "amplitude": amplitude}
        if tap := taps.get(time):
            point["emphasis"] = {
                "amplitude": round(min(1.0, max(tap.amplitude, amplitude)), 4),
                "frequency": round(float(span.share(tap.frequency)), 4),
            }
        points.append(point)
    # A line that leaves the span has a bend there.
    instants = densified(whole.times)
    share = span.share(whole.hz(instants))
    frequency = [
        {"time": round(time, _DIGITS), "frequency": round(value, 4)}
        for time, value in bends(instants, share, FREQUENCY_STEP)
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
    if version.has("major") and not (version.has("minor") and version.has("patch")):
        notes.warn("version must have a minor and a patch", done="taken as 0")
    envelopes = document.node("signals").node("continuous").node("envelopes")
    points: list[tuple[float, ...]] = []
    taps = []
    for entry in envelopes.nodes("amplitude"):
        time, amplitude = entry.number("time", None, 0.0), entry.number("amplitude", None, 0.0, 1.0)
        points.append((time, amplitude))
        if entry.has("emphasis"):
            emphasis = entry.node("emphasis")
            strength = emphasis.number("amplitude", None, 0.0, 1.0)
            share = emphasis.number("frequency", 0.5, 0.0, 1.0)
            taps.append(Transient(time, strength, float(SPAN.hz(share))))
            if strength < amplitude:
                rule = "the amplitude of an emphasis must be at least the envelope's"
                notes.warn(rule, f"{strength:g} of {amplitude:g}")
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
    times, strengths = np.array(points).T
    tone_times, shares = np.array(tones or [(0.0, 0.5)]).T
    part = Part.of(times, strengths, tone_times, SPAN.hz(shares))
    source = "frequency" if tones else "nothing in the file: the middle of the device's span"
    text = document.node("metadata", optional=True).text("description")
    return DecodedDocument(Events.of([part], taps, part.end, SPAN), text, source)


FORMAT = HapticFormat(
    name="haptic",
    engine="Unity and Unreal, on Quest",
    title=".haptic v1 (Meta)",
    suffix=".haptic",
    holds="envelope",
    encode=encode,
    decode=decode,
    recognise=has_key("signals"),
)

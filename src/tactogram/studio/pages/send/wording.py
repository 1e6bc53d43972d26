"""Wording of the page Send: levels, dangers and losses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactogram.rendering.displays.catalogue import shipped
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.families import display_family

LEVELS = {
    "physical": "Physical: what comes out is the signal, in its own unit. Recordings played back so often feel weak.",
    "sensation": "Sensation: as far above the detection threshold as the signal; what the display cannot render is "
    "made up for by what it can. With a number: so many dB above the threshold.",
    "gain": "Gain: so many times the signal, output unit per unit of signal.",
    "peak": "Peak: the largest drive is this share of the limit. How strong the signal was is lost.",
}
NEEDS = {
    "gain": ("Factor", 1.0),
    "peak": ("Share of the limit, 0 to 1", 0.5),
    "sensation": ("dB above the threshold (empty: as the signal)", None),
}
LOSSES = {
    "envelope_correlation": ("Course of the strength, r", "1 is all of it"),
    "envelope_error": ("Error of the strength", "of the signal's own"),
    "level_db": ("Level, dB", "0 is the signal's"),
    "frequency_octaves": ("Frequency, octaves off", "0 is the signal's"),
    "waveform_correlation": ("Waveform, r", "an envelope has none"),
    "snr_db": ("Signal to error, dB", "an envelope has none"),
}
HOLDS = {
    "waveform": "holds the waveform, all axes",
    "envelope": "holds strength and, where it can, frequency; no waveform",
    "on and off": "holds when there is something, and nothing of how much",
}


def warnings_of(display: Display, report: Mapping[str, Any]) -> list[str]:
    """Return what may hurt somebody or break something, the worst first."""
    found = []
    if hazard := display_family(display.family).hazard:
        found.append(hazard.format(peak=report["drive"]["peak"]))
    elif display.unit == "V":
        found.append("The drive is in V at the actuator: set the amplifier before anybody touches it.")
    if display.name in shipped():
        found.append(
            "This display's numbers were not measured on a device; what comes out of yours may be stronger. Begin weak."
        )
    if report["clipped"]:
        found.append("Some of the drive was clipped: see below.")
    return found


def level_text(kind: str, value: float | None) -> str:
    """Return a level as the command line takes it."""
    return kind if value is None or kind == "physical" else f"{kind}={value:g}"

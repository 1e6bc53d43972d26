"""Wording of the page Send: levels, warnings, losses and formats."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactogram.rendering import Display, display_family, shipped

LEVELS = {
    "physical": "Physical: the output equals the signal, in its own unit. Recordings often feel weak this way.",
    "sensation": "Sensation: as far above the detection threshold as the signal; frequencies that the display cannot "
    "render are compensated by others. A number sets the level above the threshold in dB.",
    "gain": "Gain: output per unit of the signal.",
    "peak": "Peak: the largest drive is this share of the limit. The signal's own strength is lost.",
}
LEVEL_VALUES = {
    "gain": ("Factor", 1.0),
    "peak": ("Share of the limit, 0 to 1", 0.5),
    "sensation": ("dB above the threshold (empty: as the signal)", None),
}
"""Label and default of a level's number."""
LOSSES = {
    "envelope_correlation": ("Strength over time, r", "1 is perfect"),
    "envelope_error": ("Strength error", "relative to the signal's strength"),
    "level_db": ("Level, dB", "0 equals the signal"),
    "frequency_octaves": ("Frequency error, octaves", "0 equals the signal"),
    "waveform_correlation": ("Waveform, r", "none for an envelope"),
    "snr_db": ("Signal to error, dB", "none for an envelope"),
}
"""Heading and meaning of each loss."""
HOLDS = {
    "waveform": "stores the waveform of all axes",
    "envelope": "stores strength and, in some formats, frequency, but no waveform",
    "on and off": "stores when there is vibration, but not how strong it is",
}


def warnings_of(display: Display, report: Mapping[str, Any]) -> list[str]:
    """Return dangers to people or equipment, the worst first."""
    warnings = []
    if hazard := display_family(display.family).hazard:
        warnings.append(hazard.format(peak=report["drive"]["peak"]))
    elif display.unit == "V":
        warnings.append("The drive is in volts at the actuator: set the amplifier before anybody touches it.")
    if display.name in shipped():
        warnings.append(
            "This display's values were not measured on a device; yours may be stronger. Start weak."
        )
    if report["clipped"]:
        warnings.append("Part of the drive was clipped; see below.")
    return warnings


def level_text(kind: str, value: float | None) -> str:
    """Return a level in the command line's form."""
    return kind if value is None or kind == "physical" else f"{kind}={value:g}"

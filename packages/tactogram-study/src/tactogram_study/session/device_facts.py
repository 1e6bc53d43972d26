"""Device facts of a participant: pixels per mm, refresh rate, measured speeds, audio latency.

A page sends them. Invalid ones are dropped: no answer is lost because a browser sends something odd.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

FACT = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
"""Name of a fact: letters, digits and _; it ends with the unit, and after that the slot."""
MOST_FACTS = 40
LONGEST_TEXT = 200
LONGEST_LIST = 200
COLUMN = "device_"
"""Prefix of the columns of an answer's device facts."""
DESCRIPTIONS: Mapping[str, str] = {
    "px_per_mm": "CSS pixels for each mm of the screen, as calibrated",
    "calibrated": "Whether the screen was calibrated with a card held to it",
    "pixel_ratio": "Device pixels for each CSS pixel",
    "zoom": "Zoom by two fingers; only at 1 are lengths in mm as stated",
    "dark": "Whether the page was dark, as the device prefers",
    "width_px": "Width of the page, CSS pixels",
    "height_px": "Height of the page, CSS pixels",
    "touch": "Whether the screen takes touches",
    "pointer": "What was moved: touch, pen or mouse",
    "refresh_hz": "Refresh rate of the screen, Hz, as measured",
    "target_speed_mm_s": "Speed of the target as drawn, mm/s, as measured",
    "finger_speed_mm_s": "Mean speed of the finger over the area, mm/s, as measured",
    "followed_mm": "Mean distance of the finger from the target, mm, as measured",
    "audio_latency_ms": "Latency of sound that the browser states, ms",
    "audio_rate_hz": "Rate of the browser's sound, Hz",
    "sound_rate_hz": "Rate of the sound that was sent, Hz",
    "sounded_ms": "For how long it sounded, ms",
    "plays": "How often it was played",
    "full_screen": "Whether the page filled the screen",
    "area_width_mm": "Width of an area as drawn, mm",
    "area_height_mm": "Height of an area as drawn, mm",
    "areas": "Where the areas were: beside or above each other",
    "image_mm": "Side of the image as drawn, mm",
    "image_asked_mm": "Side of the image that the study asks for, mm, where the screen is too small for it",
    "vas_mm": "Length of the line as drawn, mm",
    "vas_asked_mm": "Length of the line that the study asks for, mm",
}
"""Facts that the participant pages send. The texts are part of exported BIDS folders."""


def valid_facts(device: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the valid facts: numbers, texts, booleans, lists of numbers; nested ones as ``outer_inner``."""
    facts: dict[str, Any] = {}
    for name, value in (device or {}).items():
        entries = value.items() if isinstance(value, Mapping) else [("", value)]
        for key, entry in entries:
            whole = f"{name}_{key}" if key else str(name)
            if FACT.fullmatch(whole) and len(facts) < MOST_FACTS and (valid := _valid(entry)) is not None:
                facts[whole] = valid
    return facts


def device_columns(facts: Mapping[str, Any]) -> dict[str, str]:
    """Return the facts of an answer as extra columns of its row."""
    return {f"{COLUMN}{name}": fact_text(value) for name, value in facts.items()}


def fact_text(value: Any) -> str:
    """Return a fact as the text of a cell; the numbers of a list are separated by spaces."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return " ".join(fact_text(number) for number in value)
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def fact_description(name: str) -> str:
    """Return the description of a fact; of an unknown one, that the page sent it."""
    if name in DESCRIPTIONS:
        return DESCRIPTIONS[name]
    whole, _, slot = name.rpartition("_")
    if slot.upper() in ("A", "B", "X") and whole in DESCRIPTIONS:
        return f"{DESCRIPTIONS[whole]}; of {slot.upper()}"
    return f"{name}, as the page sent it"


def _valid(value: Any) -> Any:
    if isinstance(value, bool):
        return value
    if isinstance(value, int | float):
        # Not math.isfinite: it fails for integers too large for a float. NaN and infinity are not below.
        return value if abs(value) < 1e15 else None
    if isinstance(value, str):
        text = " ".join("".join(c if c.isprintable() else " " for c in value).split())
        return text[:LONGEST_TEXT] or None
    if isinstance(value, list) and 0 < len(value) <= LONGEST_LIST:
        numbers = [_valid(number) for number in value if isinstance(number, int | float)]
        return numbers if len(numbers) == len(value) and None not in numbers else None
    return None

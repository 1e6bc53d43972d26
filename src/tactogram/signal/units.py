"""Spellings of units in files, and their conversion to the units of a Signal."""

from __future__ import annotations

import re

from tactogram.errors import UnitError
from tactogram.signal.signal import UNITS

STANDARD_GRAVITY = 9.80665
"""m/s^2 (BIPM, CGPM 1901)."""

_SPELLINGS: dict[str, tuple[str, float]] = {
    **dict.fromkeys(("m/s^2", "m/s2", "m/s**2", "m/s/s", "ms^-2", "ms-2", "m*s^-2"), ("m/s^2", 1.0)),
    "mm/s^2": ("m/s^2", 1e-3),
    "mm/s2": ("m/s^2", 1e-3),
    "g": ("m/s^2", STANDARD_GRAVITY),
    "mg": ("m/s^2", 1e-3 * STANDARD_GRAVITY),
    "m/s": ("m/s", 1.0),
    "cm/s": ("m/s", 1e-2),
    "mm/s": ("m/s", 1e-3),
    "um/s": ("m/s", 1e-6),
    "m": ("m", 1.0),
    "cm": ("m", 1e-2),
    "mm": ("m", 1e-3),
    "um": ("m", 1e-6),
    "nm": ("m", 1e-9),
    "N": ("N", 1.0),
    "mN": ("N", 1e-3),
    "V": ("V", 1.0),
    "mV": ("V", 1e-3),
    "uV": ("V", 1e-6),
    "1": ("1", 1.0),
    "-": ("1", 1.0),
    "%": ("1", 1e-2),
}

_SECONDS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def parse_unit(text: str) -> tuple[str, float]:
    """Return the unit that ``text`` spells, one of `UNITS`, and the factor that converts numbers to it.

    ``"g"`` is standard gravity, not gram; ``"µm"``, ``"m/s²"``, ``"mN"`` and the like are known.
    """
    if (unit := _SPELLINGS.get(_plain(text))) is None:
        raise UnitError(
            f"unit must be one of {', '.join(UNITS)} (or g, mm, µm, mm/s, mN, mV, %), got {text!r}"
        )
    return unit


def parse_seconds(text: str) -> float | None:
    """Return the time unit ``text`` in s (``"ms"`` is 0.001); None if it is not a time unit."""
    return _SECONDS.get(_plain(text))


def split_heading(heading: str) -> tuple[str, str | None]:
    """Return name and unit of a column headed ``name [unit]`` or ``name (unit)``; the unit is None if missing."""
    found = re.fullmatch(r"\s*(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]\s*", heading)
    return (found[1], found[2]) if found and found[1] else (heading.strip(), None)


def _plain(text: str) -> str:
    text = text.strip().replace("²", "^2").replace("µ", "u").replace("μ", "u").replace("·", "*")
    return text.replace("⁻^2", "^-2").replace(" ", "")

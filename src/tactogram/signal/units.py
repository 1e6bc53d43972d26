"""Spellings of units in files, and their conversion to the units of a Signal."""

from __future__ import annotations

import math
import re

from tactogram.errors import UnitError
from tactogram.signal.signal import UNITS

STANDARD_GRAVITY = 9.80665
"""m/s^2 (BIPM, CGPM 1901)."""

_ACCELERATION = {
    "m/s^2": 1.0,
    "mm/s^2": 1e-3,
    "cm/s^2": 1e-2,
    "ft/s^2": 0.3048,
    "in/s^2": 0.0254,
    "g": STANDARD_GRAVITY,
    "ug": 1e-6 * STANDARD_GRAVITY,
    "mg": 1e-3 * STANDARD_GRAVITY,
}
_FORCE = {
    "N": 1.0,
    "mN": 1e-3,
    "cN": 1e-2,
    "daN": 10.0,
    "kN": 1e3,
    "gf": 1e-3 * STANDARD_GRAVITY,
    "kgf": STANDARD_GRAVITY,
    "lbf": 4.4482216,
}
_SPELLINGS: dict[str, tuple[str, float]] = {
    **{name: ("m/s^2", factor) for name, factor in _ACCELERATION.items()},
    **{name: ("N", factor) for name, factor in _FORCE.items()},
    **{
        f"{name}/s": ("m/s", factor)
        for name, factor in (
            ("m", 1.0),
            ("cm", 1e-2),
            ("mm", 1e-3),
            ("um", 1e-6),
            ("in", 0.0254),
            ("ft", 0.3048),
        )
    },
    "mm/min": ("m/s", 1e-3 / 60),
    **{
        name: ("m", factor)
        for name, factor in (("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("nm", 1e-9))
    },
    **{name: ("V", factor) for name, factor in (("V", 1.0), ("mV", 1e-3), ("uV", 1e-6))},
    **{
        name: ("Pa", factor)
        for name, factor in (
            ("Pa", 1.0),
            ("hPa", 1e2),
            ("kPa", 1e3),
            ("mbar", 1e2),
            ("bar", 1e5),
            ("psi", 6894.757),
        )
    },
    **{name: ("T", factor) for name, factor in (("T", 1.0), ("mT", 1e-3), ("uT", 1e-6), ("nT", 1e-9))},
    **{name: ("T", factor) for name, factor in (("gauss", 1e-4), ("mgauss", 1e-7))},
    "rad/s": ("rad/s", 1.0),
    "mrad/s": ("rad/s", 1e-3),
    "deg/s": ("rad/s", math.radians(1)),
    "mdeg/s": ("rad/s", math.radians(1e-3)),
    "rad": ("rad", 1.0),
    "deg": ("rad", math.radians(1)),
    "1": ("1", 1.0),
    "-": ("1", 1.0),
    "%": ("1", 1e-2),
    **dict.fromkeys(("counts", "count", "lsb", "raw", "adc", "digits", "a.u.", "au", "n/a"), ("1", 1.0)),
}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Of time stamps, s."""
_SECONDS = {**TIME_UNITS, "min": 60.0, "h": 3600.0, "d": 86_400.0}

_WORDS = {
    # Whole words and plain variants, in lower case, by the spelling above.
    "m/s^2": "meters/second^2 metres/second^2 meter/second^2 mps2 mps^2 ms2 ms-2 ms^-2 m*s-2 m*s^-2 m/s2 m/s/s m/ss "
    "m_s2 meterspersecondsquared metrespersecondsquared "
    "meterpersecondsquared m/secondsquared",
    "mm/s^2": "mm/s2 mm/s/s",
    "cm/s^2": "cm/s2 gal",
    "ft/s^2": "ft/s2 fps2 fps^2",
    "in/s^2": "in/s2 ips2",
    "ug": "micro-g microg",
    "in/s": "ips",
    "g": "g's gs gn g_n g0 g_0 gee gees gravity gravities gravitys g-force standardgravity",
    "mg": "milli-g millig mgee mg's milligs milligravity",
    "m/s": "mps meterspersecond metrespersecond",
    "mm/s": "mmps millimeterspersecond millimetrespersecond",
    "m": "meter meters metre metres",
    "mm": "millimeter millimeters millimetre millimetres",
    "um": "micron microns micrometer micrometers micrometre micrometres",
    "N": "n newton newtons",
    "mN": "mn millinewton millinewtons",
    "kN": "kn kilonewton kilonewtons",
    "gf": "gram-force gramforce grams-force p pond",
    "kgf": "kp kilopond kilogram-force",
    "lbf": "lb lbs pound pounds lb-force pound-force lb_f",
    "V": "v volt volts vdc",
    "mV": "mv millivolt millivolts mvolt mvolts",
    "uV": "uv microvolt microvolts",
    "Pa": "pa pascal pascals",
    "hPa": "hpa",
    "kPa": "kpa kilopascal kilopascals",
    "uT": "ut microtesla microteslas",
    "T": "tesla",
    "gauss": "gs gauss",
    "mgauss": "milligauss mgs",
    "deg/s": "dps degps degrees/s degree/s degreespersecond degpersec °/s º/s",
    "mdeg/s": "mdps",
    "rad/s": "rps radps rads radians/s radianspersecond radian/s",
    "deg": "° º degree degrees",
    "rad": "radian radians",
    "s": "sec secs second seconds sek sekunden sekunde secondes segundos secondi 秒",
    "ms": "msec msecs millisec millis millisecond milliseconds millisekunden ミリ秒 毫秒",
    "us": "usec usecs micros microsec microsecond microseconds マイクロ秒 微秒",
    "ns": "nsec nsecs nanos nanosec nanosecs nanosecond nanoseconds ナノ秒 纳秒",
    "min": "minute minutes",
    "h": "hour hours hr hrs",
    "d": "day days",
    "1": "none unitless dimensionless",
}  # fmt: skip
_BY_WORD = {word: unit for unit, words in reversed(_WORDS.items()) for word in words.split()}


def parse_unit(text: str) -> tuple[str, float]:
    """Return the unit that ``text`` spells, one of `UNITS`, and the factor that converts numbers to it.

    ``"g"`` and ``"G"`` are standard gravity, not gram and gauss; ``"µm"``, ``"m/s²"``, ``"m/(sec^2)"``, ``"deg/s"``,
    ``"Volts"`` and the like are known, and counts: ``"g/16384"``, of which 16384 are one g.
    """
    if counts := re.fullmatch(r"(.*\S)\s*/\s*([1-9]\d+)", text):
        name, factor = parse_unit(counts[1])
        return name, factor / int(counts[2])
    plain = _plain(text)
    unit = _SPELLINGS.get(plain) or _SPELLINGS.get(_BY_WORD.get(plain.lower(), ""))
    unit = unit or {"G": ("m/s^2", STANDARD_GRAVITY), "mG": ("m/s^2", 1e-3 * STANDARD_GRAVITY)}.get(plain)
    if unit is None and plain.isupper() and plain != "NM":  # not newton metres
        unit = _SPELLINGS.get(plain.lower())
    if unit is None:
        raise UnitError(
            f"unit must be one of {', '.join(UNITS)} (or g, mm, µm, mm/s, mN, mV, deg/s, %), got {text!r}"
        )
    return unit


def parse_seconds(text: str) -> float | None:
    """Return the time unit ``text`` in s (``"ms"`` is 0.001, ``"100 ns"`` 1e-7); None if it is not a time unit."""
    plain = _plain(text)
    if found := re.fullmatch(r"[x*]?(1/)?(\d+(?:\.\d+)?)\*?([a-z]+)", plain):
        times, one = float(found[2]), parse_seconds(found[3])
        return None if one is None or times == 0 else one / times if found[1] else one * times
    return _SECONDS.get(plain, _SECONDS.get(_BY_WORD.get(plain.lower(), "")))


def split_heading(heading: str) -> tuple[str, str | None]:
    """Return name and unit of a column headed ``name [unit]`` or ``name (unit)``; the unit is None if missing."""
    found = re.fullmatch(
        r"\s*(.*?)\s*(?:\[\s*([^\[\]]*?)\s*\]|\(\s*((?:[^()]|\([^()]*\))*?)\s*\))\s*", heading
    )
    return (found[1], found[2] or found[3] or "") if found and found[1] else (heading.strip(), None)


def _plain(text: str) -> str:
    """Return a unit without blanks, brackets and other ways to write the same characters."""
    text = (
        text.strip()
        .rstrip("*")
        .translate(_CHARACTERS)
        .replace("⁻^2", "^-2")
        .replace("**", "^")
        .replace(" ", "")
    )
    text = re.sub(r"sec(?=\b|\^|\d|$)(?!ond)", "s", text) if "/" in text else text
    text = re.sub(r"/\((.*)\)", r"/\1", text).strip("[]()")
    return re.sub(r"(?<=/s)2$|(?<=/s)\^\(2\)$", "^2", text)


_CHARACTERS = str.maketrans(
    {"м": "m", "с": "s", "²": "^2", "µ": "u", "μ": "u", "·": "*", "⋅": "*", "∕": "/", "’": "'"}
)

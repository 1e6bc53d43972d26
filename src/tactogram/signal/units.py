"""Spellings of units in files, and their conversion to the units of a Signal."""

from __future__ import annotations

import math
import re

from tactogram.errors import UnitError
from tactogram.signal.signal import UNITS

STANDARD_GRAVITY = 9.80665
"""m/s^2 (BIPM, CGPM 1901)."""

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Of time stamps, s."""
_TABLE = """
[m/s^2]
m/s^2 1 meters/second^2 metres/second^2 meter/second^2 mps2 mps^2 ms2 ms-2 ms^-2 m*s-2 m*s^-2 m/s2 m/s/s m/ss m_s2
m/s^2 1 meterspersecondsquared metrespersecondsquared meterpersecondsquared m/secondsquared
mm/s^2 1e-3 mm/s2 mm/s/s
cm/s^2 1e-2 cm/s2 gal
ft/s^2 0.3048 ft/s2 fps2 fps^2
in/s^2 0.0254 in/s2 ips2
ug 1e-6*g micro-g microg
g 1*g g's gs gn g_n g0 g_0 gee gees gravity gravities gravitys g-force standardgravity
mg 1e-3*g milli-g millig mgee mg's milligs milligravity
[m/s]
in/s 0.0254 ips
m/s 1 mps meterspersecond metrespersecond
cm/s 1e-2
mm/s 1e-3 mmps millimeterspersecond millimetrespersecond
um/s 1e-6
ft/s 0.3048
mm/min 1e-3/60
[m]
m 1 meter meters metre metres
cm 1e-2
mm 1e-3 millimeter millimeters millimetre millimetres
um 1e-6 micron microns micrometer micrometers micrometre micrometres
nm 1e-9
[N]
N 1 n newton newtons
mN 1e-3 mn millinewton millinewtons
cN 1e-2
daN 10
kN 1e3 kn kilonewton kilonewtons
gf 1e-3*g gram-force gramforce grams-force p pond
kgf 1*g kp kilopond kilogram-force
lbf 4.4482216 lb lbs pound pounds lb-force pound-force lb_f
[V]
V 1 v volt volts vdc
mV 1e-3 mv millivolt millivolts mvolt mvolts
uV 1e-6 uv microvolt microvolts
[Pa]
Pa 1 pa pascal pascals
hPa 1e2 hpa
kPa 1e3 kpa kilopascal kilopascals
mbar 1e2
bar 1e5
psi 6894.757
[T]
uT 1e-6 ut microtesla microteslas
T 1 tesla
mT 1e-3
nT 1e-9
gauss 1e-4 gs gauss
mgauss 1e-7 milligauss mgs
[rad/s]
deg/s 1*deg dps degps degrees/s degree/s degreespersecond degpersec °/s º/s
mdeg/s 1e-3*deg mdps
rad/s 1 rps radps rads radians/s radianspersecond radian/s
mrad/s 1e-3
[rad]
deg 1*deg ° º degree degrees
rad 1 radian radians
[s]
s 1 sec secs second seconds sek sekunden sekunde secondes segundos secondi 秒
ms 1e-3 msec msecs millisec millis millisecond milliseconds millisekunden ミリ秒 毫秒
us 1e-6 usec usecs micros microsec microsecond microseconds マイクロ秒 微秒
ns 1e-9 nsec nsecs nanos nanosec nanosecs nanosecond nanoseconds ナノ秒 纳秒
min 60 minute minutes
h 3600 hour hours hr hrs
d 86400 day days
[1]
1 1 none unitless dimensionless
- 1
% 1e-2
counts 1
count 1
lsb 1
raw 1
adc 1
digits 1
a.u. 1
au 1
n/a 1
"""
"""By unit of a Signal, or of time: each unit, its factor, and whole words and plain variants of it, in lower case; of a
word that stands twice the first place counts."""


def _read_table() -> tuple[dict[str, tuple[str, float]], dict[str, str]]:
    """Return signal unit and factor of each unit, and the unit of each word."""
    constants = {"g": STANDARD_GRAVITY, "deg": math.radians(1)}
    units: dict[str, tuple[str, float]] = {}
    by_word: dict[str, str] = {}
    of = ""
    for unit, *rest in map(str.split, _TABLE.strip().splitlines()):
        if not rest:
            of = unit.strip("[]")
            continue
        number, _, constant = rest[0].partition("*")
        number, _, divisor = number.partition("/")
        units[unit] = of, float(number) * constants.get(constant, 1.0) / float(divisor or 1)
        for word in rest[1:]:
            by_word.setdefault(word, unit)
    return units, by_word


_UNITS, _BY_WORD = _read_table()
_SPELLINGS = {unit: found for unit, found in _UNITS.items() if found[0] != "s"}
_SECONDS = {unit: seconds for unit, (of, seconds) in _UNITS.items() if of == "s"}


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
    if match := re.fullmatch(r"[x*]?(1/)?(\d+(?:\.\d+)?)\*?([a-z]+)", plain):
        times, unit_s = float(match[2]), parse_seconds(match[3])
        return None if unit_s is None or times == 0 else unit_s / times if match[1] else unit_s * times
    return _SECONDS.get(plain, _SECONDS.get(_BY_WORD.get(plain.lower(), "")))


def split_heading(heading: str) -> tuple[str, str | None]:
    """Return name and unit of a column headed ``name [unit]`` or ``name (unit)``; the unit is None if missing."""
    match = re.fullmatch(
        r"\s*(.*?)\s*(?:\[\s*([^\[\]]*?)\s*\]|\(\s*((?:[^()]|\([^()]*\))*?)\s*\))\s*", heading
    )
    return (match[1], match[2] or match[3] or "") if match and match[1] else (heading.strip(), None)


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

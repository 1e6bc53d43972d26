"""Vocabulary of tables: names that loggers, phones and programs give to clocks, counters and quantities."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from tactogram.errors import UnitError
from tactogram.signal.units import STANDARD_GRAVITY, parse_seconds, parse_unit, split_heading

CLOCK = re.compile(
    r"t|ts|time|times|timestamp|timestamps|zeit\w*|uhrzeit|temps|tiempo|tempo|tijd|tid|czas|čas|cas|время|zaman|waktu|tempus|"
    r"時間|時刻|经过时间|时间|時間戳|시간|elapsed|elapsedtime|seconds|secs?|millis|micros|ms|us|msec|usec|epoch?|epoc|clock|ticks?|"
    r"date|datetime|datum|fecha|sampletimefine|hostname? ?timestamp|unix|utc|stamp|seconds elapsed|temps écoulé|datenum|tow"
)
"""A name in lower case, or a word of one, of a column of time stamps."""
COUNTER = re.compile(
    r"#|no|nr|num|number|n|i|id|idx|index|row|seq|sequence|count|counter|cnt|sample|samples|samplenumber|sampleno|frame|"
    r"frames|line|packet|packetcounter|packetid|record|rec|point|unnamed|messagecount|framenumber|番号|序号"
)
OTHERS = {
    "temperature": r"temp\d*|temperat\w*|thermo\w*|温度|溫度|온도",
    "humidity": r"humid\w*|rh|湿度",
    "battery": r"bat|batt\w*|vbat\w*|akku|vcc|vdd|supply",
    "light": r"light|lux|lx|illuminance|brightness|photo\w*|proximity",
    "location": r"lat|latitude|lon|lng|long|longitude|gps|alt|altitude|satellites|hdop|bearing",
    "heart rate": r"heart\w*|hr|bpm|pulse|ppg|ecg|eda|gsr|spo2",
    "magnitude": r"magnitude|norm|resultant|abs|absolute|total|gesamt\w*|betrag|sum|vector|rss|tgf|at|atotal|wt|mag "
    r"|\w*絶対\w*|\w*绝对\w*|absolue?|absoluta|assoluta|result",
    "status": r"status|state|flag|flags|marker|mark|trigger|trig|event|events|error|err|errors|crc|checksum|rssi|quality|valid|"
    r"accuracy|button|mode|gain|range|sensitivity|msgid|serial|version|device|sensor ?id|address|mac|channel ?id|crackle|"
    r"annotation|comment|comments|note|notes|label|labels|frame ?id|covariance|scale|offset|steps?|activity|trial|take|block",
}
"""Words of what is no signal of touch, by what it is."""
QUANTITIES = {
    "gravity": r"grav\w*|重力\w*",
    "linear_acceleration": r"linear\w*|lin ?acc\w*|linacc\w*|\w*useracc\w*|線形\w*|线性\w*|lineare?|linéaire",
    "acceleration": r"acc|acc\d|accel\w*|acceler\w*|accéléra\w*|acelera\w*|accelera\w*|beschl\w*|versnelling|przyspieszenie|"
    r"ускорение|加速度\w*|가속도|acl|axl|gforce|gf|imu ?acc\w*|xl|vibration ?acc\w*|base ?acc\w*",
    "angular_rate": r"gyr|gyro\w*|gyr\w*|rotation ?rate|rotationrate\w*|angular\w*|angularvelocity\w*|omega|drehrate|giroscopio|"
    r"角速度\w*|ジャイロ\w*|陀螺\w*|angvel\w*|turn ?rate",
    "magnetic_field": r"mag|magn\w*|magnetometer|magfield|compass|磁\w*",
    "orientation": r"quat\w*|rotation|roll|pitch|yaw|euler\w*|orient\w*|attitude|heading|rotvec\w*|tilt|azimuth|inclin\w*",
    "torque": r"torque\w*|moment|drehmoment\w*|couple|トルク",
    "friction": r"friction\w*|mu|cof|reibung\w*|摩擦\w*|µ|μ",
    "force": r"force\w*|forces|\w*kraft\w*|fuerza|forza|siła|сила|力|荷重|load|loadcell|fnormal|ftangential|f|fn|ft|lateral ?force|"
    r"normal ?force|fx|fy|fz|press|weight|gewicht\w*|mass|masse|poids|peso|scale|waage|hx711|tension|grip\w*|thrust",
    "velocity": r"vel|veloc\w*|speed\w*|geschwindigkeit|vitesse|速度|velocidad",
    "position": r"pos|posi\w*|disp|displ\w*|distance|weg|auslenkung|変位|位置|deplacement|déplacement|coord\w*|laser|encoder|travel",
    "sound": r"mic|mic\d|microphone|audio|sound|mikrofon|micro|音\w*|schall",
    "pressure": r"pressure|pdc|pac|druck|baro\w*|圧力",
    "voltage": r"volt\w*|voltage|spannung|tension|adc|電圧",
}
"""Words of quantities, by the stream that they become; the first that fits counts."""
UNITS_OF = {
    **dict.fromkeys(("gravity", "linear_acceleration", "acceleration"), "m/s^2"),
    "angular_rate": "rad/s", "magnetic_field": "T", "orientation": "rad", "friction": "1", "force": "N",
    "velocity": "m/s", "position": "m", "sound": "1", "pressure": "Pa", "voltage": "V",
}  # fmt: skip
"""Unit of the signal of each quantity; torque has none."""
STREAM_OF_UNIT = {
    "m/s^2": "acceleration", "m/s": "velocity", "m": "position", "N": "force", "V": "voltage", "rad/s": "angular_rate",
    "rad": "orientation", "Pa": "pressure", "T": "magnetic_field", "1": "vibration",
}  # fmt: skip
_LETTERS = {
    "a": "acceleration", "gf": "acceleration", "acc": "acceleration", "g": "angular_rate", "w": "angular_rate", "r": "",
    "m": "magnetic_field", "f": "force", "t": "torque", "q": "orientation", "v": "velocity", "p": "position", "d": "position",
    "mag": "magnetic_field", "gyr": "angular_rate", "gyro": "angular_rate", "accel": "acceleration", "grav": "gravity",
    "lin": "linear_acceleration", "pos": "position", "vel": "velocity", "b": "magnetic_field", "la": "linear_acceleration",
    "gr": "gravity", "imu": "", "ac": "acceleration", "gy": "angular_rate",
}  # fmt: skip
"""Prefix of the letter of an axis in one word: ``ax``, ``gFx``, ``accX``."""
MASSES = {"g": 1e-3, "mg": 1e-6, "kg": 1.0, "gram": 1e-3, "grams": 1e-3, "gramm": 1e-3}
"""Kilograms, whose weight is a force."""
ENVIRONMENT = ("temperature", "humidity", "battery", "light", "heart rate")
"""Those of `OTHERS` that no unit makes a signal of touch."""
_ENDINGS = ("mm_s^2", "m_s^2", "m_s2", "mps2", "ms2", "m_s", "mm_s", "deg_s", "rad_s", "dps", "mdps")  # fmt: skip
_AXIS_WORD = re.compile(rf"({'|'.join(sorted(_LETTERS, key=len, reverse=True))})(\d*)([xyz])")
_AXIS_FIRST = re.compile(r"([xyz])(acc|accel|gyr|gyro|mag|pos|vel)")
_CAMEL = re.compile(
    r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])|(?<=[a-z])(?=\d)"
    r"|(?<=[A-Za-z])(?=[\u3040-\u9fff\uac00-\ud7af])|(?<=[\u3040-\u9fff\uac00-\ud7af])(?=[A-Za-z])"
)


@dataclass(frozen=True)
class Heading:
    """A heading, by the words of the vocabulary."""

    text: str
    name: str  # without the unit
    unit: str | None  # as it is spelled
    quantity: str | None = None  # a key of `QUANTITIES`
    axis: str | None = None  # x, y or z
    sensor: str = ""  # the rest of the name, alike for the axes of one sensor
    other: str | None = None  # a key of `OTHERS`

    @property
    def words(self) -> list[str]:
        """Return the words of the name."""
        return words_of(self.name)

    @property
    def is_clock(self) -> bool:
        """Whether it names time stamps."""
        joined = " ".join(self.words)
        seconds = self.unit is not None and parse_seconds(self.unit) is not None
        named = bool(CLOCK.fullmatch(joined)) or any(
            CLOCK.fullmatch(word) for word in self.words if len(word) > 1
        )
        return (named and self.quantity is None) or (seconds and self.other is None)

    @property
    def is_counter(self) -> bool:
        """Whether it names the number of a row or packet, or nothing."""
        words = [word for word in self.words if not word.isdigit()]
        return self.quantity is None and (
            not words
            or (
                all(COUNTER.fullmatch(word) for word in words)
                or bool(COUNTER.fullmatch("".join(words)))
                or (
                    len(words) > 1
                    and bool(COUNTER.fullmatch(words[-1]))
                    and words[-1] not in ("i", "n", "no")
                )
            )
        )

    def converted(self) -> tuple[str | None, float]:
        """Return the unit of a Signal that the unit spells, and the factor to it; None if it spells none.

        ``g`` of a force is gram-force, ``G`` of a magnetometer is gauss.
        """
        unit = self.unit
        if unit is None:
            return None, 1.0
        plain = unit.strip("[]() ")
        if self.quantity == "force" and plain.lower() in MASSES:
            return "N", STANDARD_GRAVITY * MASSES[plain.lower()]
        if self.quantity == "magnetic_field" and plain in ("G", "mG", "Gs", "gauss"):
            return "T", {"m": 1e-7}.get(plain[0], 1e-4)
        try:
            return parse_unit(unit)
        except UnitError:
            return None, 1.0


def headings_of(texts: Sequence[str], units: Sequence[str | None]) -> list[Heading]:
    """Return what the headings of a table say; ``units`` may be empty."""
    return [heading(text, unit) for text, unit in zip(texts, units or (None,) * len(texts), strict=True)]


@lru_cache(maxsize=1024)
def heading(text: str, unit: str | None = None) -> Heading:
    """Return what a heading says, with the unit beside it if the file has one there."""
    plain = unicodedata.normalize(
        "NFKC", text.replace("⁻", "^-").replace("²", "^2").replace("^-^", "^-")
    ).strip()
    name, spelled = _name_and_unit(plain)
    spelled = unit or spelled
    words = words_of(name)
    if len(words) > 1 and COUNTER.fullmatch(words[-1]) and (spelled or "N").upper() == "N":
        return Heading(text, name, None, sensor=" ".join(words))
    joined = " ".join(words)
    axis, sensor, letters = _axis(words)
    other = next((kind for kind, form in OTHERS.items() if _fits(form, words, joined)), None)
    named = next((key for key, form in QUANTITIES.items() if _fits(form, words, joined)), None)
    weighed = (spelled or "").lower() in MASSES
    if (named == "voltage" and weighed) or (
        named == "friction" and (weighed or _fits(QUANTITIES["force"], words, joined))
    ):
        named = "force"  # tension in g, friction force
    quantity = letters if letters and _AXIS_WORD.fullmatch("".join(words)) else named or letters
    if quantity == "acceleration" and sensor == "gf" and spelled is None:
        spelled = "g"  # gFx: g-force
    si, _ = Heading(text, name, spelled, quantity).converted()
    if other in ENVIRONMENT and axis is None:
        return Heading(text, name, spelled, None, None, sensor, other)
    if si is not None and si != "1" and UNITS_OF.get(quantity or "", "") != si:
        quantity = (
            quantity if si == "V" and quantity in ("sound", "force", "pressure") else STREAM_OF_UNIT[si]
        )
    if other is not None and (
        axis is not None or (other != "magnitude" and quantity is not None and si not in (None, "1"))
    ):
        other = None
    if spelled is not None and parse_seconds(spelled) is not None:
        quantity = None
    return Heading(text, name, spelled, quantity, axis, sensor, other)


def _name_and_unit(text: str) -> tuple[str, str | None]:
    """Return the name in a heading and the unit in brackets, wherever these stand, or at its end."""
    for match in re.finditer(r"[\[(]\s*((?:[^()\[\]]|\([^()]*\))*?)\s*[\])]", text):
        name = f"{text[: match.start()]} {text[match.end() :]}".strip(" /,:")
        if name and _is_unit(match[1]) and not match[1].isdigit():
            return name, match[1]
    name, inside = split_heading(text)
    if inside is not None:
        known = _unit_at_end(name.rstrip(" /,:"))
        if known[1] is not None or re.search(r":|^/|[a-zA-Z]\d+/", inside):
            return known
        if not inside:
            return name.rstrip(" /,:"), None
        if re.search(r"[°%/^·]|^[a-zA-Zµμ]{1,4}\d?(?: [a-zA-Z])?$", inside) and inside.lower() not in (
            "x",
            "y",
            "z",
            "txt",
            "n",
            "r",
        ):
            return name.rstrip(" /,:"), inside
        return f"{name} {inside}", None
    return _unit_at_end(text.rstrip(" /,:"))


def words_of(name: str) -> list[str]:
    """Return the words of a name in lower case: ``accelerometerAccelerationX`` has three."""
    return [word.lower() for part in re.split(r"[\W_]+", name) for word in _CAMEL.split(part) if word]


def time_unit_of(found: Heading) -> str | None:
    """Return the unit of time that a heading names: ``Time (ms)``, ``t_us``, ``seconds elapsed``, ``millis``."""
    if found.unit is not None and parse_seconds(found.unit) is not None:
        return found.unit
    if found.words == ["sample", "time", "fine"]:  # Xsens and Movella
        return "us"
    for word in ("".join(found.words), *found.words):
        if word not in ("s", "min", "h", "d", "day") and parse_seconds(word) is not None:
            return word
    return None


def _axis(words: list[str]) -> tuple[str | None, str, str | None]:
    """Return the axis that the words name, the others, and the quantity that its letters name."""
    alone = (
        len(words) == 1 or words[:1] == ["g"] or not any(map(_AXIS_WORD.fullmatch, words))
    )  # gFx, but not L ax
    if alone and (match := _AXIS_WORD.fullmatch("".join(words))):
        return match[3], match[1] + match[2], _LETTERS[match[1]] or None
    for i, word in enumerate(words):
        if word in ("x", "y", "z") and not (i and words[i - 1] in ("quat", "quaternion", "q")):
            rest = [
                w
                for w in [*words[:i], *words[i + 1 :]]
                if w not in ("axis", "achse", "value", "as", "eje", "asse", "軸")
            ]
            prefix = _LETTERS.get(rest[0]) if len(rest) == 1 else None
            return word, " ".join(rest), prefix or None
    for i, word in enumerate(words):
        if match := _AXIS_FIRST.fullmatch(word):
            return match[1], " ".join([*words[:i], match[2], *words[i + 1 :]]), _LETTERS[match[2]]
        if match := _AXIS_WORD.fullmatch(word):
            rest = [*words[:i], match[1] + match[2], *words[i + 1 :]]
            return (
                match[3],
                " ".join(w for w in rest if w not in ("axis", "value")),
                _LETTERS[match[1]] or None,
            )
    return None, " ".join(words), None


def _fits(form: str, words: list[str], joined: str) -> bool:
    """Return whether a name or one of its words is of a kind; words of one or two letters say nothing beside others."""
    said = [word for word in words if len(word) > 2 or not word.isascii() or len(words) == 1]
    return any(re.fullmatch(form, text) for text in (joined, joined.replace(" ", ""), *said))


def _unit_at_end(name: str) -> tuple[str, str | None]:
    """Return name and unit of ``acc_x_mg``, ``t/s``, ``Time, s`` and ``Force N``."""
    name = re.sub(r" in (?=\S+$)", " ", name)
    blank, _, last = name.rpartition(" ")
    if blank and len(last) > 1 and "/" in last and _is_unit(last):
        return blank.rstrip(" ,"), last
    match = re.fullmatch(r"(.*?\S)\s*[/,]\s*([^\s/,]+|m/s\S*|\(.+\))", name)
    if match and _is_unit(match[2]) and not (match[2].isdigit() or match[2] == "-"):
        return match[1], match[2]
    lower = name.lower()
    for ending in _ENDINGS:
        if re.search(rf"[_ .-]{re.escape(ending)}$", lower):
            return name[: -len(ending) - 1], ending.replace("_", "/") if "_" in ending else ending
    head, _, last = re.sub(r"[ ._-](?=[^ ._-]*$)", "\0", name).partition("\0")
    quantity = next(
        (key for key, form in QUANTITIES.items() if _fits(form, words_of(head), " ".join(words_of(head)))),
        None,
    )
    if quantity == "force" and last.lower() in MASSES:
        return head, last
    if not last or not _is_unit(last) or last in ("-", "1", "%") or last.isdigit():
        return name, None
    quantity = quantity or _axis(words_of(head))[2]
    if parse_seconds(last) is not None:
        short = len(last) == 1
        return (
            (head, last)
            if CLOCK.fullmatch(" ".join(words_of(head)))
            or (not short and quantity is None and _axis(words_of(head))[0] is None)
            else (name, None)
        )
    alone = Heading(name, head, last, quantity).converted()[0]
    if words_of(head) in (["x"], ["y"], ["z"], ["f"]) and last in ("g", "N", "V"):
        return head, last
    fits = quantity is not None and alone in (UNITS_OF.get(quantity), "V")
    return (head, last) if fits or (quantity is None and len(last) > 1 and alone != "1") else (name, None)


def _is_unit(text: str) -> bool:
    try:
        parse_unit(text)
    except UnitError:
        return parse_seconds(text) is not None
    return True

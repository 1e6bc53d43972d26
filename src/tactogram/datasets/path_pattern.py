"""Pattern of paths: metadata in the names of folders and files, such as ``{subject}/{material}/{speed}mms/{take}``."""

from __future__ import annotations

import re
from typing import Any

from tactogram.errors import ParameterError

SPEEDS = {
    **dict.fromkeys(("mms", "mm_s", "mm-s", "mmps", "mmpers"), 1.0),
    **dict.fromkeys(("cms", "cm_s", "cm-s", "cmps"), 10.0),
    **dict.fromkeys(("ms", "m_s", "m-s", "mps"), 1e3),
}
"""Spellings of units of speed in names, which hold no slash, in mm/s."""
FORCES = {"n": 1.0, "mn": 1e-3, "g": 9.80665e-3, "gf": 9.80665e-3}
"""Spellings of units of force, in N; a name means the weight of so many grams by ``g``."""
DIRECTIONS = {"deg": 1.0, "°": 1.0}
MEASURED = {
    "speed": ("speed_mm_s", SPEEDS),
    "force": ("force_n", FORCES),
    "direction": ("direction_deg", DIRECTIONS),
}
TRIALS = ("trial", "take")
"""Names of the same field: the label ``trial``."""
TEXTS = ("material", "subject", "session", "contactor")
NUMBER = r"\d+(?:[.,p]\d+)?"
DATE = r"\d{4}-?\d\d-?\d\d(?:[T_ -]+\d\d[-:h_.]?\d\d(?:[-:m_.]?\d\d)?)?"
"""Date in a name, with or without the time of day: ``2026-01-02_10-23-45``."""
_FIELD = re.compile(r"\{(\w*)\}|\*+")


class PathPattern:
    """Pattern of the last levels of a path.

    ``{material}``, ``{subject}``, ``{session}``, ``{contactor}``, ``{take}`` or ``{trial}``, ``{speed}`` (mm/s),
    ``{force}`` (N) and ``{direction}`` (degrees, or a word) name what is there, another name a label; ``{}``, ``{_}``
    and ``*`` stand for anything, ``**`` for any number of levels of the whole path. Speeds and forces may have units,
    in the name (``4cms``, ``500mN``, ``50g``) or in the pattern (``{speed}cms``). A suffix may be omitted, case is
    ignored, and ``_`` stands for blanks, too.
    """

    def __init__(self, text: str) -> None:
        self.text, self._units = text, dict[str, float]()
        levels = text.strip("/").removesuffix(".*").split("/")
        self.levels = len(levels)
        self._with_suffix = re.search(r"\.[a-z]\w{1,4}$", levels[-1]) is not None
        self.names = tuple(
            name for level in levels for name in re.findall(r"\{(\w*)\}", level) if name not in ("", "_")
        )
        if (
            not self.names
            or len(set(self.names)) < len(self.names)
            or re.search(r"[{}]", _FIELD.sub("", text))
        ):
            raise ParameterError(
                f"path must be a pattern such as {{subject}}/{{material}}/take{{take}}, each field once, got {text!r}"
            )
        parts = [".*" if level == "**" else self._level(level) for level in levels]
        before = "" if "**" in levels else "(?:.*/)?"
        self._regex = re.compile(before + "/".join(parts), re.IGNORECASE)

    def _level(self, level: str) -> str:
        found, end = "", 0
        whole = _FIELD.fullmatch(level) is not None
        for field in _FIELD.finditer(level):
            found += _literal(level[end : field.start()])
            touching = 0 < end == field.start()  # a take beside a name begins with its first digit
            end = field.end()
            name = field[1] or "_"
            value = r"\d[^/\s_.-]*?" if touching else self._value(name, level[end:], whole=whole)
            found += "[^/]*" if name == "_" else f"(?P<{name}>{value})"
        return found + _literal(level[end:])

    def _value(self, name: str, after: str, *, whole: bool) -> str:
        """Return the expression of a field's values; of several in a name, only a material may have separators."""
        if name not in MEASURED:
            return "[^/]+" if whole else "[^/]+?" if name == "material" else rf"(?:{DATE}|[^/\s_.-]+?)"
        units = MEASURED[name][1]
        spelled = re.match(_alternatives(units) + r"(?![a-z])", after, re.IGNORECASE)
        if spelled:
            self._units[name] = units[spelled[0].lower()]
            return rf"[-+]?{NUMBER}"
        number = rf"[-+]?{NUMBER}(?:[ _]?{_alternatives(units)}(?![a-z]))?"
        return rf"{number}|[a-z]+" if name == "direction" else number

    def fields(self, path: str) -> dict[str, Any] | None:
        """Return the metadata in a path (relative, with ``/``): fields of a `Recording`; None if it does not match."""
        stem = path if self._with_suffix else re.sub(r"\.[A-Za-z]\w{1,4}$", "", path)
        match = self._regex.fullmatch(stem)
        if match is None:
            return None
        found: dict[str, Any] = {"labels": {}}
        for name, text in match.groupdict().items():
            if name in TEXTS:
                found[name] = text.strip()
            elif name in MEASURED and not text.isalpha():
                field, units = MEASURED[name]
                found[field] = measured(text, units, self._units.get(name, 1.0))
            else:
                found["labels"]["trial" if name in TRIALS else name] = text.strip()
        return found


def measured(text: str, units: dict[str, float], unit: float = 1.0) -> float:
    """Return the number in a name, such as ``0p5N`` or ``40mm_s``; ``unit`` is that of a number alone."""
    spelled = re.search(_alternatives(units) + "$", text, re.IGNORECASE)
    number = re.sub("[,pP]", ".", re.sub(rf"^([-+]?{NUMBER}).*", r"\1", text, flags=re.IGNORECASE))
    return round(float(number) * (units[spelled[0].lower()] if spelled else unit), 9)


def _literal(text: str) -> str:
    return re.escape(text).replace("_", "[_ ]+")


def _alternatives(units: dict[str, float]) -> str:
    return f"(?:{'|'.join(sorted(map(re.escape, units), key=len, reverse=True))})"

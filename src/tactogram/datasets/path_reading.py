"""Metadata in names of folders and files: a pattern, proposed from what varies, and doubts about what is a material."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from tactogram.errors import Message, ParameterError, Remedy

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
    in the name (``4cms``, ``500mN``, ``50g``) or in the pattern (``{speed}cms``); a negative speed is that of a stroke
    ``back``, the label ``way``. A suffix may be omitted, case is
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
            raise ParameterError.must(
                "path", "be a pattern such as {subject}/{material}/take{take}, each field once", text
            )
        parts = [".*" if level == "**" else self._level(level) for level in levels]
        before = "" if "**" in levels else "(?:.*/)?"
        self._regex = re.compile(before + "/".join(parts), re.IGNORECASE)

    def _level(self, level: str) -> str:
        pattern, end = "", 0
        whole = _FIELD.fullmatch(level) is not None
        for field in _FIELD.finditer(level):
            pattern += _literal(level[end : field.start()])
            touching = 0 < end == field.start()  # a take beside a name begins with its first digit
            end = field.end()
            name = field[1] or "_"
            value = r"\d[^/\s_.-]*?" if touching else self._value(name, level[end:], whole=whole)
            pattern += "[^/]*" if name == "_" else f"(?P<{name}>{value})"
        return pattern + _literal(level[end:])

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
        metadata: dict[str, Any] = {"labels": {}}
        for name, text in match.groupdict().items():
            if name in TEXTS:
                metadata[name] = text.strip()
            elif name in MEASURED and not text.isalpha():
                field, units = MEASURED[name]
                value = measured(text, units, self._units.get(name, 1.0))
                metadata[field] = abs(value) if name == "speed" else value
                if name == "speed" and value < 0:
                    metadata["labels"]["way"] = "back"
            else:
                metadata["labels"]["trial" if name in TRIALS else name] = text.strip()
        return metadata


def measured(text: str, units: dict[str, float], unit: float = 1.0) -> float:
    """Return the number in a name, such as ``0p5N`` or ``40mm_s``; ``unit`` is that of a number alone."""
    spelled = re.search(_alternatives(units) + "$", text, re.IGNORECASE)
    number = re.sub("[,pP]", ".", re.sub(rf"^([-+]?{NUMBER}).*", r"\1", text, flags=re.IGNORECASE))
    return round(float(number) * (units[spelled[0].lower()] if spelled else unit), 9)


def _literal(text: str) -> str:
    return re.escape(text).replace("_", "[_ ]+")


def _alternatives(units: dict[str, float]) -> str:
    return f"(?:{'|'.join(sorted(map(re.escape, units), key=len, reverse=True))})"


KINDS: Mapping[str, tuple[str, str]] = {
    "speed": ("speeds", rf"(?:v[ _-]?)?{NUMBER}[ _]?(?:{'|'.join(SPEEDS)})|(?:speed|vel)[ _-]?{NUMBER}"),
    "force": ("forces", rf"{NUMBER}[ _]?(?:{'|'.join(FORCES)})|(?:force|load)[ _-]?{NUMBER}"),
    "direction": (
        "directions",
        rf"{NUMBER}(?:{'|'.join(DIRECTIONS)})|left|right|up|down|forwards?|back(?:wards?)?",
    ),
    "subject": (
        "people",
        r"(?:p|s|vp|pp|pbn?|sub|subj|subject|participant|person|proband|user)[ _-]?\d+",
    ),
    "session": ("sessions", r"(?:session|ses|day|block)[ _-]?\d+"),
    "take": (
        "takes",
        r"(?:take|trial|rec|recording|run|rep|repetition|stroke|sample|file|log|measurement|scan|t|r)?"
        rf"[ _-]?\(?\d+\)?|{DATE}",
    ),
    "contactor": ("what touches them", r"finger|fingertip|pen|stylus|tool|tooltip|nail|probe|pencil"),
    "pace": ("paces", r"(?:very)?[ _-]?(?:slow|fast)|medium|normal"),
    "part": ("parts of a split", r"train(?:ing)?|test(?:ing)?|val(?:id|idation)?"),
    "": (
        "folders of files",
        r"(?:raw|multi|sensor)?[ _-]?data(?:set)?|raw|csv|wav|xlsx|recordings?|measurements?|exports?|logs?|signals?",
    ),
}
"""Fields of a pattern that names may be, each with a word for them and the expression of all of them."""
GRITS = frozenset(
    (
        *(12, 16, 20, 24, 30, 36, 40, 50, 60, 80, 100, 120, 150, 180, 220),
        *(240, 280, 320, 360, 400, 500, 600, 800, 1000, 1200, 1500, 2000),
    )
)
"""Grits of abrasives (FEPA): ``P80`` may be a person or a sandpaper."""
AS_THEY_ARE = "{material}/**"
"""Pattern of the material that is taken by default: the first folder."""


@dataclass(frozen=True)
class PathReading:
    """Reading of the paths of a folder's recordings."""

    proposed: str = ""  # pattern; empty if the paths say no more than the material
    question: str = ""  # one line about the materials; empty if they look right
    notes: tuple[str, ...] = ()  # one line each, on files that are not read


@dataclass(frozen=True)
class _Words:
    """Names at one level of the paths, or one word of each of them."""

    names: tuple[str, ...]  # in order, each once
    after: str = ""  # separator before the next word
    stated: str = ""  # field, whatever the names suggest

    @property
    def field(self) -> str | None:
        """Return the field of `KINDS` that all of them may be, else the material; None if all are one word."""
        if self.stated:
            return self.stated
        kind = next((field for field in KINDS if named_like(self.names, field)), None)
        return kind if kind is not None or len(self.names) == 1 else "material"

    def spelled(self, field: str) -> str:
        """Return a field in braces, between the letters that all names have around their numbers."""
        if field not in ("take", "speed", "force", "session"):
            return f"{{{field}}}{self.after}"
        for sign in ("", "[-+]?"):  # with signs, where some numbers have one
            matches = [re.fullmatch(rf"([^\d(]*?)({sign}{NUMBER})([^\d)]*)", name) for name in self.names]
            affixes = {
                match and (match[1], "" if match[3] and field in ("speed", "force") else match[3])
                for match in matches
            }
            if len(affixes) == 1:
                break
        before, behind = (affixes.pop() if len(affixes) == 1 else None) or ("", "")
        return f"{before}{{{field}}}{behind}".replace(" ", "_") + self.after


def read_paths(takes: Sequence[str], materials: Sequence[str]) -> PathReading:
    """Return a pattern for paths without suffix, and what to ask about the materials that the first folders name.

    Only paths of the most usual depth count. Without ``materials`` the paths have no folder.
    """
    if not takes:
        return PathReading()
    depth = Counter(name.count("/") for name in takes).most_common(1)[0][0]
    rows = [name.split("/") for name in takes if name.count("/") == depth]
    levels = [_split(column) for column in zip(*rows, strict=True)]
    asked = tuple(dict.fromkeys(materials))
    # Names of files that are one word are of takes; folders, and words beside a take, may be materials.
    deeper = [word for words in levels[1:] for word in words if len(words) > 1 or words is not levels[-1]]
    doubt = _doubt(asked, deeper, [word for words in levels[1:] for word in words])
    if not doubt and (level := _crossed(rows, levels)):
        below, *others = levels[level]
        ways = [
            "/".join(
                [
                    f"{{{first}}}",
                    *(_pattern([words], used=(first, then))[0] for words in levels[1:level]),
                    _pattern([[replace(below, stated=then), *others], *levels[level + 1 :]], used=(first,))[
                        0
                    ],
                ]
            )
            for first, then in (("subject", "material"), ("material", "condition"))
        ]
        return PathReading(
            "",
            Message(
                f"{_listed(asked)} or {_listed(below.names)}: both may be the materials",
                Remedy("state it with", "path", ways[0]),
                Remedy("", "path", ways[1]),
            ),
        )
    if not doubt:
        pattern, fields = _pattern([[_Words((), stated="material")], *levels[1:]])
        return PathReading(pattern if len(fields) > 1 and len(rows) == len(takes) else "")
    pattern, fields = _pattern(levels)
    proposed = pattern if "material" in fields else ""
    known = ("path", pattern) if proposed else ()
    beside = "" if proposed else " recordings.csv, or a folder for each material"
    if not asked:
        each = [] if proposed else [Remedy("if each file is of another,", "path", "{material}")]
        return PathReading(proposed, Message(doubt, Remedy(f"state it with{beside}", *known), *each))
    stated = Remedy(f"state what the paths name with{beside}", *known)
    kept = Remedy("keep these with", "path", AS_THEY_ARE)
    return PathReading(proposed, Message(f"{doubt}: {_listed(asked)}", stated, kept))


def named_like(names: Iterable[str], field: str) -> bool:
    """Return whether all names are of a kind in `KINDS`."""
    return all(re.fullmatch(KINDS[field][1], name, re.IGNORECASE) for name in names)


def _doubt(materials: Sequence[str], folders: Sequence[_Words], deeper: Sequence[_Words]) -> str:
    """Return what looks wrong about materials that the first folders name; empty if nothing does."""
    if not materials:
        return "no folder names the material"
    count = f"{len(materials)} material{'s' * (len(materials) != 1)}"
    varied = [words for words in folders if words.field == "material"]
    kind = next((field for field in KINDS if named_like(materials, field)), None)
    if kind is None:
        if all(re.fullmatch(rf".+[_ -]{DATE}", name) for name in materials):
            return f"{count}, named with dates"
        if len(materials) == 1 and varied:
            return f"{count}, though names below it differ ({', '.join(varied[0].names[:3])})"
        return ""
    grits = all(re.fullmatch(r"[ps][1-9]\d*", name, re.I) and int(name[1:]) in GRITS for name in materials)
    takes = any(words.field == "take" and len(words.names) > 1 for words in deeper)
    codes = takes and all(name.isdecimal() for name in materials)
    if not varied and (grits or codes or kind in ("contactor", "direction")):
        return ""
    return f"{count}, named like {KINDS[kind][0]}"


def _crossed(rows: Sequence[Sequence[str]], levels: Sequence[Sequence[_Words]]) -> int | None:
    """Return the level whose words are the same below each first folder, so that both may be materials; else None."""
    for level, words in enumerate(levels[1:], 1):
        if words[0].field != "material" or (words is levels[-1] and len(words) == 1):
            continue
        below: dict[str, set[str]] = {}
        for row in rows:
            name = row[level] if len(words) == 1 else re.sub(r"[_ -]*\d+$", "", row[level])
            below.setdefault(row[0], set()).add(name)
        if len(below) > 1 and len({frozenset(names) for names in below.values()}) == 1:
            return level
    return None


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:3]) + ", …" * (len(names) > 3)


def _split(column: Sequence[str]) -> list[_Words]:
    """Return the names of a level, or the words of which each of them consists if one of these is of a kind."""
    whole = _Words(tuple(dict.fromkeys(column)))
    if whole.field not in (None, "material"):
        return [whole]
    separators = r"([_ -]+)", r"([_ ]+)"  # without hyphens, where some are signs
    for pattern in (
        rf"(.+?)([_ -]+)({DATE})",
        *separators,
        r"(.+)([_ -]+)([^_ -]+)",
        r"(.*[^\d_ -])()(\d+)",
    ):
        if pattern in separators:
            split = [re.split(pattern, name) for name in column]
        else:
            matches = [re.fullmatch(pattern, name) for name in column]
            split = [list(match.groups()) if match else [] for match in matches]
        if len(split[0]) < 2 or len({(len(words), *words[1::2]) for words in split}) > 1:
            continue
        columns = [tuple(dict.fromkeys(words)) for words in zip(*split, strict=True)]
        between = [*(names[0].replace(" ", "_") for names in columns[1::2]), ""]
        words = [_Words(names, after) for names, after in zip(columns[::2], between, strict=True)]
        if any(word.field not in (None, "material") for word in words):
            return words
    return [whole]


def _pattern(levels: Sequence[Sequence[_Words]], *, used: Sequence[str] = ()) -> tuple[str, tuple[str, ...]]:
    """Return the pattern of the levels, and its fields, none of which is ``used``.

    Of several words that may be the material it is the first one. A number or date before another one is a session.
    """
    flat = [word for words in levels for word in words]
    fields: dict[int, str] = {}
    for position, word in enumerate(flat):
        field = word.field
        if field == "take" and any(later.field == "take" for later in flat[position + 1 :]):
            field = "session"
        if field and field not in (*fields.values(), *used):
            fields[position] = field
    texts, position = [], 0
    for words in levels:
        text = ""
        for word in words:
            text += word.spelled(fields[position]) if position in fields else "{}" + word.after
            position += 1
        texts.append("{}" if set(text) <= set("{} _-") else text)
    while len(texts) > 1 and texts[0] == "{}":
        texts.pop(0)
    return "/".join(texts), tuple(fields.values())

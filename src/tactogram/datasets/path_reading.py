"""Proposed pattern of paths, from what varies in them, and questions about materials that look like something else."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from tactogram.datasets.path_pattern import DATE, DIRECTIONS, FORCES, NUMBER, SPEEDS

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
        found = {
            match and (match[1], "" if match[3] and field in ("speed", "force") else match[3])
            for match in (re.fullmatch(rf"([^\d(]*)({NUMBER})([^\d)]*)", name) for name in self.names)
        }
        before, behind = (found.pop() if len(found) == 1 else None) or ("", "")
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
    if not doubt and (place := _crossed(rows, levels)):
        below, *others = levels[place]
        ways = [
            "/".join(
                [
                    f"{{{first}}}",
                    *(_pattern([words])[0] for words in levels[1:place]),
                    _pattern([[replace(below, stated=then), *others], *levels[place + 1 :]])[0],
                ]
            )
            for first, then in (("subject", "material"), ("material", "condition"))
        ]
        return PathReading(
            "",
            f"{_listed(asked)} or {_listed(below.names)}: both may be the materials; state it with `path={ways[0]}` or "
            f"`path={ways[1]}`",
        )
    if not doubt:
        pattern, fields = _pattern([[_Words((), stated="material")], *levels[1:]])
        return PathReading(pattern if len(fields) > 1 and len(rows) == len(takes) else "")
    pattern, fields = _pattern(levels)
    proposed = pattern if "material" in fields else ""
    remedy = f"`path={pattern}`" if proposed else "recordings.csv, or a folder for each material"
    if not asked:
        each = "" if proposed else ", or `path={material}` if each file is of another"
        return PathReading(proposed, f"{doubt}; state it with {remedy}{each}")
    return PathReading(
        proposed,
        f"{doubt}: {_listed(asked)}; state what the paths name with {remedy}, or keep these with `path={AS_THEY_ARE}`",
    )


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
    for place, words in enumerate(levels[1:], 1):
        if words[0].field != "material" or (words is levels[-1] and len(words) == 1):
            continue
        below: dict[str, set[str]] = {}
        for row in rows:
            name = row[place] if len(words) == 1 else re.sub(r"[_ -]*\d+$", "", row[place])
            below.setdefault(row[0], set()).add(name)
        if len(below) > 1 and len({frozenset(names) for names in below.values()}) == 1:
            return place
    return None


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names[:3]) + ", …" * (len(names) > 3)


def _split(column: Sequence[str]) -> list[_Words]:
    """Return the names of a level, or the words of which each of them consists if one of these is of a kind."""
    whole = _Words(tuple(dict.fromkeys(column)))
    if whole.field not in (None, "material"):
        return [whole]
    for pattern in (rf"(.+?)([_ -]+)({DATE})", None, r"(.+)([_ -]+)([^_ -]+)", r"(.*[^\d_ -])()(\d+)"):
        if pattern is None:
            split = [re.split(r"([_ -]+)", name) for name in column]
        else:
            found = [re.fullmatch(pattern, name) for name in column]
            split = [list(match.groups()) if match else [] for match in found]
        if len(split[0]) < 2 or len({(len(words), *words[1::2]) for words in split}) > 1:
            continue
        columns = [tuple(dict.fromkeys(words)) for words in zip(*split, strict=True)]
        separators = [*(names[0].replace(" ", "_") for names in columns[1::2]), ""]
        words = [_Words(names, after) for names, after in zip(columns[::2], separators, strict=True)]
        if any(word.field not in (None, "material") for word in words):
            return words
    return [whole]


def _pattern(levels: Sequence[Sequence[_Words]]) -> tuple[str, tuple[str, ...]]:
    """Return the pattern of the levels, and its fields.

    Of several words that may be the material it is the first one. A number or date before another one is a session.
    """
    flat = [word for words in levels for word in words]
    fields: dict[int, str] = {}
    for place, word in enumerate(flat):
        field = word.field
        if field == "take" and any(later.field == "take" for later in flat[place + 1 :]):
            field = "session"
        if field and field not in fields.values():
            fields[place] = field
    texts, place = [], 0
    for words in levels:
        text = ""
        for word in words:
            text += word.spelled(fields[place]) if place in fields else "{}" + word.after
            place += 1
        texts.append("{}" if set(text) <= set("{} _-") else text)
    while len(texts) > 1 and texts[0] == "{}":
        texts.pop(0)
    return "/".join(texts), tuple(fields.values())

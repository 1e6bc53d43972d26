"""Documents of haptic formats: JSON, read as players read it, with what breaks a rule noted."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError, shown
from tactogram.rendering.files.events import Events
from tactogram.signal import Signal
from tactogram.text_files import detected_text, parse_json

MOST_ENTRIES = 1_000_000
"""Most entries of a list: far more than any device plays, and read in seconds."""
MOST_SAMPLES = 2**25
"""Most samples that a document plays: more than an hour at 8 kHz."""


@dataclass(frozen=True)
class DocumentHeader:
    """Header of a document.

    ``description`` is free text, in which this package stores unit, level and metadata; ``unit`` the signal's before
    it was scaled to parts of full scale; ``modality`` one of the format's, chosen by unit by default; ``shortest_ms``
    the shortest time for which a motor can be on or off (`Display.shortest_ms`), of formats of on and off.
    """

    description: str = ""
    unit: str = "1"
    modality: str | None = None
    shortest_ms: float | None = None


@dataclass(frozen=True, eq=False)
class DecodedDocument:
    """Content of a document: events or a waveform in parts of full scale, and the header's description.

    ``carrier_from`` states where the frequencies of the events are from, ``left_out`` what is not read. ``waveform``
    returns the signal, of unit 1, at a rate (Hz) or by default its own; where it is None the events are the content.
    """

    events: Events | None
    description: str = ""
    carrier_from: str = ""
    left_out: str = ""
    modality: str = ""
    waveform: Callable[[float | None], Signal] | None = None


class Notes:
    """Faults of a document: ``problems``, which no player accepts, and warnings, which players forgive."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self._warnings: dict[str, list[Any]] = {}

    def warn(self, rule: str, got: Any = None, done: str = "") -> None:
        """Note a broken rule, the first value that breaks it, and what is done about it."""
        self._warnings.setdefault(rule, [0, got, done])[0] += 1

    def check(self) -> None:
        """Raise `DataError` if there is a problem."""
        if self.problems:
            more = f" (and {len(self.problems) - 1} more, see --check)" if len(self.problems) > 1 else ""
            raise DataError(f"{self.problems[0]}{more}")

    @property
    def warnings(self) -> list[str]:
        """A line per broken rule."""
        return [
            rule
            + ("" if got is None else f", got {got if isinstance(got, str) else shown(got)}")
            + (f": {done}" if done else "")
            + (f" ({count} times)" if count > 1 else "")
            for rule, (count, got, done) in self._warnings.items()
        ]


@dataclass(frozen=True)
class Node:
    """Part of a document at a ``place`` in it; what is missing or of another type is noted, and read as a default."""

    value: Any
    notes: Notes
    place: str = ""

    def has(self, *keys: str) -> bool:
        """Return whether any of the keys has a value."""
        return isinstance(self.value, dict) and any(self.value.get(key) is not None for key in keys)

    def node(self, key: str, *, optional: bool = False) -> Node:
        """Return the object at a key, an empty one if there is none."""
        value = self._at(key, dict, "an object", None if optional else _REQUIRED)
        return Node(value or {}, self.notes if value is not None else Notes(), self._place(key))

    def nodes(self, key: str, *, optional: bool = False) -> list[Node]:
        """Return the objects of the list at a key."""
        prefix, objects = self._place(key), []
        for number, entry in enumerate(self.list(key, optional=optional)):
            if isinstance(entry, dict):
                objects.append(Node(entry, self.notes, f"{prefix}.{number}"))
            else:
                self.notes.problems.append(f"{prefix}.{number}: must be an object, got {shown(entry)}")
        return objects

    def list(self, key: str, *, optional: bool = False) -> Sequence[Any]:
        """Return the list at a key."""
        entries: list[Any] = self._at(key, list, "a list", None if optional else _REQUIRED) or []
        if len(entries) > MOST_ENTRIES:
            self.notes.problems.append(f"{self._place(key)}: must have at most {MOST_ENTRIES} entries")
            return []
        return entries

    def numbers(self, key: str, low: float, high: float) -> Sequence[float]:
        """Return the numbers of the list at a key, within limits."""
        entries = self.list(key)
        return [Node({key: entry}, self.notes, self.place).number(key, None, low, high) for entry in entries]

    def text(self, key: str, default: str = "") -> str:
        """Return the text at a key."""
        return str(self._at(key, str, "text", default))

    def number(
        self,
        key: str,
        default: float | None = None,
        low: float = -math.inf,
        high: float = math.inf,
        *,
        name: str = "",
    ) -> float:
        """Return the number at a key, within limits as players clamp it; required if there is no default.

        It is called ``name`` where it is out of range, by default its key.
        """
        stated = self._at(key, (int, float, str), "a number", _REQUIRED if default is None else default)
        try:
            value = math.nan if isinstance(stated, bool | None) else float(stated)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            if stated is not None:
                self.notes.problems.append(f"{self._place(key)}: must be a number, got {shown(stated)}")
            return max(low, min(high, default or 0.0))
        if isinstance(stated, str):
            self.notes.warn(f"{key} must be a number", shown(stated), "read as one")
        if not low <= value <= high:
            bounds = f"{low:g} to {high:g}" if math.isfinite(high) else f"at least {low:g}"
            self.notes.warn(f"{name or key} must be {bounds}", f"{value:g}", "clamped")
        return float(max(low, min(high, value)))

    def _place(self, key: str) -> str:
        return f"{self.place}.{key}" if self.place else key

    def _at(self, key: str, kind: Any, name: str, default: Any) -> Any:
        value = self.value.get(key) if isinstance(self.value, dict) else None
        if value is None:
            if default is _REQUIRED:
                self.notes.problems.append(f"{self._place(key)}: is required")
                return None
            return default
        if isinstance(value, kind):
            return value
        self.notes.problems.append(f"{self._place(key)}: must be {name}, got {shown(value)}")
        return None


_REQUIRED = object()


def in_order(entries: Sequence[tuple[float, ...]], notes: Notes, name: str) -> list[tuple[float, ...]]:
    """Return entries in order of time, their first value."""
    ready = sorted(entries, key=lambda entry: entry[0])
    if ready != list(entries):
        notes.warn(f"{name} must be in order of time", done="sorted")
    return ready


def parse(text: bytes, where: Path | str) -> Any:
    """Return the content of a JSON text in UTF-8 or UTF-16.

    Raises `DataError` if it is not JSON, contains NaN, infinity or integers of more than 64 bits, or is nested too
    deep.
    """
    return parse_json(detected_text(text, where)[0], where, finite=True)


def without_commas_at_ends(text: bytes) -> bytes:
    """Return a JSON text without the commas before the end of a list or an object; strings stay as they are."""
    if not re.search(rb",\s*[\]}]", text):
        return text
    return re.sub(rb'("(?:[^"\\]|\\.)*")|,(?=\s*[\]}])', lambda found: found[1] or b"", text)


def sample_count(seconds: float, rate: float) -> int:
    """Return the number of samples that a document plays; `ParameterError` if it is above `MOST_SAMPLES`."""
    count = seconds * rate
    if not count <= MOST_SAMPLES:
        raise ParameterError(
            f"{seconds:g} s at {rate:g} Hz are more than {MOST_SAMPLES} samples; cut the file, or give a lower rate"
        )
    return round(count)


def encoded(document: Any) -> bytes:
    """Return a document as one compact line of JSON in ASCII."""
    return (json.dumps(document, separators=(",", ":"), allow_nan=False) + "\n").encode("ascii")


def has_key(key: str) -> Callable[[Any], bool]:
    """Return a function that checks whether a document is an object with ``key``."""
    return lambda document: isinstance(document, dict) and key in document

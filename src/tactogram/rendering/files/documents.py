"""Documents of haptic formats: JSON, its validation, and the header beside the signal."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel, ConfigDict, ValidationError

from tactogram.errors import ParameterError, shown
from tactogram.signal import Signal
from tactogram.text_files import decode_text, parse_json

if TYPE_CHECKING:
    from tactogram.rendering.files.envelope import Envelope

MOST_ENTRIES = 1_000_000
"""Most entries of a list of events: far more than any device plays, and read in a second or two."""
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
    """Content of a document: a signal of unit 1 (parts of full scale), the header's description, and facts.

    The facts state the assumed carrier and what was left out. ``envelope`` is that of the signal where the document
    holds one.
    """

    signal: Signal
    description: str = ""
    facts: dict[str, Any] = field(default_factory=dict)
    envelope: Envelope | None = None


class DocumentPart(BaseModel):
    """Part of a document: frozen, strictly typed, finite numbers; unknown keys are ignored."""

    model_config = ConfigDict(frozen=True, strict=True, extra="ignore", allow_inf_nan=False)


def parse(text: bytes, where: Path | str) -> Any:
    """Return the content of a JSON text.

    Raises `DataError` if it is not JSON in UTF-8, contains NaN, infinity or integers of more than 64 bits, or is
    nested too deep.
    """
    return parse_json(decode_text(text, where), where, finite=True)


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


def problems_of(kind: type[BaseModel], document: Any) -> list[str]:
    """Return what prevents ``document`` from being read as a ``kind``; empty if it is valid."""
    try:
        kind.model_validate(document)
    except ValidationError as error:
        return [_line(dict(entry)) for entry in error.errors(include_url=False)]
    return []


def _line(entry: dict[str, Any]) -> str:
    place = ".".join(str(part) for part in entry["loc"]) or "document"
    message = entry["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    if entry["type"] == "missing":
        return f"{place}: is required"
    return f"{place}: {message}, got {shown(entry['input'])}"

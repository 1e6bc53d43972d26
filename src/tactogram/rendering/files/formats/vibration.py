"""Pattern of `navigator.vibrate` (W3C Vibration API, Recommendation 2016) as JSON: on, off, on … in integral ms.

Browsers limit the length: Chromium takes 99 entries of at most 10,000 ms (its VibrationController) and silently drops
the rest. A bare list can be read, too.
"""

from __future__ import annotations

import math
from functools import partial
from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.files.documents import (
    DecodedDocument,
    DocumentHeader,
    DocumentPart,
    has_key,
    problems_of,
)
from tactogram.rendering.files.envelope import PHONE_HZ, carrier, envelope_of, stepped_envelope
from tactogram.rendering.files.format import HapticFormat
from tactogram.signal import Signal

MOST_ENTRIES = 99
LONGEST_MS = 10_000
SHARE = 0.25
"""On where the envelope is above this share of its peak. A choice: half would lose fading vibrations."""
MOTOR = "phone-on-off"
"""Display whose ``shortest_ms`` holds where none is given: shorter pauses are filled and shorter pulses extended."""


class Vibration(DocumentPart):
    """A complete file."""

    format: Literal["w3c-vibration"] = "w3c-vibration"
    pattern: tuple[Annotated[int, Field(ge=0, le=LONGEST_MS)], ...] = Field(
        min_length=1, max_length=MOST_ENTRIES, strict=False
    )
    description: str = ""

    @model_validator(mode="before")
    @classmethod
    def _from_list(cls, document: Any) -> Any:
        return {"pattern": document} if isinstance(document, list) else document

    @model_validator(mode="after")
    def _vibrates(self) -> Vibration:
        if not any(self.pattern[::2]):
            raise ValueError("at least one of the entries that vibrate (1st, 3rd …) must be above 0 ms")
        return self


validate = partial(problems_of, Vibration)


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal of one axis: on where it is strong.

    Pulses and pauses are at least the header's ``shortest_ms``, so that a shorter signal becomes one pulse. If there
    are too many entries, the shortest pauses are filled. Raises `ParameterError` if it is shorter than 1 ms,
    silent, or longer than a pattern can be.
    """
    length = round(1e3 * signal.seconds)
    if length < 1:
        raise ParameterError(f"a vibration pattern needs at least 1 ms, got {signal.seconds:g} s")
    envelope = envelope_of(signal, pulses=False)
    strength = np.interp((np.arange(length) + 0.5) / 1e3, envelope.times, envelope.amplitude)
    if strength.max() == 0:
        raise ParameterError("the signal is silent: a vibration pattern cannot be empty")
    on = strength >= SHARE * strength.max()
    shortest = math.ceil(header.shortest_ms or open_display(MOTOR).shortest_ms or 1)
    on = np.pad(on, (0, max(0, shortest - length)))
    pattern = _entries(_cleaned(on, shortest))
    while len(pattern) > MOST_ENTRIES:
        shortest *= 2
        if shortest > length:
            raise ParameterError(
                f"a vibration pattern holds {MOST_ENTRIES} entries of {LONGEST_MS} ms, {length} ms do not fit; cut it"
            )
        pattern = _entries(_cleaned(on, shortest))
    return {"format": "w3c-vibration", "pattern": pattern, "description": header.description}


def decode(document: Any, rate: float | None = None) -> DecodedDocument:
    """Return the signal of a valid document, as a carrier of `PHONE_HZ` at ``rate``."""
    vibration = Vibration.model_validate(document)
    # W3C: the last entry of an even number of entries is ignored, since it does not vibrate.
    pattern = vibration.pattern[: len(vibration.pattern) - (len(vibration.pattern) + 1) % 2]
    edges = np.concatenate([[0], np.cumsum(pattern)]) / 1e3
    strength = np.array([1.0, 0.0] * (len(pattern) // 2) + [1.0])
    facts = {"carrier_hz": [PHONE_HZ], "carrier_from": "nothing in the file: a phone's usual"}
    envelope = stepped_envelope(edges, strength, PHONE_HZ)
    return DecodedDocument(carrier(envelope, rate), vibration.description, facts, envelope)


def _cleaned(on: NDArray[np.bool_], shortest: int) -> NDArray[np.bool_]:
    """Return ``on``, a value per ms, without shorter pauses, and with shorter pulses lengthened."""
    cleaned = _filled(on, shortest)
    for start, stop, value in _runs(cleaned):
        if value and stop - start < shortest:
            first = min(start, max(0, len(on) - shortest))
            cleaned[first : first + shortest] = True
    # A lengthened pulse may leave a short pause.
    return _filled(cleaned, shortest)


def _filled(on: NDArray[np.bool_], shortest: int) -> NDArray[np.bool_]:
    """Return ``on`` with shorter pauses between pulses filled."""
    filled = on.copy()
    for start, stop, value in _runs(on):
        if not value and stop - start < shortest and start > 0 and stop < len(on):
            filled[start:stop] = True
    return filled


def _runs(on: NDArray[np.bool_]) -> list[tuple[int, int, bool]]:
    edges = [0, *(np.flatnonzero(np.diff(on)) + 1).tolist(), len(on)]
    return [(a, b, bool(on[a])) for a, b in pairwise(edges)]


def _entries(on: NDArray[np.bool_]) -> list[int]:
    """Return on, off, on … in ms, ending on; entries longer than `LONGEST_MS` are split by entries of 0."""
    entries: list[int] = []
    for start, stop, value in _runs(on):
        if not entries and not value:
            entries.append(0)
        rest = stop - start
        while rest > LONGEST_MS:
            entries += [LONGEST_MS, 0]
            rest -= LONGEST_MS
        entries.append(rest)
    while len(entries) % 2 == 0 or entries[-1] == 0:
        entries.pop()
    return entries


FORMAT = HapticFormat(
    name="vibration",
    title="W3C vibration pattern",
    suffix=".json",
    holds="on and off",
    encode=encode,
    decode=decode,
    validate=validate,
    instead="the phone's envelope (android_envelope, or android before Android 16)",
    recognise=lambda document: isinstance(document, list) or has_key("pattern")(document),
)

"""Pattern of `navigator.vibrate` (W3C Vibration API, Recommendation 2016) as JSON: on, off, on … in integral ms.

Browsers limit the length: Chromium takes 99 entries of at most 10,000 ms (its VibrationController) and silently drops
the rest. A bare list or number can be read, too.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.files.catalogue import HapticFormat
from tactogram.rendering.files.control_points import TAP_MS, StepRules, span_ms
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, has_key, sample_count
from tactogram.rendering.files.events import FROM_PHONE, PHONE_HZ, Events

MOST_ENTRIES = 99
LONGEST_MS = 10_000
SHARE = 0.25
"""On where the vibration is above this share of its peak. A choice: half would lose fading vibrations."""
MOTOR = "phone-on-off"
"""Display whose ``shortest_ms`` holds where none is given: shorter pauses are filled and shorter pulses extended."""
STEPS = StepRules(step_ms=1, pulse_ms=0, gap_ms=0, tap_ms=TAP_MS, levels=1)
"""How a pattern is read: a short pulse is a transient."""


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events: on where the vibration is strong, and for each transient.

    Pulses and pauses are at least the header's ``shortest_ms``, so that shorter events become one pulse. If there
    are too many entries, the shortest pauses are filled. Raises `ParameterError` if the events last less than 1 ms,
    are silent, or longer than a pattern can be.
    """
    sample_count(events.seconds, 1e3)
    length = round(1e3 * events.seconds)
    if length < 1:
        raise ParameterError(f"a vibration pattern needs at least 1 ms, got {events.seconds:g} s")
    if events.peak == 0:
        raise ParameterError("the signal is silent: a vibration pattern cannot be empty")
    shortest = math.ceil(header.shortest_ms or open_display(MOTOR).shortest_ms or 1)
    taps = [span_ms(tap, shortest, shortest) for tap in events.transients]
    whole = events.joined
    strength = whole.at(np.arange(0.5, max([length, shortest, *(end for _, end in taps)])) / 1e3)
    on = (strength >= SHARE * whole.peak) & (strength > 0)
    for start, end in taps:
        on[start:end] = True
    while len(pattern := _entries(_cleaned(on, shortest))) > MOST_ENTRIES:
        shortest *= 2
        if shortest > len(on):
            raise ParameterError(
                f"a vibration pattern holds {MOST_ENTRIES} entries of {LONGEST_MS} ms, {length} ms do not fit; cut it"
            )
    return {"format": "w3c-vibration", "pattern": pattern, "description": header.description}


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document, at `PHONE_HZ`."""
    notes = document.notes
    bare = [document.value] if isinstance(document.value, int | float) else document.value
    document = Node({"pattern": bare}, notes) if isinstance(bare, list) else document
    pattern = list(document.numbers("pattern", 0, math.inf))
    if not any(pattern[::2]):
        notes.problems.append(
            "pattern: at least one of the entries that vibrate (1st, 3rd …) must be above 0 ms"
        )
    notes.check()
    if len(pattern) > MOST_ENTRIES:
        notes.warn(
            f"pattern must have at most {MOST_ENTRIES} entries", len(pattern), "Chromium drops the rest"
        )
    if longest := [entry for entry in pattern if entry > LONGEST_MS]:
        notes.warn(f"an entry must be at most {LONGEST_MS} ms", longest[0], "Chromium shortens it")
    # W3C: the last entry of an even number of entries is ignored, since it does not vibrate.
    pattern = pattern[: len(pattern) - (len(pattern) + 1) % 2]
    strength = np.array([1.0, 0.0] * len(pattern))[: len(pattern)]
    events = STEPS.read(np.append(0.0, np.cumsum(pattern)) / 1e3, strength, PHONE_HZ)
    return DecodedDocument(events, document.text("description"), FROM_PHONE)


def _cleaned(on: NDArray[np.bool_], shortest: int) -> NDArray[np.bool_]:
    """Return ``on``, a value per ms, without shorter pauses, and with shorter pulses lengthened."""
    cleaned = _filled(on, shortest)
    for start in np.flatnonzero(cleaned & np.diff(cleaned, prepend=False)).tolist():
        first = min(start, max(0, len(on) - shortest))
        cleaned[first : first + shortest] = True
    # A lengthened pulse may leave a short pause.
    return _filled(cleaned, shortest)


def _filled(on: NDArray[np.bool_], shortest: int) -> NDArray[np.bool_]:
    """Return ``on`` with shorter pauses between pulses filled."""
    closed = ndimage.grey_closing(np.pad(on, shortest).astype(np.uint8), shortest)
    return np.asarray(closed[shortest:-shortest] > 0)


def _entries(on: NDArray[np.bool_]) -> list[int]:
    """Return on, off, on … in ms, ending on; entries longer than `LONGEST_MS` are split by entries of 0."""
    edges = np.flatnonzero(np.diff(on, prepend=False, append=False))
    pause, *lengths = np.diff(edges, prepend=0).tolist()
    entries: list[int] = []
    for length in [0, pause, *lengths] if pause else lengths:
        more = max(0, math.ceil(length / LONGEST_MS) - 1)
        entries += [LONGEST_MS, 0] * more + [length - more * LONGEST_MS]
    return entries


FORMAT = HapticFormat(
    name="vibration",
    engine="The web, on phones",
    title="W3C vibration pattern",
    suffix=".json",
    holds="on and off",
    encode=encode,
    decode=decode,
    instead={
        "the phone's envelope (android_envelope)": "android_envelope",
        "android (before Android 16)": "android",
    },
    recognise=lambda document: isinstance(document, list | int | float) or has_key("pattern")(document),
)

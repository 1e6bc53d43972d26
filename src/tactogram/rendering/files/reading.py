"""Haptic files read as players take them, and checked."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.files.analysis import READ_RATE, carrier
from tactogram.rendering.files.catalogue import HapticFormat, formats_with, haptic_format, recognised_format
from tactogram.rendering.files.documents import (
    DecodedDocument,
    Node,
    Notes,
    parse,
    sample_count,
    without_commas_at_ends,
)
from tactogram.rendering.files.events import Events
from tactogram.signal import Signal
from tactogram.signal.io.content import SignalDescription, decode as read_description
from tactogram.text_files import check_regular

MOST_BYTES = 500_000_000
"""Largest file that is read."""


@dataclass(frozen=True, eq=False)
class HapticFile:
    """Content of a haptic file.

    ``events`` are in parts of full scale, None of a waveform. ``unit`` and ``full_scale`` are what the file states, 1
    if nothing. ``metadata`` is as passed to `write_haptic`, or the file's description. ``facts`` has ``format``,
    ``full_scale`` (None if the file does not state it) and, depending on the format, ``carrier_hz`` (the lowest and the
    highest frequency of the events, or of the span of a file of shares), ``carrier_from``, ``modality``, ``left_out``.
    ``warnings`` name the rules that the file breaks, and how it is read, a line each.
    """

    events: Events | None
    metadata: dict[str, Any] = field(default_factory=dict)
    facts: dict[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    content: DecodedDocument | None = None
    description: SignalDescription | None = None
    rate: float | None = None

    @property
    def unit(self) -> str:
        """The unit of the signal, 1 if the file states none."""
        return self.description.unit if self.description else "1"

    @property
    def full_scale(self) -> float:
        """What 1 in the file stands for, in ``unit``."""
        return (self.description.full_scale if self.description else None) or 1.0

    @cached_property
    def signal(self) -> Signal:
        """The file as a signal at ``rate``, in its unit and at its level; events as `carrier`."""
        waveform = self.content.waveform if self.content else None
        signal = waveform(self.rate) if waveform else carrier(self.events or Events(0.0), self.rate)
        if (ours := self.description) is None:
            return signal
        axes = ours.axes if len(ours.axes) == len(signal.axes) else signal.axes
        samples = (signal.samples.astype(np.float64) * self.full_scale).astype(np.float32)
        return Signal(samples, signal.rate, ours.unit, axes, ours.domain)


def read_haptic(path: Path | str, *, format: str | None = None, rate: float | None = None) -> HapticFile:
    """Return the content of a haptic file, read as players take it.

    The format is determined by suffix, or by content if several formats share the suffix. ``rate`` (Hz) is that of the
    signal: a carrier's is `analysis.READ_RATE` by default, a waveform's its own. Raises `DataError` if no player
    accepts the file.
    """
    path = Path(path)
    notes = Notes()
    document, kind = _read(path, format, notes)
    file = decoded(document, kind, notes, rate)
    try:
        notes.check()
    except DataError as error:
        raise DataError(path, f"not valid {kind.title}: {error}") from None
    return file


def check_file(path: Path | str, *, format: str | None = None) -> dict[str, Any]:
    """Return whether players accept a haptic file: ``file``, ``format``, ``valid``, ``problems``, ``warnings``.

    Problems and warnings are a line each; warnings are of broken rules that players forgive. Raises `DataError` if
    there is no such file, or no format recognises it.
    """
    path = Path(path)
    notes = Notes()
    document, kind = _read(path, format, notes)
    decoded(document, kind, notes)
    facts = {"file": str(path), "format": kind.name, "valid": not notes.problems}
    return facts | {"problems": notes.problems, "warnings": notes.warnings}


def decoded(document: Any, kind: HapticFormat, notes: Notes, rate: float | None = None) -> HapticFile:
    """Return the content of a document; nothing of one with problems, which are in ``notes`` then."""
    try:
        content = kind.decode(Node(document, notes))
        if content.events is not None:
            sample_count(content.events.seconds, READ_RATE)
        ours = read_description(content.description, kind.title) if content.description else None
    except (DataError, ParameterError) as error:
        notes.problems += [] if notes.problems else [str(error)]
    notes.problems[:] = dict.fromkeys(notes.problems)
    if notes.problems:
        return HapticFile(None)
    comment = {"comment": content.description} if content.description else {}
    metadata = dict(ours.metadata) if ours else comment
    facts: dict[str, Any] = {"format": kind.name, "full_scale": ours.full_scale if ours else None}
    if (events := content.events) is not None and content.carrier_from:
        hz = [events.span.low, events.span.high] if events.span else events.frequencies
        limits = sorted({round(limit, 1) for limit in (min(hz), max(hz))}) if hz else []
        facts |= {"carrier_hz": limits, "carrier_from": content.carrier_from}
    others = {"left_out": content.left_out, "modality": content.modality}
    facts |= {name: text for name, text in others.items() if text}
    return HapticFile(content.events, metadata, facts, tuple(notes.warnings), content, ours, rate)


def _read(path: Path, name: str | None, notes: Notes) -> tuple[Any, HapticFormat]:
    check_regular(path)
    if path.stat().st_size > MOST_BYTES:
        raise DataError(path, f"must be at most {MOST_BYTES} bytes, got {path.stat().st_size}")
    candidates = [haptic_format(name)] if name else formats_with(path.suffix)
    data = path.read_bytes()
    if len(candidates) == 1:
        kind = candidates[0]
        if kind.commas_at_ends and (plain := without_commas_at_ends(data)) != data:
            notes.warn("the last member of a list or object must not have a comma", done="left out")
            data = plain
        return kind.parse(data, path), kind
    if re.search(rb'<primitive-effect|"primitive"', data):
        raise DataError(
            path,
            "Android's compositions of primitives are not read, since each phone has its own; write the "
            "effect as timings and amplitudes, or as an envelope of controlPoints, in JSON",
        )
    document = parse(data, path)
    return document, recognised_format(document, path)

"""Haptic file format: the ``FORMAT`` of a module of `formats`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, encoded, parse
from tactogram.rendering.files.events import Events
from tactogram.signal import Signal


@dataclass(frozen=True)
class HapticFormat:
    """A format that holds parts of full scale.

    Parameters
    ----------
    name : str
        Equals the name of the module's file.
    suffix : str
        May be shared with other formats.
    holds : {"waveform", "envelope", "on and off"}
        A waveform keeps all axes, the others hold events of one.
    encode : callable
        Returns the document of events within full scale.
    decode : callable
        Returns the content of a document as players take it. What it lacks, and what players clamp, is noted by
        `documents.Node`; rules of the format are noted in its ``notes``.
    recognise : callable
        Whether a document with an unknown or shared suffix looks like this format.
    encode_waveform : callable, optional
        Returns the document of a signal within full scale, of a format that holds waveforms.
    bands : tuple of (float, float), Hz
        In which the strength of a waveform is analysed, each on its own; by default all that is felt, with transients.
    resolution_s : float, s
        By how much the time of an event may differ in the file.
    instead : str
        What keeps more of a signal, for the same devices if possible, in words (see `verdict`).
    modalities : tuple of str
        Modalities that the format distinguishes, if any.
    highest_rate : float, Hz, optional
        Waveforms over time with a higher rate are resampled to it.
    parse, serialise : callable
        Convert a file's bytes (and its path, for errors) to a document, and back. JSON by default.
    """

    name: str
    title: str
    suffix: str
    holds: Literal["waveform", "envelope", "on and off"]
    encode: Callable[[Events, DocumentHeader], Any]
    decode: Callable[[Node], DecodedDocument]
    recognise: Callable[[Any], bool]
    encode_waveform: Callable[[Signal, DocumentHeader], Any] | None = None
    bands: tuple[tuple[float, float], ...] = ()
    resolution_s: float = 0.001
    instead: str = "a format of waveforms (.wav, .hjif)"
    modalities: tuple[str, ...] = ()
    highest_rate: float | None = None
    parse: Callable[[bytes, Path], Any] = parse
    serialise: Callable[[Any], bytes] = encoded

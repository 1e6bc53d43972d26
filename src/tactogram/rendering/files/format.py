"""Haptic file format: the ``FORMAT`` of a module of `formats`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, encoded, parse
from tactogram.rendering.files.envelope import Envelope
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
        A waveform keeps all axes, the others hold one.
    encode : callable
        Returns the document of a signal whose samples (waveform) or envelope lie within full scale.
    encode_envelope : callable, optional
        Returns the document of an envelope within full scale, where no signal needs to be analysed.
    decode : callable
        Returns the content of a valid document. The second argument is the wanted rate in Hz, or None.
    validate : callable
        Returns the problems of a document, a line each.
    recognise : callable
        Whether a document with an unknown or shared suffix looks like this format.
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
    encode: Callable[[Signal, DocumentHeader], Any]
    decode: Callable[[Any, float | None], DecodedDocument]
    validate: Callable[[Any], list[str]]
    recognise: Callable[[Any], bool]
    encode_envelope: Callable[[Envelope, DocumentHeader], Any] | None = None
    instead: str = "a format of waveforms (.wav, .hjif)"
    modalities: tuple[str, ...] = ()
    highest_rate: float | None = None
    parse: Callable[[bytes, Path], Any] = parse
    serialise: Callable[[Any], bytes] = encoded

"""``.haps`` version 5, Interhaptics' effects: amplitude, frequency in Hz, transients.

The vendor publishes no schema. Members, units and which of them may be missing are those of effects that it ships:
Interhaptics' Unity and Unreal SDKs, Razer's WYVRN SDK and its Sensa development kit. ReaHaptic, an exporter by others,
writes the same. Times are in s and, within a note, relative to its start. Keyframes are joined by lines: no source says
what the engine does between them. Version 6, without ``m_`` in its names, is not read.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import (
    MOST_ENTRIES,
    DecodedDocument,
    DocumentHeader,
    DocumentPart,
    has_key,
    problems_of,
)
from tactogram.rendering.files.envelope import (
    PULSE_S,
    UNKNOWN_HZ,
    Envelope,
    Pulse,
    carrier,
    envelope_of,
    thinned,
)
from tactogram.rendering.files.format import HapticFormat
from tactogram.signal import Signal

AMPLITUDE_STEP, FREQUENCY_STEP_HZ = 0.005, 2.0
"""Largest deviation of the file's lines from the envelope."""
TRANSIENT_S = 0.022
"""Length of a transient in the vendor's files, s."""
SHORTEST_S = 1e-5
_DIGITS = 6

NotNegative = Annotated[float, Field(ge=0)]


class Keyframe(DocumentPart):
    """Value at a time; slopes are ignored."""

    time: NotNegative = Field(alias="m_time")
    value: NotNegative = Field(alias="m_value")


class Modulation(DocumentPart):
    """Amplitude or frequency over time. Some of the vendor's keyframes are out of order."""

    keyframes: tuple[Keyframe, ...] = Field((), alias="m_keyframes", max_length=MOST_ENTRIES, strict=False)

    def at(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the values at times; `UNKNOWN_HZ` of a frequency that is missing."""
        own = sorted((keyframe.time, keyframe.value) for keyframe in self.keyframes) or [(0.0, UNKNOWN_HZ)]
        return np.asarray(np.interp(times, [time for time, _ in own], [value for _, value in own]))


class Effect(DocumentPart):
    """Modulations of a note; a transient has none."""

    amplitude: Modulation = Field(Modulation(m_keyframes=()), alias="m_amplitudeModulation")
    frequency: Modulation = Field(Modulation(m_keyframes=()), alias="m_frequencyModulation")


class Note(DocumentPart):
    """A transient or a continuous vibration."""

    start: NotNegative = Field(alias="m_startingPoint")
    seconds: NotNegative = Field(alias="m_length")
    gain: NotNegative = Field(alias="m_gain")
    effect: Effect = Field(alias="m_hapticEffect")

    @property
    def transient(self) -> bool:
        """Whether it has no amplitude over time."""
        return not self.effect.amplitude.keyframes


class Melody(DocumentPart):
    """Notes of one kind."""

    mute: int = Field(0, alias="m_mute")
    gain: NotNegative = Field(1.0, alias="m_gain")
    notes: tuple[Note, ...] = Field(alias="m_notes", max_length=MOST_ENTRIES, strict=False)


class Vibration(DocumentPart):
    """Melodies over time: usually the transients, then one or two of continuous vibrations."""

    gain: NotNegative = Field(1.0, alias="m_gain")
    melodies: tuple[Melody, ...] = Field(alias="m_melodies", max_length=MOST_ENTRIES, strict=False)


class Perception(DocumentPart):
    """Stiffness or texture, of which only the presence is read."""

    melodies: tuple[dict[str, Any], ...] = Field((), alias="m_melodies", strict=False)


class Material(DocumentPart):
    """A complete file."""

    version: Literal["5"] = Field(alias="m_version")
    description: str = Field("", alias="m_description")
    gain: NotNegative = Field(1.0, alias="m_gain")
    vibration: Vibration = Field(alias="m_vibration")
    stiffness: Perception = Field(Perception(m_melodies=()), alias="m_stiffness")
    texture: Perception = Field(Perception(m_melodies=()), alias="m_texture")


def validate(document: Any) -> list[str]:
    """Return the problems of a document, a line each; empty if it is valid."""
    if has_key("version")(document) and not has_key("m_version")(document):
        return [f"version must be 5 (m_version), got {document['version']!r}; export it as version 5"]
    return problems_of(Material, document)


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal of one axis whose envelope is within 0 to 1.

    A transient's gain is its whole strength, the envelope included, as ReaHaptic converts an emphasis.
    """
    if signal.seconds < SHORTEST_S:
        raise ParameterError(
            f"an Interhaptics effect needs at least {SHORTEST_S:g} s, got {signal.seconds:g} s"
        )
    envelope = envelope_of(signal)
    amplitude = np.minimum(envelope.amplitude, 1)
    transients = [
        _note(
            pulse.time,
            TRANSIENT_S,
            min(1.0, pulse.amplitude + float(np.interp(pulse.time, envelope.times, amplitude))),
            {"m_type": 0},
            priority=0,
        )
        for pulse in envelope.pulses
    ]
    modulations = {
        "m_amplitudeModulation": _modulation(envelope.times, amplitude, AMPLITUDE_STEP, digits=4),
        "m_frequencyModulation": _modulation(envelope.times, envelope.frequency, FREQUENCY_STEP_HZ, digits=1),
    }
    effect = _note(0.0, envelope.seconds, 1.0, modulations, priority=1)
    return {
        "m_version": "5",
        "m_description": header.description,
        "m_HDFlag": 0,
        "m_time_unit": 0,
        "m_length_unit": 7,
        "m_stiffness": _perception(),
        "m_texture": _perception(),
        "m_vibration": _perception(transients, [effect]),
        "m_gain": 1.0,
    }


def decode(document: Any, rate: float | None = None) -> DecodedDocument:
    """Return the vibration of a valid document, as a carrier of its frequencies at ``rate``.

    Continuous vibrations are those of the first melody that has any: how the engine combines several is unknown. A
    transient adds what it exceeds them by, at their frequency, since it has none of its own.
    """
    material = Material.model_validate(document)
    level = material.gain * material.vibration.gain
    audible = [melody for melody in material.vibration.melodies if not melody.mute]
    transients = [(melody, note) for melody in audible for note in melody.notes if note.transient]
    continuous = [melody for melody in audible if any(not note.transient for note in melody.notes)]
    if not transients and not continuous:
        raise ParameterError("the file holds no vibration")
    times, amplitude, frequency = _line(continuous[0], level) if continuous else _SILENCE
    strongest: dict[float, float] = {}
    for melody, note in transients:
        excess = level * melody.gain * note.gain - float(
            np.interp(note.start, times, amplitude, left=0.0, right=0.0)
        )
        strongest[note.start] = max(excess, strongest.get(note.start, 0.0))
    pulses = tuple(
        Pulse(start, excess, float(np.interp(start, times, frequency)))
        for start, excess in sorted(strongest.items())
    )
    seconds = float(times[-1])
    seconds = max([seconds, *(start + PULSE_S for start in strongest if start >= seconds)])
    facts: dict[str, Any] = {
        "carrier_hz": [round(float(frequency.min()), 1), round(float(frequency.max()), 1)],
        "carrier_from": "m_frequencyModulation"
        if continuous
        else "nothing in the file: transients have none",
    }
    left_out = ["further melodies"] if len(continuous) > 1 else []
    others = {"stiffness": material.stiffness, "texture": material.texture}
    left_out += [name for name, one in others.items() if any(m.get("m_notes") for m in one.melodies)]
    if left_out:
        facts["left_out"] = ", ".join(left_out)
    envelope = Envelope(seconds, times, amplitude, times, frequency, pulses)
    return DecodedDocument(carrier(envelope, rate), material.description, facts)


_SILENCE = np.array([0.0]), np.array([0.0]), np.array([UNKNOWN_HZ])
"""Times, amplitude and frequency of a file of transients."""


def _line(
    melody: Melody, level: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return times, amplitude and frequency of a melody's notes; each ends where the next begins, at the latest."""
    notes = sorted((note for note in melody.notes if not note.transient), key=lambda note: note.start)
    ends = [
        *(min(note.start + note.seconds, after.start) for note, after in pairwise(notes)),
        notes[-1].start + notes[-1].seconds,
    ]
    times, amplitude, frequency = [], [], []
    for note, end in zip(notes, ends, strict=True):
        both = note.effect.amplitude, note.effect.frequency
        own = [keyframe.time for modulation in both for keyframe in modulation.keyframes]
        within = np.unique(np.clip([0.0, end - note.start, *own], 0, end - note.start))
        # A jump from 0 and back to it.
        within = np.pad(within, 1, mode="edge")
        times.append(note.start + within)
        strength = level * melody.gain * note.gain * note.effect.amplitude.at(within)
        strength[[0, -1]] = 0
        amplitude.append(strength)
        frequency.append(note.effect.frequency.at(within))
    return np.concatenate(times), np.concatenate(amplitude), np.concatenate(frequency)


def _note(
    start: float, seconds: float, gain: float, effect: dict[str, Any], *, priority: int
) -> dict[str, Any]:
    return {
        "m_startingPoint": round(start, _DIGITS),
        "m_length": round(seconds, _DIGITS),
        "m_priority": priority,
        "m_gain": round(gain, 4),
        "m_hapticEffect": effect,
    }


def _modulation(
    times: NDArray[np.float64], values: NDArray[np.float64], tolerance: float, *, digits: int
) -> dict[str, Any]:
    keyframes = [
        {"m_time": round(float(times[i]), _DIGITS), "m_value": round(float(values[i]), digits)}
        for i in thinned(times, values, tolerance)
    ]
    return {"m_extrapolationStrategy": 0, "m_keyframes": keyframes}


def _perception(*melodies: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "m_loop": 0,
        "m_maximum": 1.0,
        "m_gain": 1.0,
        "m_signalEvaluationMethod": 3,
        "m_melodies": [{"m_mute": 0, "m_gain": 1.0, "m_notes": notes} for notes in melodies],
    }


FORMAT = HapticFormat(
    name="haps",
    title="Interhaptics effect v5",
    suffix=".haps",
    holds="envelope",
    encode=encode,
    decode=decode,
    validate=validate,
    recognise=has_key("m_vibration"),
)

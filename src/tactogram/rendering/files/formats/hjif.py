"""HJIF, the JSON form of MPEG's haptics (ISO/IEC 23090-31), which holds waveforms and events.

A signal is written as one Curve band per axis, of type Linear, with a tick per sample and a keyframe per sample, in
one effect at position 0: since ticks are samples, nothing is interpolated. Samples on the line between their
neighbours are omitted. Over displacement a tick is a fraction of a mm; only the description says so, since the format
has no other place for it. Events are a VectorialWave band with an effect for each vibration, and a Transient band.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.files.catalogue import HapticFormat
from tactogram.rendering.files.documents import DocumentHeader, has_key
from tactogram.rendering.files.events import Events, Part, bends
from tactogram.rendering.files.hjif_reading import MODALITIES, MOST_TICKS, TRANSIENT_S, decode
from tactogram.signal import Signal

HIGHEST_RATE = 8000.0
"""Signals are resampled to at most this rate, Hz: touch ends at 1 kHz, and a sample takes about 50 bytes."""
FINEST_TICKS = 1000
"""A slower signal gets several ticks per sample, so that its rate is met to 0.05 %, or exactly if it is integral."""
DIGITS = 6
"""Decimals of an amplitude: -120 dB of full scale."""
TICKS, HIGHEST_HZ = 10_000, 1000
"""Ticks per second, and upper limit of a band, of events."""
AMPLITUDE_STEP, FREQUENCY_STEP_HZ = 0.005, 2.0
"""Largest deviation of a wave's lines from the vibration."""
BY_UNIT = {"m/s^2": "Acceleration", "m/s": "Velocity", "m": "Position", "N": "Force"}


def encode_waveform(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal within -1 to 1, a channel per axis.

    The default modality depends on the header's unit: Acceleration for m/s^2 and so on; for other units Friction over
    displacement, else Vibrotactile. Raises `ParameterError` if the rate needs too many ticks.
    """
    steps = max(1, math.ceil(FINEST_TICKS / signal.rate))
    timescale = round(signal.rate * steps)
    if timescale > MOST_TICKS or len(signal.axes) > 65_535:
        raise ParameterError(
            f"HJIF holds at most {MOST_TICKS} ticks per s (or mm), got {timescale}; resample the signal"
        )
    usual = "Friction" if signal.domain == "displacement" else "Vibrotactile"
    top = min(round(signal.rate / 2), timescale)
    channels = []
    for i, (name, samples) in enumerate(zip(signal.axes, signal.samples, strict=True)):
        curve = _band([_effect(0, _keyframes(samples, steps))], top, band_type="Curve", curve_type="Linear")
        channels.append(_channel(i, name, [curve], signal.rate, len(signal)))
    about = f"{signal.unit} over {signal.domain}"
    return _document(channels, header, timescale, about, BY_UNIT.get(header.unit, usual))


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1, in one channel."""
    waves = [_effect(_ticks(part.start), _wave_keyframes(part)) for part in events.parts]
    taps = [
        _effect(_ticks(tap.time), [_keyframe(0, amplitude=tap.amplitude, frequency=tap.frequency)])
        for tap in events.transients
    ]
    bands = [
        _band(effects, HIGHEST_HZ, band_type=kind)
        for kind, effects in (("VectorialWave", waves), ("Transient", taps))
        if effects
    ]
    seconds = max([events.seconds, *(tap.time + TRANSIENT_S for tap in events.transients[-1:])])
    channel = _channel(0, "x", bands, TICKS, max(1, _ticks(seconds)))
    return _document([channel], header, TICKS, "events over time", "Vibrotactile")


def _document(
    channels: list[dict[str, Any]], header: DocumentHeader, timescale: int, about: str, modality: str
) -> dict[str, Any]:
    """Return a document of one perception; ``modality`` holds where the header names none."""
    return {
        "version": "2023",
        "profile": "Main",
        "level": 1 if len(channels) <= 127 else 2,
        "date": datetime.now(UTC).date().isoformat(),
        "description": header.description,
        "timescale": timescale,
        "avatars": [],
        "perceptions": [
            {
                "id": 0,
                "avatar_id": 0,
                "description": about,
                "perception_modality": header.modality or modality,
                "effect_library": [],
                "reference_devices": [{"id": 0, "name": "unspecified"}],
                "channels": channels,
            }
        ],
        "syncs": [{"timestamp": 0}],
    }


def _channel(number: int, name: str, bands: list[dict[str, Any]], rate: float, count: int) -> dict[str, Any]:
    return {
        "id": number,
        "description": name,
        "gain": 1.0,
        "mixing_coefficient": 1.0,
        "body_part_mask": 0,
        "reference_device_id": 0,
        "frequency_sampling": max(1, round(rate)),
        "sample_count": count,
        "bands": bands,
    }


def _band(effects: list[dict[str, Any]], top: int, **kind: str) -> dict[str, Any]:
    return kind | {"lower_frequency_limit": 0, "upper_frequency_limit": top, "effects": effects}


def _effect(position: int, keyframes: list[dict[str, float]]) -> dict[str, Any]:
    about = {"effect_type": "Basis", "position": position, "phase": 0.0, "base_signal": "Sine"}
    return about | {"keyframes": keyframes}


def _keyframes(samples: NDArray[np.float32], steps: int) -> list[dict[str, float]]:
    """Return a keyframe per sample that is not on the line between its neighbours, and one after the last.

    The reference software plays nothing at the exact position of the last keyframe.
    """
    x = np.round(samples.astype(np.float64), DIGITS)
    x = np.append(x, x[-1])
    bent = np.abs(np.diff(x, 2)) > 0.5 * 10.0**-DIGITS if len(x) > 2 else np.zeros(0, bool)
    places = np.flatnonzero(np.concatenate([[True], bent, [True]]))
    return [_keyframe(steps * index, amplitude=float(x[index])) for index in places.tolist()]


def _wave_keyframes(part: Part) -> list[dict[str, float]]:
    """Return the keyframes of a vibration's amplitude and frequency, relative to its beginning."""
    strength = bends(part.times - part.start, part.amplitude, AMPLITUDE_STEP)
    tones = bends(part.times - part.start, part.frequency, FREQUENCY_STEP_HZ)
    frames = [_keyframe(_ticks(time), amplitude=value) for time, value in strength]
    frames += [_keyframe(_ticks(time), frequency=hz) for time, hz in tones]
    return sorted(frames, key=lambda frame: frame["relative_position"])


def _keyframe(
    position: int, *, amplitude: float | None = None, frequency: float | None = None
) -> dict[str, float]:
    frame: dict[str, float] = {"relative_position": position}
    if amplitude is not None:
        frame["amplitude_modulation"] = round(amplitude, DIGITS)
    if frequency is not None:
        frame["frequency_modulation"] = round(frequency)
    return frame


def _ticks(seconds: float) -> int:
    return round(TICKS * seconds)


FORMAT = HapticFormat(
    name="hjif",
    engine="MPEG haptics",
    title="HJIF (MPEG)",
    suffix=".hjif",
    holds="waveform",
    encode=encode,
    encode_waveform=encode_waveform,
    decode=decode,
    recognise=has_key("perceptions"),
    instead={".wav": ""},
    modalities=MODALITIES,
    highest_rate=HIGHEST_RATE,
)

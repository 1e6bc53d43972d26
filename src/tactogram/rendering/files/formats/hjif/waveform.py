"""Waveforms in HJIF documents, as dense curves.

Playback follows the reference software (MPEGGroup/HapticReferenceSoftware, BSD): interpolation, ticks, base signals,
and that a channel's bands are added, clipped to -1..1 and multiplied by its gain.

A signal is written as one Curve band per axis, of type Linear, with a tick per sample and a keyframe per sample, in
one effect at position 0: since ticks are samples, nothing is interpolated. Samples on the line between their
neighbours are omitted. Wavelet bands have no public description; such files need the reference software's Synthesizer.
Over displacement a tick is a fraction of a mm; only the description says so, since the format has no other place for
it.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, sample_count
from tactogram.rendering.files.envelope import READ_RATE
from tactogram.rendering.files.formats.hjif.rules import MOST_TICKS, Band, Channel, Effect, Haptics
from tactogram.signal import Signal
from tactogram.signal.io.description import decode as read_description

HIGHEST_RATE = 8000.0
"""Signals are resampled to at most this rate, Hz: touch ends at 1 kHz, and a sample takes about 50 bytes."""
FINEST_TICKS = 1000
"""A slower signal gets several ticks per sample, so that its rate is met to 0.05 %, or exactly if it is integral."""
DIGITS = 6
"""Decimals of an amplitude: -120 dB of full scale."""
TRANSIENT_MS = 22.0
"""Length of a transient, two periods of a sine, in the reference software."""
BY_UNIT = {"m/s^2": "Acceleration", "m/s": "Velocity", "m": "Position", "N": "Force"}


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
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
    channels = [
        {
            "id": i,
            "description": name,
            "gain": 1.0,
            "mixing_coefficient": 1.0,
            "body_part_mask": 0,
            "reference_device_id": 0,
            "frequency_sampling": max(1, round(signal.rate)),
            "sample_count": len(signal),
            "bands": [
                {
                    "band_type": "Curve",
                    "curve_type": "Linear",
                    "lower_frequency_limit": 0,
                    "upper_frequency_limit": top,
                    "effects": [
                        {
                            "effect_type": "Basis",
                            "position": 0,
                            "phase": 0.0,
                            "base_signal": "Sine",
                            "keyframes": _keyframes(signal.samples[i], steps),
                        }
                    ],
                }
            ],
        }
        for i, name in enumerate(signal.axes)
    ]
    return {
        "version": "2023",
        "profile": "Main",
        "level": 1 if len(signal.axes) <= 127 else 2,
        "date": datetime.now(UTC).date().isoformat(),
        "description": header.description,
        "timescale": timescale,
        "avatars": [],
        "perceptions": [
            {
                "id": 0,
                "avatar_id": 0,
                "description": f"{signal.unit} over {signal.domain}",
                "perception_modality": header.modality or BY_UNIT.get(header.unit, usual),
                "effect_library": [],
                "reference_devices": [{"id": 0, "name": "unspecified"}],
                "channels": channels,
            }
        ],
        "syncs": [{"timestamp": 0}],
    }


def decode(document: Any, rate: float | None = None) -> DecodedDocument:
    """Return the channels of a valid document's first perception, one axis each.

    The rate (Hz) is by default the one in the description of a file written by this package (ticks and
    ``frequency_sampling`` are integers), else the channels' ``frequency_sampling``, else `READ_RATE`. Raises
    `DataError` if the document is empty, or has content without a public description.
    """
    haptics = Haptics.model_validate(document)
    perception = next((p for p in haptics.perceptions if p.channels), None)
    if perception is None:
        raise DataError("the file has no perception with a channel")
    own = read_description(haptics.description, "HJIF") if haptics.description else None
    exact_rate = own.rate if own is not None else None
    stated = [c.frequency_sampling for c in perception.channels if c.frequency_sampling]
    rate = rate or exact_rate or (float(max(stated)) if stated else READ_RATE)
    lengths = [_seconds(channel, haptics.timescale) for channel in perception.channels]
    count = sample_count(max(lengths), rate)
    if count < 1 and exact_rate is None:
        raise DataError("the file's channels have no length")
    step = haptics.timescale / rate
    if exact_rate is not None and rate == exact_rate and perception.channels[0].sample_count:
        count, step = perception.channels[0].sample_count, float(round(step))
    ticks = np.arange(count, dtype=np.float64) * step
    samples = np.stack([_channel(c, ticks, haptics.timescale) for c in perception.channels])
    names = tuple(channel.description for channel in perception.channels)
    if len(set(names)) < len(names) or not all(names):
        names = tuple(str(channel.id) for channel in perception.channels)
    facts: dict[str, Any] = {"modality": perception.perception_modality}
    left_out = len(haptics.perceptions) - 1
    if left_out:
        facts["left_out"] = f"{left_out} further perceptions"
    return DecodedDocument(Signal(samples.astype(np.float32), rate, "1", names), haptics.description, facts)


def _keyframes(samples: NDArray[np.float32], steps: int) -> list[dict[str, Any]]:
    """Return a keyframe per sample that is not on the line between its neighbours, and one after the last.

    The reference software plays nothing at the exact position of the last keyframe.
    """
    x = np.round(samples.astype(np.float64), DIGITS)
    x = np.append(x, x[-1])
    bent = np.abs(np.diff(x, 2)) > 0.5 * 10.0**-DIGITS if len(x) > 2 else np.zeros(0, bool)
    places = np.flatnonzero(np.concatenate([[True], bent, [True]]))
    return [
        {"relative_position": place * steps, "amplitude_modulation": value}
        for place, value in zip(places.tolist(), x[places].tolist(), strict=True)
    ]


def _seconds(channel: Channel, timescale: int) -> float:
    if channel.frequency_sampling and channel.sample_count:
        return channel.sample_count / channel.frequency_sampling
    ends = [0.0]
    for band in channel.bands:
        tail = TRANSIENT_MS / 1e3 * timescale if band.band_type == "Transient" else 0.0
        ends += [
            effect.position + (frame.relative_position or 0) + tail
            for effect in band.effects
            for frame in effect.keyframes
        ]
    return max(ends) / timescale


def _channel(channel: Channel, ticks: NDArray[np.float64], timescale: int) -> NDArray[np.float64]:
    total = np.zeros(len(ticks))
    for band in channel.bands:
        for effect in band.effects:
            if effect.effect_type != "Basis":
                raise DataError(
                    f"{effect.effect_type} effects cannot be read; render the file to a WAV with the MPEG reference "
                    "software's Synthesizer"
                )
            total += _effect(band, effect, ticks - effect.position, timescale)
    return np.clip(total, -1, 1) * channel.gain


def _effect(band: Band, effect: Effect, at: NDArray[np.float64], timescale: int) -> NDArray[np.float64]:
    """Return an effect at ``at`` ticks after its position, float64, shape (time,)."""
    match band.band_type:
        case "Curve":
            return _curve(band.curve_type, effect, at)
        case "VectorialWave":
            return _wave(band, effect, at, timescale)
        case "Transient":
            return _transients(effect, at, timescale)
    raise DataError(
        "WaveletWave bands cannot be read, since their coding has no public description; render the file to a WAV "
        "with the MPEG reference software's Synthesizer"
    )


def _points(effect: Effect, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the positions and values of the keyframes that state a modulation."""
    stated = [k for k in effect.keyframes if getattr(k, name) is not None]
    places = np.array([k.relative_position or 0 for k in stated], np.float64)
    return places, np.array([getattr(k, name) for k in stated], np.float64)


def _curve(kind: str, effect: Effect, at: NDArray[np.float64]) -> NDArray[np.float64]:
    places, values = _points(effect, "amplitude_modulation")
    if not len(places):
        return np.zeros(len(at))
    inside = (at >= places[0]) & (at <= places[-1])
    if kind in ("Bezier", "Bspline"):
        raise DataError(f"curves of type {kind} cannot be read; use Linear, Cubic or Akima")
    if kind == "Linear" or len(places) == 2:
        return np.where(inside, np.interp(at, places, values), 0.0)
    if kind == "Akima" and len(places) > 2:
        from scipy.interpolate import Akima1DInterpolator

        return np.where(inside, np.nan_to_num(Akima1DInterpolator(places, values)(at)), 0.0)
    # Cubic or unspecified: horizontal at every keyframe, as the reference software's Hermite polynomial.
    i = np.clip(np.searchsorted(places, at, side="right") - 1, 0, max(len(places) - 2, 0))
    j = np.minimum(i + 1, len(places) - 1)
    span = np.maximum(places[j] - places[i], 1e-12)
    u = np.clip((at - places[i]) / span, 0, 1)
    return np.where(inside, values[i] + (values[j] - values[i]) * (3 - 2 * u) * u**2, 0.0)


def _wave(band: Band, effect: Effect, at: NDArray[np.float64], timescale: int) -> NDArray[np.float64]:
    places, strength = _points(effect, "amplitude_modulation")
    turns, frequency = _points(effect, "frequency_modulation")
    end = max(places.max(initial=0.0), turns.max(initial=0.0))
    inside = (at >= 0) & (at <= end)
    amplitude = np.interp(at, places, strength) if len(places) else np.ones(len(at))
    if not len(turns):
        return np.zeros(len(at))
    f = np.clip(np.interp(at, turns, frequency), band.lower_frequency_limit, band.upper_frequency_limit)
    step = (at[1] - at[0]) / timescale if len(at) > 1 else 0.0
    cycles = np.cumsum(np.where(inside, f, 0.0)) * step
    first = int(np.argmax(inside))
    cycles = cycles - cycles[first] + effect.phase / (2 * np.pi)
    return np.where(inside, amplitude * _base(effect.base_signal, cycles), 0.0)


def _base(name: str, cycles: NDArray[np.float64]) -> NDArray[np.float64]:
    match name:
        case "Square":
            return np.where(cycles % 1 < 0.5, 1.0, -1.0)
        case "Triangle":
            return np.asarray(2 / np.pi * np.arcsin(np.sin(2 * np.pi * cycles)))
        case "SawToothUp":
            return 2 * ((cycles + 0.5) % 1) - 1
        case "SawToothDown":
            return 1 - 2 * ((cycles + 0.5) % 1)
    return np.asarray(np.sin(2 * np.pi * cycles))


def _transients(effect: Effect, at: NDArray[np.float64], timescale: int) -> NDArray[np.float64]:
    """Return two periods of a sine in `TRANSIENT_MS` at each keyframe, at any frequency, as the reference does."""
    length = TRANSIENT_MS / 1e3 * timescale
    total = np.zeros(len(at))
    for place, strength in zip(*_points(effect, "amplitude_modulation"), strict=True):
        away = at - place
        total += np.where((away >= 0) & (away <= length), strength * np.sin(4 * np.pi * away / length), 0.0)
    return total

"""Reader of HJIF documents: their events, and their waveform.

Playback follows the reference software (MPEGGroup/HapticReferenceSoftware, BSD): interpolation, ticks, base signals,
and that a channel's bands are added, clipped to -1..1 and multiplied by its gain. Wavelet bands have no public
description; such files need the reference software's Synthesizer.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.rendering.files.analysis import READ_RATE
from tactogram.rendering.files.documents import DecodedDocument, Node, problems_of, sample_count
from tactogram.rendering.files.events import UNKNOWN_HZ, Events, Part, Transient, joined
from tactogram.rendering.files.formats.hjif.rules import Band, Channel, Effect, Haptics, Perception
from tactogram.signal import Signal
from tactogram.signal.io.description import decode as read_description

TRANSIENT_MS = 22.0
"""Length of a transient, two periods of a sine, in the reference software."""
_RENDER = "render the file to a WAV with the MPEG reference software's Synthesizer"


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document's first perception, and its channels as waveforms, one axis each.

    It has events if it consists of transients and waves of sines; of several channels the strongest counts. The rate
    (Hz) is by default the one in the description of a file written by this package (ticks and ``frequency_sampling``
    are integers), else the channels' ``frequency_sampling``, else `READ_RATE`. Content without a public description is
    a problem.
    """
    notes = document.notes
    notes.problems += problems_of(Haptics, document.value)
    notes.check()
    haptics = Haptics.model_validate(document.value)
    perception = next((p for p in haptics.perceptions if p.channels), None)
    if perception is None:
        notes.problems.append("the file has no perception with a channel")
        notes.check()
    assert perception is not None  # noqa: S101
    bands = [band for channel in perception.channels for band in channel.bands]
    effects = {effect.effect_type for band in bands for effect in band.effects} - {"Basis"}
    notes.problems += [f"{kind} effects cannot be read; {_RENDER}" for kind in sorted(effects)]
    if any(band.band_type == "WaveletWave" for band in bands):
        notes.problems.append(
            f"WaveletWave bands cannot be read, since their coding is not public; {_RENDER}"
        )
    for kind in sorted(
        {"Bezier", "Bspline"} & {band.curve_type for band in bands if band.band_type == "Curve"}
    ):
        notes.problems.append(f"curves of type {kind} cannot be read; use Linear, Cubic or Akima")
    own = read_description(haptics.description, "HJIF") if haptics.description else None
    lengths = [_seconds(channel, haptics.timescale) for channel in perception.channels]
    if own is None and not max(lengths) > 0:
        notes.problems.append("the file's channels have no length")
    notes.check()
    names = tuple(channel.description for channel in perception.channels)
    if len(set(names)) < len(names) or not all(names):
        names = tuple(str(channel.id) for channel in perception.channels)
    stated = [c.frequency_sampling for c in perception.channels if c.frequency_sampling]
    sample_count(max(lengths), float(max(stated, default=READ_RATE)))
    facts: dict[str, Any] = {"modality": perception.perception_modality}
    left_out = len(haptics.perceptions) - 1
    if left_out:
        facts["left_out"] = f"{left_out} further perceptions"
    waves = all(
        band.band_type == "Transient"
        or (
            band.band_type == "VectorialWave" and all(effect.base_signal == "Sine" for effect in band.effects)
        )
        for band in bands
    )
    waveform = partial(_waveform, perception, names, haptics.timescale, None if own is None else own.rate)
    events = _events(perception, haptics.timescale, max(lengths)) if waves else None
    if events is not None and len(names) > 1:
        facts["left_out"] = ", ".join(
            filter(None, [facts.get("left_out"), f"{len(names)} channels as events: the strongest"])
        )
    return DecodedDocument(events, haptics.description, facts, waveform)


def _events(perception: Perception, timescale: int, seconds: float) -> Events:
    channels: list[list[Part]] = []
    taps: dict[float, Transient] = {}
    for channel in perception.channels:
        parts: list[Part] = []
        for band in channel.bands:
            for effect in band.effects:
                if band.band_type == "VectorialWave":
                    parts += _part(band, effect, channel.gain, timescale)
                    continue
                for frame in effect.keyframes:
                    time = (effect.position + (frame.relative_position or 0)) / timescale
                    strength = min(1.0, abs(channel.gain * (frame.amplitude_modulation or 0.0)))
                    tap = Transient(time, strength, float(frame.frequency_modulation or UNKNOWN_HZ))
                    taps[time] = max(tap, taps.get(time, tap), key=lambda one: one.amplitude)
        channels.append(parts)
    strongest = [joined([joined(parts) for parts in channels if parts], strongest=True)]
    return Events.of(channels[0] if len(channels) == 1 else strongest, taps.values(), seconds)


def _part(band: Band, effect: Effect, gain: float, timescale: int) -> list[Part]:
    """Return a wave as a vibration; nothing without a frequency. The first and last strength hold beside them."""
    (places, strength), (turns, hz) = (
        _points(effect, "amplitude_modulation"),
        _points(effect, "frequency_modulation"),
    )
    end = max(places.max(initial=0.0), turns.max(initial=0.0))
    if not len(turns) or end <= 0:
        return []
    if not len(places):
        places, strength = np.array([0.0, end]), np.ones(2)
    before, after = int(places[0] > 0), int(places[-1] < end)
    at = np.concatenate([[0.0] * before, places, [end] * after])
    amplitude = np.pad(strength, (before, after), mode="edge")
    hz = np.clip(hz, band.lower_frequency_limit, band.upper_frequency_limit)
    times = (effect.position + at) / timescale
    return [
        Part.of(times, np.minimum(np.abs(gain * amplitude), 1), (effect.position + turns) / timescale, hz)
    ]


def _waveform(
    perception: Perception,
    names: tuple[str, ...],
    timescale: int,
    exact_rate: float | None,
    rate: float | None,
) -> Signal:
    stated = [c.frequency_sampling for c in perception.channels if c.frequency_sampling]
    rate = rate or exact_rate or float(max(stated, default=READ_RATE))
    count = sample_count(max(_seconds(channel, timescale) for channel in perception.channels), rate)
    step = timescale / rate
    if exact_rate is not None and rate == exact_rate and perception.channels[0].sample_count:
        count, step = perception.channels[0].sample_count, float(round(step))
    ticks = np.arange(max(1, count), dtype=np.float64) * step
    samples = np.stack([_channel(c, ticks, timescale) for c in perception.channels])
    return Signal(samples.astype(np.float32), rate, "1", names)


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
    players = {
        "Curve": lambda band, effect, at: _curve(band.curve_type, effect, at),
        "VectorialWave": lambda band, effect, at: _wave(band, effect, at, timescale),
        "Transient": lambda band, effect, at: _transients(effect, at, timescale),
    }
    total = np.zeros(len(ticks))
    for band in channel.bands:
        for effect in band.effects:
            total += players[band.band_type](band, effect, ticks - effect.position)
    return np.clip(total, -1, 1) * channel.gain


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

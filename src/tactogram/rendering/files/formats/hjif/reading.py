"""Reader of HJIF documents: their events, and their waveform.

Playback follows the reference software (MPEGGroup/HapticReferenceSoftware, BSD): interpolation, ticks, base signals,
and that a channel's bands are added, clipped to -1..1 and multiplied by its gain. Wavelet bands have no public
description; such files need the reference software's Synthesizer.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from tactogram.rendering.files.analysis import READ_RATE
from tactogram.rendering.files.documents import DecodedDocument, Node, sample_count
from tactogram.rendering.files.events import UNKNOWN_HZ, Events, Line, Part, Transient, joined
from tactogram.rendering.files.formats.hjif.rules import Band, Channel, Effect, channels_of
from tactogram.signal import Signal
from tactogram.signal.io.description import decode as read_description

TRANSIENT_MS = 22.0
"""Length of a transient, two periods of a sine, in the reference software."""


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document's first perception, and its channels as waveforms, one axis each.

    It has events if it consists of transients and waves of sines; of several channels the strongest counts. The rate
    (Hz) is by default the one in the description of a file written by this package (ticks and ``frequency_sampling``
    are integers), else the channels' ``frequency_sampling``, else `READ_RATE`.
    """
    notes = document.notes
    timescale, perceptions = channels_of(document)
    modality, channels = next((one for one in perceptions if one[1]), ("", []))
    if not channels:
        notes.problems.append("the file has no perception with a channel")
    notes.check()
    description = document.text("description")
    own = read_description(description, "HJIF") if description else None
    seconds = max(_seconds(channel, timescale) for channel in channels)
    if own is None and not seconds > 0:
        notes.problems.append("the file's channels have no length")
    notes.check()
    sample_count(seconds, max([channel.rate for channel in channels]) or READ_RATE)
    waves = all(
        band.kind == "Transient"
        or (band.kind == "VectorialWave" and all(effect.base == "Sine" for effect in band.effects))
        for channel in channels
        for band in channel.bands
    )
    events = _events(channels, timescale, seconds) if waves else None
    left_out = [f"{len(perceptions) - 1} further perceptions"] if len(perceptions) > 1 else []
    if events is not None and len(channels) > 1:
        left_out.append(f"of {len(channels)} channels as events all but the strongest at any time")
    facts: dict[str, Any] = {"modality": modality} | ({"left_out": ", ".join(left_out)} if left_out else {})
    waveform = partial(_waveform, channels, timescale, None if own is None else own.rate)
    return DecodedDocument(events, description, facts, waveform)


def _events(channels: list[Channel], timescale: float, seconds: float) -> Events:
    parts: list[list[Part]] = []
    taps: list[Transient] = []
    for channel in channels:
        parts.append([])
        for band in channel.bands:
            for effect in band.effects:
                if band.kind == "VectorialWave":
                    parts[-1] += _part(band, effect, channel.gain, timescale)
                    continue
                for place, strength in effect.amplitude.T.tolist():
                    same = effect.frequency[1][effect.frequency[0] == place]
                    hz = float(same[0]) if len(same) else UNKNOWN_HZ
                    time = (effect.position + place) / timescale
                    taps.append(Transient(time, min(1.0, abs(channel.gain * strength)), hz))
    if len(channels) > 1:
        taps = list({one.time: one for one in sorted(taps, key=lambda one: one.amplitude)}.values())
    strongest = [joined([joined(own) for own in parts if own], strongest=True)]
    return Events.of(parts[0] if len(parts) == 1 else strongest, taps, seconds)


def _part(band: Band, effect: Effect, gain: float, timescale: float) -> list[Part]:
    """Return a wave as a vibration; nothing without a frequency. The first and last strength hold beside them."""
    (places, strength), (turns, hz), end = effect.amplitude, effect.frequency, effect.end
    if not len(turns) or end <= 0:
        return []
    if not len(places):
        places, strength = np.array([0.0, end]), np.ones(2)
    before, after = int(places[0] > 0), int(places[-1] < end)
    at = effect.position + np.concatenate([[0.0] * before, places, [end] * after])
    amplitude = np.minimum(np.abs(gain * np.pad(strength, (before, after), mode="edge")), 1)
    hz = np.clip(hz, band.low, band.high)
    return [Part.of(at / timescale, amplitude, (effect.position + turns) / timescale, hz)]


def _waveform(
    channels: list[Channel], timescale: float, exact_rate: float | None, rate: float | None
) -> Signal:
    rate = rate or exact_rate or max([channel.rate for channel in channels]) or READ_RATE
    count = sample_count(max(_seconds(channel, timescale) for channel in channels), rate)
    step = timescale / rate
    if exact_rate is not None and rate == exact_rate and channels[0].count:
        count, step = channels[0].count, float(round(step))
    ticks = np.arange(max(1, count), dtype=np.float64) * step
    samples = np.stack([_played(channel, ticks, timescale) for channel in channels])
    names = tuple(channel.name for channel in channels)
    if len(set(names)) < len(names):
        names = tuple(map(str, range(len(names))))
    return Signal(samples.astype(np.float32), rate, "1", names)


def _seconds(channel: Channel, timescale: float) -> float:
    if channel.rate and channel.count:
        return channel.count / channel.rate
    tail = TRANSIENT_MS / 1e3 * timescale
    ends = [
        effect.position + effect.end + (tail if band.kind == "Transient" else 0.0)
        for band in channel.bands
        for effect in band.effects
    ]
    return max([0.0, *ends]) / timescale


def _played(channel: Channel, ticks: Line, timescale: float) -> Line:
    total = np.zeros(len(ticks))
    for band in channel.bands:
        for effect in band.effects:
            at = ticks - effect.position
            if band.kind == "Curve":
                total += _curve(band.curve, effect, at)
            else:
                total += (_wave if band.kind == "VectorialWave" else _transients)(band, effect, at, timescale)
    return np.clip(total, -1, 1) * channel.gain


def _curve(kind: str, effect: Effect, at: Line) -> Line:
    places, values = effect.amplitude
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


def _wave(band: Band, effect: Effect, at: Line, timescale: float) -> Line:
    (places, strength), (turns, frequency) = effect.amplitude, effect.frequency
    inside = (at >= 0) & (at <= effect.end)
    amplitude = np.interp(at, places, strength) if len(places) else np.ones(len(at))
    if not len(turns):
        return np.zeros(len(at))
    f = np.clip(np.interp(at, turns, frequency), band.low, band.high)
    step = (at[1] - at[0]) / timescale if len(at) > 1 else 0.0
    cycles = np.cumsum(np.where(inside, f, 0.0)) * step
    first = int(np.argmax(inside))
    cycles = cycles - cycles[first] + effect.phase / (2 * np.pi)
    return np.where(inside, amplitude * _base(effect.base, cycles), 0.0)


def _base(name: str, cycles: Line) -> Line:
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


def _transients(_: Band, effect: Effect, at: Line, timescale: float) -> Line:
    """Return two periods of a sine in `TRANSIENT_MS` at each keyframe, at any frequency, as the reference does."""
    length = TRANSIENT_MS / 1e3 * timescale
    total = np.zeros(len(at))
    for place, strength in effect.amplitude.T:
        away = at - place
        total += np.where((away >= 0) & (away <= length), strength * np.sin(4 * np.pi * away / length), 0.0)
    return total

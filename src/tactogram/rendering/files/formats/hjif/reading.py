"""Reader of HJIF documents: their events, and their waveform.

Playback follows the reference software (MPEGGroup/HapticReferenceSoftware, BSD): interpolation, ticks, base signals,
and that a channel's bands are added, clipped to -1..1 and multiplied by its gain. Wavelet bands have no public
description; such files need the reference software's Synthesizer.
"""

from __future__ import annotations

import numpy as np
from scipy import interpolate

from tactogram.rendering.files.analysis import READ_RATE
from tactogram.rendering.files.documents import DecodedDocument, Node, sample_count
from tactogram.rendering.files.events import JUMP_S, UNKNOWN_HZ, Events, Line, Part, Transient, joined
from tactogram.rendering.files.formats.hjif.rules import BASES, Channel, Effect, channels_of
from tactogram.signal import Signal
from tactogram.signal.io.description import decode as read_description

TRANSIENT_S = 0.022
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
    seconds = max(_seconds(channel) for channel in channels)
    if own is None and not seconds > 0:
        notes.problems.append("the file's channels have no length")
    notes.check()
    usual = max(channel.rate for channel in channels) or READ_RATE
    sample_count(seconds, usual)
    for effect in (effect for channel in channels for effect in channel.effects):
        if effect.kind == "VectorialWave" and not effect.frequency.size:
            notes.warn("a VectorialWave effect must have a frequency", done="left out")
    waves = all(
        effect.kind == "Transient" or (effect.kind == "VectorialWave" and effect.base == "Sine")
        for channel in channels
        for effect in channel.effects
    )
    left_out = [f"{len(perceptions) - 1} further perceptions"] if len(perceptions) > 1 else []
    if waves and len(channels) > 1:
        left_out.append(f"of {len(channels)} channels as events all but the strongest at any time")

    def waveform(rate: float | None) -> Signal:
        exact = own is not None and rate in (None, own.rate) and channels[0].rate == max(1, round(own.rate))
        count = channels[0].count if exact else 0
        rate = rate or (own.rate if own else usual)
        at = np.arange(max(1, count or sample_count(seconds, rate)))
        # Samples that this package wrote are whole ticks apart.
        t = at * round(timescale / rate) / timescale if count else at / rate
        samples = np.stack([_played(channel, t) for channel in channels]).astype(np.float32)
        names = tuple(channel.name for channel in channels)
        unique = len(set(names)) == len(names)
        return Signal(samples, rate, "1", names if unique else tuple(map(str, range(len(names)))))

    events = _events(channels, seconds) if waves else None
    return DecodedDocument(
        events, description, left_out=", ".join(left_out), modality=modality, waveform=waveform
    )


def _events(channels: list[Channel], seconds: float) -> Events:
    parts: list[list[Part]] = []
    taps: list[Transient] = []
    for channel in channels:
        parts.append([])
        for effect in channel.effects:
            (times, strength), (turns, hz) = effect.amplitude, effect.frequency
            if effect.kind == "Transient":
                tones = np.interp(times, turns, hz) if len(turns) else np.full(len(times), UNKNOWN_HZ)
                shares = np.minimum(np.abs(channel.gain * strength), 1)
                taps += [Transient(*tap) for tap in np.stack([times, shares, tones]).T.tolist()]
            elif len(turns) and effect.end > effect.start:
                # The first and the last strength hold beside them.
                at = np.union1d(times, [effect.start, effect.end])
                shares = np.minimum(np.abs(channel.gain * np.interp(at, times, strength)), 1)
                parts[-1].append(Part.of(at, shares, turns, np.clip(hz, effect.low, effect.high)))
    if len(channels) > 1:
        taps = list({one.time: one for one in sorted(taps, key=lambda one: one.amplitude)}.values())
    strongest = [joined([joined(own) for own in parts if own], strongest=True)]
    return Events.of(parts[0] if len(parts) == 1 else strongest, taps, seconds)


def _seconds(channel: Channel) -> float:
    if channel.rate and channel.count:
        return channel.count / channel.rate
    return max([0.0, *(one.end + TRANSIENT_S * (one.kind == "Transient") for one in channel.effects)])


def _played(channel: Channel, t: Line) -> Line:
    played = {"Curve": _curve, "VectorialWave": _wave, "Transient": _transients}
    total: Line = sum((played[effect.kind](effect, t) for effect in channel.effects), np.zeros(len(t)))
    return np.asarray(np.clip(total, -1, 1) * channel.gain)


def _curve(effect: Effect, t: Line) -> Line:
    times, values = effect.amplitude
    if not len(times):
        return np.zeros(len(t))
    if effect.curve == "Linear" or len(times) <= 2:
        line = np.interp(t, times, values)
    elif effect.curve == "Akima" and np.diff(times).min() > 2 * JUMP_S:
        line = interpolate.Akima1DInterpolator(times, values)(t)
    else:
        # Cubic or unspecified: horizontal at every keyframe, as the reference software's Hermite polynomial. Akima's
        # slopes would overshoot at a jump.
        line = interpolate.CubicHermiteSpline(times, values, np.zeros(len(times)))(t)
    return np.where((t >= times[0]) & (t <= times[-1]), line, 0.0)


def _wave(effect: Effect, t: Line) -> Line:
    if not effect.frequency.size or len(t) < 2:
        return np.zeros(len(t))
    inside = (t >= effect.start) & (t <= effect.end)
    hz = np.clip(np.interp(t, *effect.frequency), effect.low, effect.high)
    phase = 2 * np.pi * (t[1] - t[0]) * np.cumsum(np.where(inside, hz, 0.0))
    phase += effect.phase - phase[np.argmax(inside)]
    return np.where(inside, np.interp(t, *effect.amplitude) * BASES[effect.base](phase), 0.0)


def _transients(effect: Effect, t: Line) -> Line:
    """Return two periods of a sine in `TRANSIENT_S` at each keyframe, at any frequency, as the reference does."""
    total = np.zeros(len(t))
    for time, strength in effect.amplitude.T:
        away = (t - time) / TRANSIENT_S
        total += np.where((away >= 0) & (away <= 1), strength * np.sin(4 * np.pi * away), 0.0)
    return total

"""Reader of HJIF documents (ISO/IEC 23090-31): their events, and their waveform.

The standard's JSON schema is not public. Required members, ranges and vocabulary are from the reference software
(MPEGGroup/HapticReferenceSoftware, BSD), and so is playback: interpolation, ticks, base signals, and that a channel's
bands are added, clipped to -1..1 and multiplied by its gain. What only describes, or has an evident default, is a
warning where it is wrong. Wavelet bands have no public description; such files need that software's Synthesizer.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import interpolate, signal

from tactogram.rendering.files.analysis import READ_RATE
from tactogram.rendering.files.documents import DecodedDocument, Node, sample_count
from tactogram.rendering.files.events import (
    JUMP_S,
    UNKNOWN_HZ,
    Events,
    Line,
    Part,
    Transient,
    increasing,
    joined,
)
from tactogram.signal import Signal
from tactogram.signal.io.content import decode as read_description

MOST_TICKS = 48_000
MODALITIES = (
    *(
        "Other",
        "Pressure",
        "Acceleration",
        "Velocity",
        "Position",
        "Temperature",
        "Vibrotactile",
        "Water",
        "Wind",
    ),
    *("Force", "Vibrotactile Texture", "Stiffness", "Friction", "Electrotactile"),
)
BASES: dict[str, Callable[[Line], Line]] = {
    "Sine": np.sin,
    "Square": signal.square,
    "Triangle": lambda phase: np.asarray(signal.sawtooth(phase + np.pi / 2, 0.5)),
    "SawToothUp": lambda phase: np.asarray(signal.sawtooth(phase + np.pi)),
    "SawToothDown": lambda phase: -signal.sawtooth(phase + np.pi),
}
"""Base signals of a phase in radians."""
BANDS = ("Transient", "Curve", "VectorialWave", "WaveletWave")
CURVES = ("Unknown", "Cubic", "Linear", "Akima", "Bezier", "Bspline")
REQUIRED = {
    "document": ("version", "profile", "level", "date", "description", "avatars", "syncs"),
    "perception": ("id", "avatar_id", "description", "effect_library"),
    "channel": ("id", "description", "gain", "mixing_coefficient", "body_part_mask"),
}
"""Members that are required, and that can be done without."""
_RENDER = "render the file to a WAV with the MPEG reference software's Synthesizer"
TRANSIENT_S = 0.022
"""Length of a transient, two periods of a sine, in the reference software."""


@dataclass(frozen=True, eq=False)
class Effect:
    """Section of a band of a channel, from ``start`` to ``end`` (s).

    ``kind``, the type of the ``curve`` and the limits ``low`` and ``high`` (Hz) are the band's. Keyframes of amplitude
    and of frequency (Hz) are float64 arrays, shape (time and value, keyframe), the times in s, each after the one
    before.
    """

    kind: str
    curve: str
    low: float
    high: float
    start: float
    end: float
    phase: float
    base: str
    amplitude: Line
    frequency: Line


@dataclass(frozen=True)
class Channel:
    """Signal of a perception; ``rate`` (Hz) and ``count`` of samples are 0 where they are not stated."""

    name: str
    gain: float
    rate: float
    count: int
    effects: tuple[Effect, ...]


def channels_of(document: Node) -> tuple[float, list[tuple[str, list[Channel]]]]:
    """Return the ticks per second, and the modality and the channels of each perception."""
    notes = document.notes
    _require(document, "document")
    level = document.number("level", 1, 1, 2)
    version = document.text("version", "2023")
    if not re.fullmatch(r"20\d\d(-\d)?", version) or int(version[:4]) < 2023:
        notes.warn("version must be a year from 2023 on, such as 2023 or 2023-1", version)
    timescale = document.number("timescale", None, 1, MOST_TICKS)
    if (
        _one_of(document, "profile", ("Main", "Simple Parametric")) == "Simple Parametric"
        and timescale != 1000
    ):
        notes.warn("timescale of Simple Parametric must be 1000", f"{timescale:g}")
    perceptions = document.nodes("perceptions")
    _check_unique(perceptions, "perception")
    pairs = []
    for perception in perceptions:
        _require(perception, "perception")
        channels = perception.nodes("channels")
        _check_unique(channels, "channel")
        most = 127 if level == 1 else 65_535
        if len(channels) > most:
            notes.warn(f"level {level:g} holds {most} channels at most", len(channels))
        ready = [_channel(channel, level, timescale) for channel in channels]
        pairs.append((_one_of(perception, "perception_modality", MODALITIES), ready))
    return timescale, pairs


def _channel(node: Node, level: float, timescale: float) -> Channel:
    _require(node, "channel")
    bands = node.nodes("bands")
    if level == 1 and len(bands) > 7:
        node.notes.warn("level 1 holds 7 bands per channel at most", len(bands))
    return Channel(
        node.text("description") or str(node.value.get("id")),
        node.number("gain", 1.0),
        node.number("frequency_sampling", 0, 0),
        int(node.number("sample_count", 0, 0)),
        tuple(effect for band in bands for effect in _band(band, timescale)),
    )


def _band(node: Node, timescale: float) -> list[Effect]:
    notes = node.notes
    kind, curve = _one_of(node, "band_type", BANDS), _one_of(node, "curve_type", CURVES, required=False)
    low, high = node.number("lower_frequency_limit", 0, 0), node.number("upper_frequency_limit", 1000, 0)
    if low > high:
        notes.warn("lower_frequency_limit must not be above the upper", f"{low:g} and {high:g}")
    if kind == "WaveletWave":
        notes.problems.append(
            f"WaveletWave bands cannot be read, since their coding is not public; {_RENDER}"
        )
    elif kind == "Curve" and curve in ("Bezier", "Bspline"):
        notes.problems.append(f"curves of type {curve} cannot be read; use Linear, Cubic or Akima")
    return [_effect(effect, timescale, kind, curve, low, max(low, high)) for effect in node.nodes("effects")]


def _effect(node: Node, timescale: float, kind: str, curve: str, low: float, high: float) -> Effect:
    if (type_ := node.text("effect_type", "Basis")) != "Basis":
        node.notes.problems.append(f"{type_} effects cannot be read; {_RENDER}")
    base = _one_of(node, "base_signal", tuple(BASES), required=False)
    position, phase = node.number("position", 0), node.number("phase", 0)
    lines, end = [], 0.0
    frames = [key for key in node.list("keyframes", optional=True) if isinstance(key, dict)]
    for name in ("amplitude_modulation", "frequency_modulation"):
        stated = [key for key in frames if key.get(name) is not None]
        try:
            line = np.array([(key.get("relative_position") or 0, key[name]) for key in stated], np.float64)
        except (TypeError, ValueError):
            node.notes.problems.append(f"{node.place}.keyframes: {name} must be numbers at relative_position")
            line = np.zeros((0, 2))
        places, values = line.reshape(-1, 2).T
        if (np.diff(places) < 0).any():
            node.notes.warn("keyframes must be in order of relative_position", done="sorted")
        order = np.argsort(places, kind="stable")
        places = np.maximum(places[order], 0)
        end = max([end, *places[-1:].tolist()])
        lines.append(np.stack([increasing((position + places) / timescale), values[order]]))
    amplitude, frequency = lines
    start, end = position / timescale, (position + end) / timescale
    if kind == "VectorialWave" and not amplitude.size:
        amplitude = np.array([[start], [1.0]])
    return Effect(kind, curve, low, high, start, end, phase, base, amplitude, frequency)


def _one_of(node: Node, key: str, names: tuple[str, ...], *, required: bool = True) -> str:
    """Return a word of a vocabulary, its first one if there is none."""
    word = node.text(key)
    if word not in names and (word or required):
        node.notes.problems.append(f"{node.place}.{key}: must be one of {', '.join(names)}, got {word!r}")
    return word if word in names else names[0]


def _require(node: Node, kind: str) -> None:
    for key in REQUIRED[kind]:
        if not node.has(key):
            node.notes.warn(f"{key}: is required of a {kind}")


def _check_unique(nodes: list[Node], what: str) -> None:
    ids = [node.value.get("id") for node in nodes]
    if len({str(entry) for entry in ids}) < len(ids):
        nodes[0].notes.warn(f"each {what} must have a unique id", ids)


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document's first perception, and its channels as waveforms, one axis each.

    It has events if it consists of transients and waves of sines; of several channels the strongest counts. The rate
    (Hz) is by default the one in the description of a file written by this package (ticks and ``frequency_sampling``
    are integers), else the channels' ``frequency_sampling``, else `READ_RATE`.
    """
    notes = document.notes
    timescale, perceptions = channels_of(document)
    modality, channels = next((perception for perception in perceptions if perception[1]), ("", []))
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
        index = np.arange(max(1, count or sample_count(seconds, rate)))
        # Samples that this package wrote are whole ticks apart.
        t = index * round(timescale / rate) / timescale if count else index / rate
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
                instants = np.union1d(times, [effect.start, effect.end])
                shares = np.minimum(np.abs(channel.gain * np.interp(instants, times, strength)), 1)
                parts[-1].append(Part.of(instants, shares, turns, np.clip(hz, effect.low, effect.high)))
    if len(channels) > 1:
        taps = list({tap.time: tap for tap in sorted(taps, key=lambda tap: tap.amplitude)}.values())
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

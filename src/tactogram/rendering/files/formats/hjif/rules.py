"""Content of an HJIF document (ISO/IEC 23090-31), and what the reference software requires of it.

The standard's JSON schema is not public. Required members, ranges and vocabulary are from the reference software
(MPEGGroup/HapticReferenceSoftware, BSD). What only describes, or has an evident default, is a warning
where it is wrong.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import signal

from tactogram.rendering.files.documents import Node
from tactogram.rendering.files.events import Line, increasing

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
    found = []
    for one in perceptions:
        _require(one, "perception")
        channels = one.nodes("channels")
        _check_unique(channels, "channel")
        most = 127 if level == 1 else 65_535
        if len(channels) > most:
            notes.warn(f"level {level:g} holds {most} channels at most", len(channels))
        ready = [_channel(channel, level, timescale) for channel in channels]
        found.append((_one_of(one, "perception_modality", MODALITIES), ready))
    return timescale, found


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
    return [_effect(one, timescale, kind, curve, low, max(low, high)) for one in node.nodes("effects")]


def _effect(node: Node, timescale: float, kind: str, curve: str, low: float, high: float) -> Effect:
    if (type_ := node.text("effect_type", "Basis")) != "Basis":
        node.notes.problems.append(f"{type_} effects cannot be read; {_RENDER}")
    base = _one_of(node, "base_signal", tuple(BASES), required=False)
    position, phase = node.number("position", 0), node.number("phase", 0)
    lines, end = [], 0.0
    frames = [one for one in node.list("keyframes", optional=True) if isinstance(one, dict)]
    for name in ("amplitude_modulation", "frequency_modulation"):
        stated = [one for one in frames if one.get(name) is not None]
        try:
            line = np.array([(one.get("relative_position") or 0, one[name]) for one in stated], np.float64)
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
    if len({str(one) for one in ids}) < len(ids):
        nodes[0].notes.warn(f"each {what} must have a unique id", ids)

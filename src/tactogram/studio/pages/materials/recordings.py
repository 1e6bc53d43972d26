"""The recordings of a data set as pages show them: filtered, page by page, with pictures that are made once."""

from __future__ import annotations

import io
from collections import Counter, OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock

import numpy as np
from PIL import Image as Pillow

from tactogram.datasets import RecordingInfo, Store, open_store
from tactogram.errors import ParameterError
from tactogram.recipe import Preparation
from tactogram.signal import Signal
from tactogram.studio.workspace.folder import Workspace

ANY = ""
FIELDS = ("contactor", "session", "subject", "speed_mm_s", "force_n")
"""What can be filtered by besides material and text."""
NAMES = {
    "speed_mm_s": "speed",
    "force_n": "force",
    "direction_deg": "direction",
}
UNITS = {"speed_mm_s": "mm/s", "force_n": "N", "direction_deg": "degrees"}
GLANCE_S = 4.0
"""How much of a recording a small picture shows, s (mm over displacement)."""


@dataclass
class StoreCache:
    """Open data sets of a workspace: one is opened anew when its ``dataset.json`` was replaced.

    Parameters
    ----------
    workspace : Workspace
    """

    workspace: Workspace
    most: int = 8
    _open: OrderedDict[Path, tuple[int, Store]] = field(default_factory=OrderedDict, repr=False)
    _lock: Lock = field(default_factory=Lock, repr=False)

    def get(self, name: str) -> Store:
        """Return a data set by its path relative to the workspace.

        Raises
        ------
        ParameterError
            If the path leads out of the workspace.
        DataError
            If it is no data set.
        """
        path = self.workspace.inside(name)
        file = path / "dataset.json"
        changed = file.stat().st_mtime_ns if file.is_file() else 0
        with self._lock:
            held = self._open.get(path)
            if held is None or held[0] != changed:
                held = (changed, open_store(path))
                self._open[path] = held
            self._open.move_to_end(path)
            while len(self._open) > self.most:
                self._open.popitem(last=False)
        return held[1]


@dataclass(frozen=True)
class RecordingFilter:
    """Filter of recordings: all conditions must hold.

    Parameters
    ----------
    text : str
        Stands somewhere in what is known of a recording, in any case.
    material : str
    fields : mapping from str to str
        By `FIELDS`.
    """

    text: str = ANY
    material: str = ANY
    fields: Mapping[str, str] = field(default_factory=dict)

    def __call__(self, info: RecordingInfo) -> bool:
        """Say whether a recording is asked for."""
        if self.material and (info.material or "") != self.material:
            return False
        if any(value and shown_value(info, name) != value for name, value in self.fields.items()):
            return False
        if not self.text:
            return True
        known = (info.id, info.material, info.source, info.contactor, info.session, info.subject)
        held = " ".join(str(value) for value in (*known, *info.labels.values()) if value)
        return all(word in held.lower() for word in self.text.lower().split())


def filtered(index: Sequence[RecordingInfo], asked: RecordingFilter) -> list[RecordingInfo]:
    """Return the recordings that are asked for, in the order of the data set."""
    return [info for info in index if asked(info)]


def choices(index: Sequence[RecordingInfo], *, most: int = 200) -> dict[str, list[str]]:
    """Return the values of each of `FIELDS` that has more than one, at most ``most`` of each."""
    found: dict[str, Counter[str]] = {name: Counter() for name in FIELDS}
    for info in index:
        for name in FIELDS:
            if value := shown_value(info, name):
                found[name][value] += 1
    return {name: _sorted(list(held))[:most] for name, held in found.items() if len(held) > 1}


def shown_value(info: RecordingInfo, name: str) -> str:
    """Return a field as text; empty where it is not known."""
    value = getattr(info, name)
    if value is None:
        return ""
    return f"{value:g}" if isinstance(value, float | int) else str(value)


def describe_recording(info: RecordingInfo) -> list[tuple[str, str]]:
    """Return all that is known of a recording, as names and texts with units."""
    found = [("material", info.material or "not said")]
    conditions = ("speed_mm_s", "force_n", "direction_deg", "contactor", "session", "subject")
    found += [
        (NAMES.get(name, name), f"{text} {UNITS.get(name, '')}".strip())
        for name in conditions
        if (text := shown_value(info, name))
    ]
    found += [(name, str(value)) for name, value in info.labels.items()]
    found += [(f"rated {word}", f"{score:g}") for word, score in info.ratings.items()]
    found.append(("source", info.source or "not said"))
    if info.history:
        found.append(("history", "; ".join(info.history)))
    return [*found, ("id", info.id)]


def page_of(count: int, page: int, size: int) -> tuple[int, int, int]:
    """Return a page's number within bounds (from 1), and its first and last place (exclusive) of ``count``."""
    pages = max(1, -(-count // size))
    page = min(max(1, page), pages)
    return page, (page - 1) * size, min(count, page * size)


def stream_of(store: Store, id: str, stream: str = "") -> str:
    """Return the stream of a recording that is shown: the one asked for, else as in training."""
    return Preparation(stream=stream or None).stream_of(store.streams_of(id))


def recording_excerpt(store: Store, id: str, stream: str = "") -> Signal:
    """Return the beginning of a recording, for a small picture."""
    name = stream_of(store, id, stream)
    most = max(2, round(GLANCE_S * store.rate(id, name)))
    return store.signal(id, name, stop=min(store.length(id, name), most))


def trace_svg(signal: Signal, *, width: int = 240, height: int = 56) -> bytes:
    """Return the waveform of the axis that moves most as SVG: least and greatest of each pixel, about its mean."""
    x = signal.samples.astype(np.float64)
    x = x - x.mean(axis=1, keepdims=True)
    x = x[int(x.var(axis=1).argmax())]
    edges = np.linspace(0, len(x), min(width, len(x)) + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(x, edges), np.maximum.reduceat(x, edges)
    peak = float(np.abs(x).max()) or 1.0
    middle, scale = height / 2, (height / 2 - 1) / peak
    step = width / len(edges)
    top = [f"{place * step:.1f},{middle - value * scale:.1f}" for place, value in enumerate(high)]
    bottom = [f"{place * step:.1f},{middle - value * scale:.1f}" for place, value in enumerate(low)]
    points = " ".join([*top, *reversed(bottom)])
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" preserveAspectRatio="none">'
        f'<polygon points="{points}" fill="#0b5d66" stroke="#0b5d66" stroke-width="0.8"/></svg>'
    ).encode()


def thumbnail(store: Store, key: str, *, size: int) -> bytes:
    """Return a photograph as JPEG, cut to a square of ``size`` pixels.

    Raises
    ------
    ParameterError
        If ``size`` is not 16 to 1024.
    """
    if not 16 <= size <= 1024:
        raise ParameterError(f"size must be 16 to 1024, got {size}")
    pixels = store.photograph(key).pixels
    side = min(pixels.shape[:2])
    top, left = (pixels.shape[0] - side) // 2, (pixels.shape[1] - side) // 2
    picture = Pillow.fromarray(pixels[top : top + side, left : left + side])
    out = io.BytesIO()
    picture.resize((size, size), Pillow.Resampling.LANCZOS).save(out, "JPEG", quality=85)
    return out.getvalue()


def picture_of(store: Store, info: RecordingInfo) -> str | None:
    """Return the key of a picture of a recording: its own, else one of its material."""
    own = store.image_id(info.id)
    if own is not None or info.material is None:
        return own
    return next(iter(store.photographs_of(info.material)), None)


def _sorted(values: list[str]) -> list[str]:
    try:
        return sorted(values, key=float)
    except ValueError:
        return sorted(values)

"""Recordings of a store: filters, pages, descriptions and small pictures."""

from __future__ import annotations

import io
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np
from PIL import Image as Pillow, ImageOps

from tactogram.datasets import RecordingInfo, Store, open_store
from tactogram.errors import ParameterError
from tactogram.recipe import Preparation
from tactogram.signal import Signal
from tactogram_studio.workspace.folder import Workspace

FIELDS = ("contactor", "session", "subject", "speed_mm_s", "force_n")
"""Fields to filter by, besides material and text."""
NAMES = {"speed_mm_s": "speed", "force_n": "force", "direction_deg": "direction"}
UNITS = {"speed_mm_s": "mm/s", "force_n": "N", "direction_deg": "degrees"}
PICTURE_S = 4.0
"""Length of the start of a recording that a small picture shows, s (mm over displacement)."""


def open_named(workspace: Workspace, name: str) -> Store:
    """Return a store by its path relative to the workspace; it is reopened only when its ``dataset.json`` changes."""
    path = workspace.inside(name)
    file = path / "dataset.json"
    return _open(path, file.stat().st_mtime_ns if file.is_file() else 0)


@lru_cache(maxsize=8)
def _open(path: Path, changed_ns: int) -> Store:
    return open_store(path)


@dataclass(frozen=True)
class RecordingFilter:
    """Filter of recordings by words, material and `FIELDS`; empty conditions match everything."""

    text: str = ""
    material: str = ""
    fields: Mapping[str, str] = field(default_factory=dict)

    def matches(self, info: RecordingInfo) -> bool:
        """Return whether a recording meets all conditions; words match its texts and labels in any case."""
        if self.material and (info.material or "") != self.material:
            return False
        if any(value and shown_value(info, name) != value for name, value in self.fields.items()):
            return False
        if not self.text:
            return True
        texts = (info.id, info.material, info.source, info.contactor, info.session, info.subject)
        searched = " ".join(str(value) for value in (*texts, *info.labels.values()) if value).lower()
        return all(word in searched for word in self.text.lower().split())


def filtered(index: Sequence[RecordingInfo], chosen: RecordingFilter) -> list[RecordingInfo]:
    """Return the recordings that match a filter, in the order of the store."""
    return [info for info in index if chosen.matches(info)]


def choices(index: Sequence[RecordingInfo], *, most: int = 200) -> dict[str, list[str]]:
    """Return up to ``most`` sorted values of each of `FIELDS` that has more than one."""
    values = {name: {shown_value(info, name) for info in index} - {""} for name in FIELDS}
    return {name: _sorted(each)[:most] for name, each in values.items() if len(each) > 1}


def shown_value(info: RecordingInfo, name: str) -> str:
    """Return a field as text; empty if unknown."""
    value = getattr(info, name)
    if value is None:
        return ""
    return f"{value:g}" if isinstance(value, float | int) else str(value)


def describe_recording(info: RecordingInfo) -> list[tuple[str, str]]:
    """Return the metadata of a recording, as names and texts with units."""
    items = [("material", info.material or "unknown")]
    conditions = ("speed_mm_s", "force_n", "direction_deg", "contactor", "session", "subject")
    items += [
        (NAMES.get(name, name), f"{text} {UNITS.get(name, '')}".strip())
        for name in conditions
        if (text := shown_value(info, name))
    ]
    items += [(name, str(value)) for name, value in info.labels.items()]
    items += [(f"rating of {word}", f"{score:g}") for word, score in info.ratings.items()]
    items.append(("source", info.source or "unknown"))
    if info.history:
        items.append(("history", "; ".join(info.history)))
    return [*items, ("id", info.id)]


def page_bounds(count: int, page: int, size: int) -> tuple[int, int, int]:
    """Return a page's number (from 1, limited to existing pages), and its first and last (exclusive) index."""
    pages = max(1, -(-count // size))
    page = min(max(1, page), pages)
    return page, (page - 1) * size, min(count, page * size)


def stream_of(store: Store, id: str, stream: str = "") -> str:
    """Return the stream of a recording to show: ``stream``, or the one that training uses by default."""
    return Preparation(stream=stream or None).stream_of(store.streams_of(id))


def recording_start(store: Store, id: str, stream: str = "") -> Signal:
    """Return the start of a recording, for a small picture."""
    name = stream_of(store, id, stream)
    most = max(2, round(PICTURE_S * store.rate(id, name)))
    return store.signal(id, name, stop=min(store.length(id, name), most))


def trace_svg(signal: Signal, *, width: int = 240, height: int = 56) -> bytes:
    """Return the waveform of the axis with the largest variance as SVG: minimum and maximum per pixel, mean removed."""
    x = signal.samples.astype(np.float64)
    x = x - x.mean(axis=1, keepdims=True)
    x = x[int(x.var(axis=1).argmax())]
    edges = np.linspace(0, len(x), min(width, len(x)) + 1).astype(int)[:-1]
    low, high = np.minimum.reduceat(x, edges), np.maximum.reduceat(x, edges)
    peak = float(np.abs(x).max()) or 1.0
    middle, scale = height / 2, (height / 2 - 1) / peak
    step = width / len(edges)
    top = [f"{column * step:.1f},{middle - value * scale:.1f}" for column, value in enumerate(high)]
    bottom = [f"{column * step:.1f},{middle - value * scale:.1f}" for column, value in enumerate(low)]
    points = " ".join([*top, *reversed(bottom)])
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" preserveAspectRatio="none">'
        f'<polygon points="{points}" fill="#2b8a95" stroke="#2b8a95" stroke-width="0.8"/></svg>'
    ).encode()


def thumbnail(store: Store, key: str, *, size: int) -> bytes:
    """Return a photograph as JPEG, cropped to a square of ``size`` pixels (16 to 1024)."""
    if not 16 <= size <= 1024:
        raise ParameterError.must("size", "be 16 to 1024", size)
    picture = Pillow.fromarray(store.photograph(key).pixels)
    out = io.BytesIO()
    ImageOps.fit(picture, (size, size), Pillow.Resampling.LANCZOS).save(out, "JPEG", quality=85)
    return out.getvalue()


def picture_of(store: Store, info: RecordingInfo) -> str | None:
    """Return the key of a recording's own photograph, or else of one of its material."""
    own = store.image_id(info.id)
    if own is not None or info.material is None:
        return own
    return next(iter(store.photographs_of(info.material)), None)


def _sorted(values: Collection[str]) -> list[str]:
    try:
        return sorted(values, key=float)
    except ValueError:
        return sorted(values)

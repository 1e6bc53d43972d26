"""Recording: named streams and the metadata of one measurement."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Literal

import numpy as np

from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io.content import ColumnUse
from tactogram.signal.timing import SamplingTiming


@dataclass(frozen=True, kw_only=True)
class RecordingInfo:
    """Metadata of a recording; None where unknown.

    Parameters
    ----------
    id : str
        Hash of the streams (`content_id`): equal samples are the same recording.
    material : str, optional
        What was touched.
    speed_mm_s, force_n, direction_deg : float, optional
        Nominal stroking speed (mm/s), normal force (N), direction of the stroke in the surface (degrees).
    contactor : str, optional
        What touched it, e.g. ``"finger"`` or ``"pen"``.
    session, subject : str, optional
    ratings : mapping from str to float
        Word ratings by people.
    labels : mapping from str to str
        Further metadata of the source.
    source : str
        File it came from, relative to the imported folder.
    history : tuple of str
        Processing steps, in order.
    simulated : bool
        Whether it was computed rather than measured.
    """

    id: str = ""
    material: str | None = None
    speed_mm_s: float | None = None
    force_n: float | None = None
    direction_deg: float | None = None
    contactor: str | None = None
    session: str | None = None
    subject: str | None = None
    ratings: Mapping[str, float] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)
    source: str = ""
    history: tuple[str, ...] = ()
    simulated: bool = False


@dataclass(frozen=True)
class FileReading:
    """Columns and timing with which a recording's file was read."""

    columns: tuple[ColumnUse, ...]  # of all its tables; none for sounds
    mapped: bool  # whether a mapping decided about the columns
    timing: SamplingTiming | None  # of the time stamps, if there are any
    rate_estimated: bool  # whether the rate follows from the time stamps alone
    notes: tuple[str, ...] = ()  # one line each, on what was left out or assumed
    tables: tuple[int, ...] = ()  # number of columns of each file, if it has several


@dataclass(frozen=True, eq=False, kw_only=True)
class Recording(RecordingInfo):
    """One or more named signals, each at its own rate, with their metadata.

    Parameters
    ----------
    streams : mapping from str to Signal
        By name: ``acceleration``, ``force``, ``position``, ``sound``, ``friction``, …
    image : Image, optional
        A photograph of the surface.
    reading : FileReading, optional
        For an import; it is not stored.
    **info
        Fields of `RecordingInfo`; an empty ``id`` is computed from the streams.
    """

    streams: Mapping[str, Signal]
    image: Image | None = None
    reading: FileReading | None = None

    def __post_init__(self) -> None:
        if not self.streams:
            raise ParameterError("a recording needs at least one stream, got none")
        if not self.id:
            object.__setattr__(self, "id", content_id(self.streams))

    def stream(self, name: str) -> Signal:
        """Return one stream; `ParameterError` if there is none of this name."""
        if name not in self.streams:
            raise ParameterError.one_of("stream", self.streams, name)
        return self.streams[name]

    @property
    def info(self) -> RecordingInfo:
        """The metadata alone, without samples and image."""
        return RecordingInfo(**{f.name: getattr(self, f.name) for f in fields(RecordingInfo)})


def content_id(streams: Mapping[str, Signal]) -> str:
    """Return 16 hex digits that identify ``streams`` by their names, rates, units, axes and samples."""
    digest = hashlib.sha256()
    for name in sorted(streams):
        s = streams[name]
        digest.update(f"{name}|{s.rate!r}|{s.unit}|{','.join(s.axes)}|{s.domain}|{len(s)}|".encode())
        digest.update(np.ascontiguousarray(s.samples, "<f4").reshape(-1).data)
    return digest.hexdigest()[:16]


def natural_key(text: str) -> list[tuple[int, int, str]]:
    """Return a key that sorts texts with their numbers in numerical order."""
    return [(0, int(p), "") if p.isdecimal() else (1, 0, p) for p in re.split(r"(\d+)", text) if p]


def item_of(info: RecordingInfo) -> str | None:
    """Return the item that a recording belongs to in ratings: its label ``item``, else its material."""
    return info.labels.get("item") or info.material


LabelName = Literal["material", "material+contactor", "item"]
Label = LabelName | Callable[[RecordingInfo], str | None]
"""Class of a recording: its material; material and contactor, as ``"carpet1-pen"``; what is rated, which may be a
single vibration of no material; or the value of a function."""


def label_of(info: RecordingInfo, label: Label) -> str | None:
    """Return the class of one recording, None if it has none.

    ``"material+contactor"`` gives the 30 classes of Saga et al. (Table I); a recording without a contactor has its
    material's class. Raises `ParameterError` for another label.
    """
    if callable(label):
        return label(info)
    if label == "material":
        return info.material
    if label == "item":
        return item_of(info)
    if label == "material+contactor":
        return "-".join(part for part in (info.material, info.contactor) if part) or None
    raise ParameterError.must("label", "be 'material', 'material+contactor', 'item' or a function", label)

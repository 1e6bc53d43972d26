"""Splits that cannot leak: by recording, session, subject, material or condition, saved as files.

A window, an augmentation or a weak pair is cut *after* the split, from the segments and photographs of one part.
"""

from __future__ import annotations

import json
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from itertools import combinations, pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator

from tactogram.errors import DataError, LeakError, ParameterError
from tactogram.signal.io.atomic import write_text
from tactogram.text_files import read_json
from tactogram.validation import facts_of

By = Literal["recording", "session", "subject", "material", "condition"]
"""What stays together in one part of a split."""

FORMAT = "tactogram-split"
VERSION = 1


@dataclass(frozen=True)
class Segment:
    """A recording, or an interval of one.

    It goes from ``start_s`` to ``stop_s``, s, or mm for a stream over displacement; None is the end.
    """

    id: str
    start_s: float = 0.0
    stop_s: float | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.start_s) and self.start_s >= 0):
            raise ParameterError(f"start of a segment must be >= 0 s, got {self.start_s}")
        if self.stop_s is not None and not self.start_s < self.stop_s < math.inf:
            raise ParameterError(f"a segment must end after {self.start_s:g} s, got {self.stop_s}")


@dataclass(frozen=True)
class Region:
    """A photograph, or a rectangle of one.

    Parameters
    ----------
    key : str
        Of the photograph in its store.
    top, left : int, pixels
        First row and column.
    bottom, right : int, pixels, optional
        Row and column after the last; None is the edge of the photograph.
    """

    key: str
    top: int = 0
    left: int = 0
    bottom: int | None = None
    right: int | None = None

    def __post_init__(self) -> None:
        for first, last, names in ((self.top, self.bottom, "rows"), (self.left, self.right, "columns")):
            if first < 0 or (last is not None and last <= first):
                raise ParameterError(f"{names} of a region must be 0 <= first < last, got {first} to {last}")

    @property
    def whole(self) -> bool:
        """Whether it is all of the photograph."""
        return (self.top, self.left, self.bottom, self.right) == (0, 0, None, None)

    def distance(self, other: Region) -> float:
        """Return the number of pixels between two regions of one photograph; below 0 if they overlap."""
        rows = max(self.top - _end(other.bottom), other.top - _end(self.bottom))
        columns = max(self.left - _end(other.right), other.left - _end(self.right))
        return max(rows, columns)


def _end(edge: int | None) -> float:
    return math.inf if edge is None else edge


def _in_order(kind: type[Any]) -> BeforeValidator:
    """Return what makes the lists in a file into a ``kind``, by the order of its fields."""
    names = [each.name for each in fields(kind)]
    return BeforeValidator(lambda row: dict(zip(names, row, strict=False)) if isinstance(row, list) else row)


_Segments = tuple[Annotated[Segment, _in_order(Segment)], ...]
_Regions = tuple[Annotated[Region, _in_order(Region)], ...]


@dataclass(frozen=True)
class Split:
    """Split of recordings, or segments of them, into train, validation and test.

    Parameters
    ----------
    train, validation, test : tuple of Segment
    by : str
        What stays in one part: a `By`, ``"order"`` (`split_last`) or ``"block"`` (`contiguous_blocks`).
    seed : int or None
        None if nothing was drawn.
    gap_s : float, s
        Smallest distance between two parts of one recording. 0 with whole recordings.
    groups : mapping from id to str
        Session, subject, material or condition of each recording, if ``by`` is one of these.
    photographs : mapping from part to tuple of Region
        Photographs, or regions of them, that each part may use, as of `split_photographs`; empty if photographs were
        not split.
    photograph_gap : int, pixels
        Smallest distance between two parts' regions of one photograph.
    by_region : tuple of str
        Materials with too few photographs to hold one out: disjoint regions are in different parts.
    photograph_note : str
        Meaning of a held-out photograph in this split, for reports.
    """

    train: _Segments
    validation: _Segments
    test: _Segments
    by: str
    seed: int | None = None
    gap_s: float = 0.0
    groups: Mapping[str, str] = field(default_factory=dict)
    photographs: Mapping[str, _Regions] = field(default_factory=dict)
    photograph_gap: int = 0
    by_region: tuple[str, ...] = ()
    photograph_note: str = ""

    def __post_init__(self) -> None:
        self.check()

    @property
    def parts(self) -> Mapping[str, tuple[Segment, ...]]:
        """The three parts by name."""
        return {"train": self.train, "validation": self.validation, "test": self.test}

    def as_dict(self) -> dict[str, Any]:
        """Return its fields as plain values; those of photographs only if photographs were split."""
        values = asdict(self)
        if not self.photographs:
            for name in ("photographs", "photograph_gap", "by_region", "photograph_note"):
                del values[name]
        return values

    def check(self) -> None:
        """Raise a `LeakError` if a recording, group or photograph is in two parts."""
        side_of_group: dict[str, str] = {}
        by_recording: dict[str, list[tuple[float, float, str]]] = defaultdict(list)
        for part, segments in self.parts.items():
            for segment in segments:
                stop = math.inf if segment.stop_s is None else segment.stop_s
                by_recording[segment.id].append((segment.start_s, stop, part))
                group = self.groups.get(segment.id)
                if group is not None and side_of_group.setdefault(group, part) != part:
                    raise LeakError(f"{self.by} {group!r} is in {side_of_group[group]} and in {part}")
        for id, intervals in by_recording.items():
            self._check_recording(id, sorted(intervals))
        self._check_photographs()

    def _check_recording(self, id: str, intervals: Sequence[tuple[float, float, str]]) -> None:
        """Check parts of one recording, sorted by their start."""
        if self.by != "block" and len({part for _, _, part in intervals}) > 1:
            names = " and in ".join(sorted({part for _, _, part in intervals}))
            raise LeakError(f"recording {id} is in {names}")
        # The furthest end so far of each part: an earlier segment may reach over the one before.
        ends: dict[str, float] = {}
        for (_, stop, part), (start, _, other) in pairwise(intervals):
            ends[part] = max(stop, ends.get(part, 0.0))
            for side, end in ends.items():
                # Ends are sums of floats: a microsecond is no sample.
                if side != other and start - end < self.gap_s - 1e-6:
                    raise LeakError(
                        f"recording {id}: {side} and {other} must lie {self.gap_s:g} s apart, "
                        f"got {start - end:.3g} s at {start:g} s"
                    )

    def _check_photographs(self) -> None:
        if unknown := sorted(self.photographs.keys() - self.parts.keys()):
            raise ParameterError.must("photographs", f"be of {', '.join(self.parts)}", ", ".join(unknown))
        by_key: dict[str, list[tuple[str, Region]]] = defaultdict(list)
        for part, regions in self.photographs.items():
            for region in regions:
                by_key[region.key].append((part, region))
        for key, shared in by_key.items():
            for (part, region), (other, another) in combinations(shared, 2):
                if part != other and (distance := region.distance(another)) < self.photograph_gap:
                    how = f"{distance:g} pixels apart" if distance >= 0 else "the same pixels"
                    raise LeakError(
                        f"photograph {key}: its regions in {part} and {other} must lie {self.photograph_gap} "
                        f"pixels apart, got {how}"
                    )

    def save(self, path: Path) -> None:
        """Write it as JSON, atomically."""
        values = {"format": FORMAT, "version": VERSION, "by": self.by, "seed": self.seed, "gap_s": self.gap_s}
        values |= {
            part: [[s.id, s.start_s, s.stop_s] for s in segments] for part, segments in self.parts.items()
        }
        values["groups"] = dict(self.groups)
        if self.photographs:
            values["photographs"] = {
                part: [[r.key, r.top, r.left, r.bottom, r.right] for r in regions]
                for part, regions in self.photographs.items()
            }
            values |= {
                "photograph_gap": self.photograph_gap,
                "by_region": self.by_region,
                "photograph_note": self.photograph_note,
            }
        write_text(path, json.dumps(values, indent=0) + "\n")

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a file of `save`.

        Raises `DataError` if it is not a split, or of another version; `LeakError` if it leaks.
        """
        values = read_json(path)
        if not isinstance(values, dict) or values.get("format") != FORMAT:
            raise DataError(f"{path} must say format {FORMAT!r}; this is not a split")
        if values.get("version") != VERSION:
            raise DataError(path, f"format version must be {VERSION}, got {values.get('version')!r}")
        return facts_of(cls, values, where=path)

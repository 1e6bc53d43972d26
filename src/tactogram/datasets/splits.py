"""Splits that cannot leak: made by recording, session, subject, material or condition, and written down.

A window, an augmentation or a weak pair is cut *after* the split, from the segments of one part.
"""

from __future__ import annotations

import json
import math
import os
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Literal, Self

from tactogram.errors import DataError, LeakError, ParameterError

By = Literal["recording", "session", "subject", "material", "condition"]
"""What stays together on one side of a split."""

FORMAT = "tactogram-split"
VERSION = 1


@dataclass(frozen=True)
class Segment:
    """A recording, or a part of one in time.

    Parameters
    ----------
    id : str
        The recording.
    start_s : float, s
        Where it begins.
    stop_s : float, s, optional
        Where it ends; None is the end of the recording.
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
class Split:
    """Which recordings, or parts of them, train, validate and test.

    Parameters
    ----------
    train, validation, test : tuple of Segment
    by : str
        What stays on one side: a `By`, ``"order"`` (`split_last`) or ``"block"`` (`contiguous_blocks`).
    seed : int or None
        What it was drawn with; None if nothing was drawn.
    gap_s : float, s
        How far apart two parts of one recording have to lie to stand on two sides. 0 with whole recordings.
    groups : mapping from id to str
        The session, subject, material or condition of each recording, where ``by`` is one of these.
    """

    train: tuple[Segment, ...]
    validation: tuple[Segment, ...]
    test: tuple[Segment, ...]
    by: str
    seed: int | None = None
    gap_s: float = 0.0
    groups: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.check()

    @property
    def parts(self) -> Mapping[str, tuple[Segment, ...]]:
        """The three parts by name."""
        return {"train": self.train, "validation": self.validation, "test": self.test}

    def check(self) -> None:
        """Refuse a split in which anything stands on two sides.

        Raises
        ------
        LeakError
            Naming the recording or the group, and the two parts.
        """
        side_of_group: dict[str, str] = {}
        by_recording: dict[str, list[tuple[float, float, str]]] = defaultdict(list)
        for part, segments in self.parts.items():
            for segment in segments:
                stop = math.inf if segment.stop_s is None else segment.stop_s
                by_recording[segment.id].append((segment.start_s, stop, part))
                group = self.groups.get(segment.id)
                if group is not None and side_of_group.setdefault(group, part) != part:
                    raise LeakError(f"{self.by} {group!r} is in {side_of_group[group]} and in {part}")
        for id, held in by_recording.items():
            self._check_recording(id, sorted(held))

    def _check_recording(self, id: str, held: Sequence[tuple[float, float, str]]) -> None:
        """Refuse parts of one recording, sorted by their start, that touch on two sides."""
        if self.by != "block" and len({part for _, _, part in held}) > 1:
            names = " and in ".join(sorted({part for _, _, part in held}))
            raise LeakError(f"recording {id} is in {names}")
        # The furthest end so far of each part: an earlier segment may reach over the one before.
        ends: dict[str, float] = {}
        for (_, stop, part), (start, _, other) in pairwise(held):
            ends[part] = max(stop, ends.get(part, 0.0))
            for side, end in ends.items():
                # Ends are sums of floats: a microsecond is no sample.
                if side != other and start - end < self.gap_s - 1e-6:
                    raise LeakError(
                        f"recording {id}: {side} and {other} must lie {self.gap_s:g} s apart, "
                        f"got {start - end:.3g} s at {start:g} s"
                    )

    def save(self, path: Path) -> None:
        """Write it as JSON, beside first and then renamed."""
        values = {"format": FORMAT, "version": VERSION, "by": self.by, "seed": self.seed, "gap_s": self.gap_s}
        segments = {part: [[s.id, s.start_s, s.stop_s] for s in held] for part, held in self.parts.items()}
        part = path.with_name(f"{path.name}.part-{os.getpid()}")
        part.write_text(json.dumps(values | segments | {"groups": dict(self.groups)}, indent=0) + "\n")
        part.replace(path)

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read what `save` wrote.

        Raises
        ------
        DataError
            If it is not a split, or of another version.
        LeakError
            If it leaks.
        """
        try:
            values = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise DataError(f"{path}: not a readable split: {error}") from error
        if not isinstance(values, dict) or values.get("format") != FORMAT:
            raise DataError(f"{path} must say format {FORMAT!r}; this is not a split")
        if values.get("version") != VERSION:
            raise DataError(f"{path}: format version must be {VERSION}, got {values.get('version')!r}")
        try:
            parts = {p: tuple(Segment(*s) for s in values[p]) for p in ("train", "validation", "test")}
            return cls(
                **parts,
                by=values["by"],
                seed=values["seed"],
                gap_s=values["gap_s"],
                groups=values["groups"],
            )
        except (KeyError, TypeError) as error:
            raise DataError(f"{path} lacks or misspells {error}") from error

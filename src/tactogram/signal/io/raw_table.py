"""Raw table: the columns of a file, before it is known what they hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.signal.io.description import SignalDescription

Column = NDArray[np.float64] | NDArray[np.object_]
"""Cells of a column, shape (row,): numbers, NaN where one is missing; or str, datetime and None where some are no
numbers."""


@dataclass(frozen=True, eq=False)
class RawTable:
    """Columns of equal length, whatever the format of the file: text, worksheet, arrays, channels of a measurement.

    A file whose columns are of several lengths or rates is several of these.
    """

    path: Path
    headings: tuple[str, ...]  # as in the file; "1", "2", … if it has none
    columns: tuple[Column, ...]
    units: tuple[str | None, ...] = ()
    """As the file spells them apart from the headings; empty if it does not."""
    groups: tuple[str, ...] = ()
    """Array, structure or sheet of each column; empty if there is none."""
    named: bool = True
    """Whether the headings are the file's."""
    rows: Sequence[int] = ()
    """Number of each row in the file, as an editor or spreadsheet counts; empty: from 0."""
    rate: float | None = None
    """Hz, if the file states one, in ``rate_name``."""
    rate_name: str | None = None
    description: SignalDescription | None = None
    """If this package wrote the file."""
    comment: str | None = None
    notes: tuple[str, ...] = ()
    """One line each, on what was left out or assumed while reading."""

    brief: bool = False
    """Whether these are the first rows of a longer table: what is constant or rises at times may be an axis."""

    def __len__(self) -> int:
        return len(self.columns[0]) if self.columns else 0

    @property
    def numbered(self) -> bool:
        """Whether the columns are those of matrices or of a table without headings, and so have no names."""
        return not self.named or bool(self.groups and set(self.groups).isdisjoint(self.headings))

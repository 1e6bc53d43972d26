"""Measures of two sets of signals, found by looking into the folder ``distances`` and further ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from tactogram.plugins import PluginGroup
from tactogram.signal import Signal

MEASURES = PluginGroup(
    "measure", "tactogram.evaluation.measures.distances", "tactogram.measures", "TACTOGRAM_MEASURES"
)
"""Modules with a ``MEASURE``, a `Measure`."""


class SignalMeasure(Protocol):
    """Distance between two sets of signals of one kind: symmetric, 0 on itself."""

    def __call__(self, one: Sequence[Signal], other: Sequence[Signal], /) -> float | None:
        """Return the distance, >= 0; None where it is undefined for signals of this kind.

        ``one`` and ``other`` are over time, of one rate, unit and set of axes. If they differ in kind or are too short,
        a `ParameterError` is raised.
        """
        ...


@dataclass(frozen=True)
class Measure:
    """Declaration of a measure."""

    name: str
    """Its key in results, equal to the module's name; ends with the unit (``_db``) unless it is a pure number."""
    function: SignalMeasure
    """Lower is better."""
    unit: str
    """``"1"`` for a pure number."""
    title: str
    source: str
    """Publication."""
    multiaxis: bool = False
    """Whether it needs several axes; with one it returns None."""
    rank: int = 100
    """Row in tables, the smallest first; measures of equal rank are sorted by name."""


def signal_measures() -> dict[str, Measure]:
    """Return all measures of two sets of signals by name, in the order of tables.

    Raises `ParameterError` if a module cannot be imported, or does not declare the measure that it is named after.
    """
    measures = [MEASURES.definition(name, "MEASURE", Measure) for name in MEASURES.names()]
    return {measure.name: measure for measure in sorted(measures, key=lambda m: (m.rank, m.name))}

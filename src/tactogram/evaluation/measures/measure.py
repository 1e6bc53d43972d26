"""Measures of two sets of signals, found in the folder ``distances`` and further ones, and the sets they take."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import wraps
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.plugins import PluginGroup
from tactogram.signal import Signal

P = ParamSpec("P")
R = TypeVar("R")
MEASURES = PluginGroup(
    "measure", "tactogram.evaluation.measures.distances", "tactogram.measures", "TACTOGRAM_MEASURES"
)
"""Modules with a ``MEASURE``, a `Measure`."""
CHUNK_SAMPLES = 2**21
"""Maximum number of samples transformed at once, which bounds memory for any size of set."""


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


def segments(signals: Sequence[Signal], seconds: float, *, count: int | None = None) -> list[Signal]:
    """Return ``signals`` cut into pieces of equal length, all of them or ``count``.

    Every estimate depends on the amount of data: a mean spectrum of few pieces scatters more, the
    largest of many correlations is larger, a Fréchet distance of few points is biased upwards. A model is
    comparable with its floor only when both were cut with the same ``seconds`` and ``count``.

    Pieces do not overlap and are in order; with ``count``, that many spread evenly over all. Remainders, and signals
    shorter than a piece, are dropped. ``seconds`` is rounded to whole samples.
    """
    if not (seconds > 0 and np.isfinite(seconds)):
        raise ParameterError.must("seconds", "be > 0 and finite", seconds)
    if count is not None and count < 1:
        raise ParameterError.must("count", "be >= 1", count)
    pieces = []
    for signal in signals:
        length = round(seconds * _over_time(signal).rate)
        if length < 1:
            raise ParameterError(f"a piece of {seconds:g} s holds no sample at {signal.rate:g} Hz")
        pieces += [signal.cut(k, k + length) for k in range(0, len(signal) - length + 1, length)]
    needed = count or 1
    if len(pieces) < needed:
        raise ParameterError(
            f"the signals must hold {needed} pieces of {seconds:g} s, got {len(pieces)}: "
            "use shorter or fewer pieces"
        )
    if count is None:
        return pieces
    return [pieces[k] for k in (np.arange(count) * len(pieces)) // count]


class SignalSet(tuple[Signal, ...]):
    """Signals that are compared with many sets: what is measured of them alone is kept with them."""

    measured: dict[Any, Any]

    def __new__(cls, signals: Iterable[Signal]) -> SignalSet:
        """Return a set of which nothing is measured."""
        new = super().__new__(cls, signals)
        new.measured = {}
        return new


def once_per_set(
    function: Callable[Concatenate[Sequence[Signal], P], R],
) -> Callable[Concatenate[Sequence[Signal], P], R]:
    """Let a function of one set compute its result for a `SignalSet` once; nobody may change the result."""

    @wraps(function)
    def call(signals: Sequence[Signal], /, *args: P.args, **options: P.kwargs) -> R:
        if not isinstance(signals, SignalSet):
            return function(signals, *args, **options)
        key = (function, args, *options.items())
        if key not in signals.measured:
            signals.measured[key] = function(signals, *args, **options)
        result: R = signals.measured[key]
        return result

    return call


def check_alike(*sets: Sequence[Signal], shortest_s: float = 0.0) -> Signal:
    """Return one signal of ``sets`` after checking that all are of one kind: rate, unit and axes.

    A set that is empty, or a signal that is not over time or shorter than ``shortest_s``, is refused, too.
    """
    if not all(sets):
        raise ParameterError("a set to compare needs at least one signal, got none")
    every = [signal for members in sets for signal in members]
    kinds = {(s.rate, s.unit, s.axes) for s in every}
    if len(kinds) != 1:
        raise ParameterError.must("signals", f"have one rate, unit and set of axes, got {len(kinds)} kinds")
    for signal in every:
        if _over_time(signal).seconds < shortest_s * (1 - 1e-9):
            raise ParameterError.must(
                "signals", f"last at least {shortest_s:g} s, got {signal.seconds:.3g} s"
            )
    return every[0]


def stacks(signals: Sequence[Signal]) -> Iterator[NDArray[np.float64]]:
    """Yield the samples of ``signals``, equal lengths together: float64, shape (signal, axis, time).

    Lengths come in the order of their first signals, signals of one length in their own order. A stack
    of several signals holds at most `CHUNK_SAMPLES`.
    """
    by_length: dict[int, list[NDArray[np.float32]]] = {}
    for signal in signals:
        by_length.setdefault(len(signal), []).append(signal.samples)
    for members in by_length.values():
        together = max(1, CHUNK_SAMPLES // members[0].size)
        for start in range(0, len(members), together):
            yield np.stack(members[start : start + together]).astype(np.float64)


def _over_time(signal: Signal) -> Signal:
    if signal.domain != "time":
        raise ParameterError.must("signals", "be over time, got one over displacement")
    return signal

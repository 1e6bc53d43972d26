"""Base of sources with a driver, and channels of a source: names of axes, units, gaps in time stamps, facts."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from time import monotonic
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, ParameterError, UnitError, one_line
from tactogram.signal import parse_unit
from tactogram_capture.source import Block, SourceLost
from tactogram_capture.stream.rate_estimate import RateMeter

LEAST_GAP_S = 0.05
"""Shorter jumps of time stamps are jitter: many programs stamp whole chunks on arrival."""
LEAST_GAP_SAMPLES = 10
MOST_MISSING = 2_000_000
MOST_FILLED = 10**8


def axis_names(
    count: int, names: str | None = None, *, default: Sequence[str] = (), where: str = ""
) -> tuple[str, ...]:
    """Return the names of ``count`` axes: those given, separated by commas, else z, or x, y and z, or ``default``.

    Raises `ParameterError` if the names are not ``count`` different ones.
    """
    if not names:
        general = tuple(default) or tuple(f"c{number}" for number in range(1, count + 1))
        return {1: ("z",), 3: ("x", "y", "z")}.get(count, general)
    axes = tuple(name.strip() for name in names.split(","))
    if len(axes) != count or len(set(axes)) != count:
        raise ParameterError(f"{where and f'{where}: '}axes must be {count} different names, got {names!r}")
    return axes


def described_axes(count: int, labels: Sequence[str]) -> tuple[str, ...]:
    """Return a stream's own ``labels`` as names of its axes if they are ``count`` different ones."""
    return tuple(labels) if len(labels) == len(set(labels)) == count else axis_names(count)


def described_unit(unit: str | None, channel_units: Sequence[str]) -> tuple[str, float]:
    """Return ``unit`` (else the one that all channels share, else 1) and the factor that converts to it."""
    if unit is not None:
        return parse_unit(unit)
    shared = {name for name in channel_units if name}
    if len(shared) == 1:
        try:
            return parse_unit(shared.pop())
        except UnitError:
            pass
    return "1", 1.0


def split_at_gaps(
    samples: NDArray[np.float32], stamps: NDArray[np.float64], rate: float | None, last_stamp: float | None
) -> list[NDArray[np.float32]]:
    """Return ``samples`` in pieces, with NaN for the samples missing where the time stamps jump.

    ``samples`` is float32, shape (axis, n), ``stamps`` float64, shape (n,), s, ``last_stamp`` that of the preceding
    sample. Without a nominal ``rate`` there are no gaps. Raises `DataError` if more than `MOST_FILLED` values would be
    missing.
    """
    if rate is None:
        return [samples]
    before = np.concatenate([[stamps[0] - 1 / rate if last_stamp is None else last_stamp], stamps[:-1]])
    missing = np.round((stamps - before) * rate) - 1
    jumps = np.flatnonzero((missing >= LEAST_GAP_SAMPLES) & (missing >= LEAST_GAP_S * rate))
    missing = np.minimum(missing, MOST_MISSING)
    if (filled := float(missing[jumps].sum()) * len(samples)) > MOST_FILLED:
        raise DataError(
            f"time stamps jump {len(jumps)} times over {filled:.3g} values; are the stamps damaged?"
        )
    pieces, start = [], 0
    for jump in jumps:
        if jump > start:
            pieces.append(samples[:, start:jump])
        pieces.append(np.full((len(samples), int(missing[jump])), np.nan, np.float32))
        start = int(jump)
    return [*pieces, samples[:, start:]]


def source_facts(
    meter: RateMeter, *, samples: int, lost: int, simulated: bool = False, **more: Any
) -> dict[str, Any]:
    """Return the facts that every source reports (`Source.facts`), and ``more``."""
    estimate = meter.estimate()
    return {
        "samples": samples,
        "lost": lost,
        "rejected": {},
        **more,
        "rate": None if estimate is None else estimate.facts(),
        "simulated": simulated,
    }


class DeviceSource(ABC):
    """Base of sources whose driver is asked for samples; see `tactogram_capture.source.Source`.

    It opens and closes the device, counts samples and losses, and measures the rate. ``name`` is the address. An error
    of the kinds ``failures`` while reading means that the device ``failed``.
    """

    rate: float | None = None
    unit: str = "1"
    axes: tuple[str, ...] = ()
    failures: tuple[type[BaseException], ...] = (RuntimeError,)
    failed = "disappeared"

    def __init__(self, name: str) -> None:
        self.name = name
        self.meter = RateMeter()
        self._device: Any = None
        self._next = self._received = self._lost = 0

    def __enter__(self) -> Self:
        """Open and start it; `MissingExtraError` or `DeviceError` if its library, driver or the device is missing."""
        self._device = self._open()
        return self

    def __exit__(self, *_: object) -> None:
        device, self._device = self._device, None
        if device is not None:
            self._close(device)

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return new samples, None if none arrived in time; `SourceLost` if the device failed."""
        if self._device is None:
            raise SourceLost(f"{self.name}: is not open")
        try:
            return self._read(self._device, timeout_s)
        except self.failures as error:
            raise SourceLost(f"{self.name}: {self.failed} while it was read ({one_line(error)})") from error

    def facts(self) -> dict[str, Any]:
        """Return the facts so far."""
        return source_facts(self.meter, samples=self._received, lost=self._lost)

    @abstractmethod
    def _open(self) -> Any:
        """Open and start the device, and return it."""

    def _close(self, device: Any) -> None:
        device.close()

    @abstractmethod
    def _read(self, device: Any, timeout_s: float) -> Block | None:
        """Return new samples as a `_block`, None if none arrived in time."""

    def _block(self, samples: NDArray[Any], *, measured_s: float | None = None) -> Block:
        """Return and count samples, shape (axis, n), that arrived now, ``measured_s`` on the device's own clock."""
        block = Block(samples.astype(np.float32), self._next, monotonic())
        self._next += len(block)
        self._lost += block.lost
        self._received += len(block) - block.lost
        self.meter.add(self._next, block.arrival_s if measured_s is None else measured_s)
        return block

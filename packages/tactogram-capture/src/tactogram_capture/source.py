"""Sources of samples: their common interface, their kinds, and a tap on one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self, get_args, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from tactogram.errors import DeviceError, ParameterError, TactogramError


class SourceEnded(TactogramError):  # noqa: N818 - not an error: it ends a reading loop
    """A source has no more samples: its file ended, or it was stopped."""


class SourceLost(DeviceError):  # noqa: N818 - named like SourceEnded
    """A source disappeared while it was read: a plug was pulled, a driver stopped, a stream closed."""


@dataclass(frozen=True, eq=False)
class Block:
    """Consecutive samples."""

    samples: NDArray[np.float32]
    """float32, shape (axis, n), n >= 1, the source's unit; NaN in every axis where a sample was lost. Read-only."""
    first_index: int
    """Position of the first sample, counted from the source's first, lost ones included: each block continues the
    preceding one."""
    arrival_s: float
    """Arrival of the last sample, s on the clock of ``time.monotonic``; for a file, on the file's clock (NaN without
    one)."""

    def __post_init__(self) -> None:
        samples = np.ascontiguousarray(self.samples, dtype=np.float32)
        if samples.ndim != 2 or samples.shape[1] == 0:
            raise ParameterError(
                f"samples of a block must be (axis, n), not empty, got shape {samples.shape}"
            )
        if samples is self.samples and samples.flags.writeable:
            samples = samples.copy()
        samples.flags.writeable = False
        object.__setattr__(self, "samples", samples)

    def __len__(self) -> int:
        """Return the number of samples per axis, lost ones included."""
        return int(self.samples.shape[1])

    @property
    def lost(self) -> int:
        """Number of lost samples."""
        return int(np.isnan(self.samples).any(axis=0).sum())


@runtime_checkable
class Source(Protocol):
    """A device, stream or file that delivers samples.

    A context manager: entering opens the device, leaving closes it. ``axes`` and ``rate`` may be known only
    after entering, or after the first block.
    """

    name: str
    """Its address, e.g. ``"twelite:/dev/ttyUSB0"``."""
    axes: tuple[str, ...]
    unit: str
    """Of its samples, one of `tactogram.signal.UNITS`."""
    rate: float | None
    """Nominal samples per second; None while unknown. The *measured* rate is in `facts`."""

    def __enter__(self) -> Self:
        """Open it, or raise `DeviceError` or `MissingExtraError`."""
        ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return the samples since the last call; None if none arrived within ``timeout_s``.

        Raises `SourceEnded` if there will be no more samples; `SourceLost` if the source disappeared.
        """
        ...

    def facts(self) -> dict[str, Any]:
        """Return the facts so far, as JSON values.

        At least ``samples`` (received), ``lost`` (samples known to be missing), ``rejected`` (unreadable data, counted
        by reason), ``rate`` (measured: ``hz``, ``low``, ``high``; None while unknown) and ``simulated``; maybe
        ``notes``, a line each on what was assumed or left out.
        """
        ...


@dataclass(frozen=True)
class SourceKind:
    """A kind of source, addressed as ``name:place?option=value&…``."""

    name: str
    """Start of its addresses, equal to the module's name."""
    title: str
    example: str
    """An address."""
    options: type[BaseModel]
    """Options that are files have the type Path; ``log``, if present, is a new file for all bytes."""
    open: Callable[..., Source]
    """``open(place, options, name=address)`` returns a source, not entered yet. ``place`` is the part between the colon
    and the question mark; it may be empty. Raises `ParameterError` if the place or the options are wrong; devices are
    opened later, by entering the source."""
    find: Callable[[float], Mapping[str, str]] | None = None
    """Returns the connected devices: descriptions by address. Its argument limits the search on a network, s."""
    place_is_file: bool = False
    simulated: bool = False

    def file_options(self) -> set[str]:
        """Return the names of the options that are files."""
        fields = self.options.model_fields.items()
        return {name for name, field in fields if Path in (field.annotation, *get_args(field.annotation))}


def required_place(place: str, name: str, what: str) -> str:
    """Return ``place``, the part of an address after the colon, or raise `ParameterError` if it is empty."""
    if not place:
        raise ParameterError(f"{name.rstrip(':')}: must name {what} after the colon")
    return place


BlockListener = Callable[[Source, Block | None], None]
"""Called with the source and each block as it is read; None if none arrived in time."""


class TappedSource:
    """A source that also passes each block to a listener.

    The listener must be quick. Its exceptions end the reading, so that it can stop a session or a live classifier by
    ``KeyboardInterrupt``.
    """

    def __init__(self, source: Source, listener: BlockListener) -> None:
        self._source, self._listener = source, listener

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the source itself: axes, unit, rate, facts, full scale and others."""
        return getattr(self._source, name)

    def __enter__(self) -> Self:
        self._source.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self._source.__exit__(*error)

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return the source's next block after passing it to the listener."""
        block = self._source.read(timeout_s)
        self._listener(self._source, block)
        return block

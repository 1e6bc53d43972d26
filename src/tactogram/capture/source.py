"""Source protocol: what every source of samples offers, whatever its cable."""

from __future__ import annotations

from dataclasses import dataclass
from types import TracebackType
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DeviceError, ParameterError, TactogramError


class SourceEnded(TactogramError):  # noqa: N818 - an end is no error of anybody's; it ends a reading loop
    """A source has no more samples: its file is over, or it was stopped."""


class SourceLost(DeviceError):  # noqa: N818 - beside SourceEnded, in the same words
    """A source went away while it was read: a plug was pulled, a driver stopped, a stream closed."""


@dataclass(frozen=True, eq=False)
class Block:
    """Samples that follow each other.

    Parameters
    ----------
    samples : float32 array, shape (axis, n), the source's unit
        NaN in every axis where a sample was lost. At least one sample. Read-only.
    first_index : int
        Place of the first one, counted from the source's first sample, lost ones included: a block goes on where the
        one before it ended.
    arrival_s : float
        When the last of them arrived, s on the clock of ``time.monotonic``; for a file, what the file says (NaN where
        it says nothing).
    """

    samples: NDArray[np.float32]
    first_index: int
    arrival_s: float

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
        """How many of them are NaN."""
        return int(np.isnan(self.samples).any(axis=0).sum())


@runtime_checkable
class PlanFollower(Protocol):
    """A simulated source that is told of each planned take, so that it strokes what the take asks for."""

    def on_trial(self, trial: Any) -> None:
        """Stroke what ``trial``, a `tactogram.capture.session.plan.PlannedTake`, asks for."""
        ...


@runtime_checkable
class Source(Protocol):
    """A device, a stream or a file that samples come out of.

    Attributes
    ----------
    name : str
        The address it was opened by, e.g. ``"twelite:/dev/ttyUSB0"``.
    axes : tuple of str
        One name per axis of its blocks.
    unit : str
        Of its samples, one of `tactogram.signal.UNITS`.
    rate : float or None
        Nominal samples per second; None while unknown. What was *measured* stands in `facts`.

    Notes
    -----
    It is a context manager: entering opens the device, leaving closes it. ``axes`` and ``rate`` may be known only
    after entering, or after the first block.
    """

    name: str
    axes: tuple[str, ...]
    unit: str
    rate: float | None

    def __enter__(self) -> Self:
        """Open it.

        Raises
        ------
        DeviceError, MissingExtraError
            If it does not open; one line.
        """
        ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it; never raises."""
        ...

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return what has come since the last call; None if nothing came within ``timeout_s``.

        Raises
        ------
        SourceEnded
            When there will be no more.
        SourceLost
            When it went away.
        """
        ...

    def facts(self) -> dict[str, Any]:
        """Return what is known so far, as JSON knows it.

        At least ``samples`` (received), ``lost`` (samples known to be missing), ``rejected`` (what was not understood,
        by reason) and ``rate`` (measured: ``hz``, ``low``, ``high``; None while unknown), and ``simulated``.
        """
        ...

"""Lab Streaming Layer: streams of any device on the local network, on one clock."""

from __future__ import annotations

from time import monotonic
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from tactogram.capture.source import Block, SourceLost
from tactogram.capture.stream.rate_estimate import RateMeter
from tactogram.errors import DataError, DeviceError, UnitError
from tactogram.extras import device_errors, lsl, one_line
from tactogram.signal.units import parse_unit

LEAST_GAP_S = 0.05
"""A leap of the time stamps below this is jitter: many programs stamp whole chunks on arrival."""
LEAST_GAP_SAMPLES = 10
MOST_MISSING = 2_000_000
MOST_FILLED = 10**8


class LslSource:
    """A stream of Lab Streaming Layer; see `tactogram.capture.source.Source`.

    The layer itself loses nothing while it is connected; samples are missing where its buffer ran over or the sender
    was interrupted, which its time stamps show: a leap of more than `LEAST_GAP_SAMPLES` and `LEAST_GAP_S` is a gap.

    Parameters
    ----------
    stream : str
        Name of the stream.
    name : str
        The address.
    kind : str, optional
        Its type (``"Acceleration"``), to find it by where no name is given.
    unit : str, optional
        Unit of the samples, by default what the stream says of its first channel, or 1.
    find_s : float
        How long to look for it.
    """

    def __init__(
        self, stream: str, *, name: str, kind: str | None = None, unit: str | None = None, find_s: float = 3.0
    ) -> None:
        self.name, self.rate = name, None
        self.axes: tuple[str, ...] = ()
        self.unit = "1"
        self.meter = RateMeter()
        self._stream, self._kind, self._said, self._find_s = stream, kind, unit, find_s
        self._factor = 1.0
        self._inlet: Any = None
        self._pylsl: Any = None
        self._next = self._received = self._lost = 0
        self._last_stamp: float | None = None

    rate: float | None

    def __enter__(self) -> Self:
        """Find and open it.

        Raises
        ------
        MissingExtraError, DeviceError
            If pylsl is not installed, the stream is not there, or holds text.
        """
        self._pylsl = lsl()
        by, value = ("name", self._stream) if self._stream else ("type", self._kind or "")
        with device_errors(self.name, library="pylsl"):
            found = self._pylsl.resolve_byprop(by, value, 1, self._find_s)
            if not found:
                raise DeviceError(f"{self.name}: no stream of the {by} {value!r} within {self._find_s:g} s")
            inlet = self._pylsl.StreamInlet(found[0], max_buflen=60, recover=False)
            info = inlet.info(self._find_s)
            if info.channel_format() == self._pylsl.cf_string:
                raise DeviceError(f"{self.name}: holds text, not samples")
            inlet.open_stream(self._find_s)
        rate = float(info.nominal_srate())
        self.rate = rate if rate > 0 else None
        labels, units = _channels(info)
        count = int(info.channel_count())
        default = {1: ("z",), 3: ("x", "y", "z")}.get(count, tuple(f"c{i + 1}" for i in range(count)))
        self.axes = tuple(labels) if len(set(labels)) == count else default
        self.unit, self._factor = known_unit(self._said, units)
        self._inlet = inlet
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        inlet, self._inlet = self._inlet, None
        if inlet is not None:
            inlet.close_stream()

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return what has come; None if nothing did within ``timeout_s``.

        Raises
        ------
        SourceLost
            If the stream was closed.
        """
        if self._inlet is None:
            raise SourceLost(f"{self.name}: is not open")
        try:
            rows, stamps = self._inlet.pull_chunk(timeout=timeout_s, max_samples=4096, min_samples=1)
        except RuntimeError as error:
            # Its LostError and InternalError are, and stand elsewhere from version to version.
            raise SourceLost(f"{self.name}: went away while it was read ({one_line(error)})") from error
        if not len(stamps):
            return None
        samples = (np.asarray(rows, np.float64).T * self._factor).astype(np.float32)
        pieces, first = [], self._next
        for piece in split_at_gaps(samples, np.asarray(stamps, np.float64), self.rate, self._last_stamp):
            pieces.append(piece)
            self._lost += int(np.isnan(piece[0]).sum())
        whole = np.concatenate(pieces, axis=1)
        self._last_stamp = float(stamps[-1])
        self._next += whole.shape[1]
        self._received += samples.shape[1]
        self.meter.add(self._next, self._last_stamp)
        return Block(whole, first, monotonic())

    def facts(self) -> dict[str, Any]:
        """Return what is known."""
        estimate = self.meter.estimate()
        return {
            "samples": self._received,
            "lost": self._lost,
            "rejected": {},
            "rate": None if estimate is None else estimate.facts(),
            "simulated": False,
        }


def split_at_gaps(
    samples: NDArray[np.float32], stamps: NDArray[np.float64], rate: float | None, last_stamp: float | None
) -> list[NDArray[np.float32]]:
    """Return ``samples`` with pieces of NaN where the time stamps leap.

    Parameters
    ----------
    samples : float32 array, shape (axis, n)
    stamps : float64 array, shape (n,), s
    rate : float or None
        Nominal; where there is none, nothing is taken for a gap.
    last_stamp : float or None
        Of the sample before.

    Raises
    ------
    DataError
        If more than `MOST_FILLED` values would be missing.
    """
    if rate is None:
        return [samples]
    before = np.concatenate([[stamps[0] - 1 / rate if last_stamp is None else last_stamp], stamps[:-1]])
    missing = np.round((stamps - before) * rate) - 1
    leaps = np.flatnonzero((missing >= LEAST_GAP_SAMPLES) & (missing >= LEAST_GAP_S * rate))
    missing = np.minimum(missing, MOST_MISSING)
    if (filled := float(missing[leaps].sum()) * len(samples)) > MOST_FILLED:
        raise DataError(
            f"time stamps leap {len(leaps)} times over {filled:.3g} values; are the stamps damaged?"
        )
    pieces, start = [], 0
    for place in leaps:
        if place > start:
            pieces.append(samples[:, start:place])
        pieces.append(np.full((len(samples), int(missing[place])), np.nan, np.float32))
        start = int(place)
    return [*pieces, samples[:, start:]]


def known_unit(said: str | None, units: list[str]) -> tuple[str, float]:
    """Return the unit of a stream and the factor to it: what was said, else what all channels agree on, else 1."""
    if said is not None:
        return parse_unit(said)
    named = {unit for unit in units if unit}
    if len(named) == 1:
        try:
            return parse_unit(named.pop())
        except UnitError:
            pass
    return "1", 1.0


def _channels(info: Any) -> tuple[list[str], list[str]]:
    """Return labels and units of the channels, as far as the stream describes them."""
    labels, units = [], []
    channel = info.desc().child("channels").child("channel")
    for _ in range(int(info.channel_count())):
        labels.append(channel.child_value("label"))
        units.append(channel.child_value("unit"))
        channel = channel.next_sibling("channel")
    return ([] if "" in labels else labels), units

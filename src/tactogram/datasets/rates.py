"""Common rates of recordings whose time stamps leave some doubt about the rate."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from tactogram.datasets.recording import Recording
from tactogram.datasets.store.store import Store
from tactogram.signal import Signal
from tactogram.signal.resampling import resample

UNITED = 0.02
"""Largest relative difference between estimated rates that counts as jitter of one clock; 1000 and 1024 Hz are two."""
ACCURACY = 1e-4
"""Relative accuracy of an estimated rate (`tactogram.signal.timing.estimate_timing`)."""
ROUNDING = 1e-9
"""Relative difference that is not worth a mention."""


class CommonRates:
    """Rates of the recordings so far, by stream; an estimated rate close to one of them becomes that rate.

    The first estimated rate is rounded as far as its accuracy allows: 999.98 becomes 1000 Hz. A stated rate is never
    changed.
    """

    def __init__(self, known: Mapping[str, Iterable[float]] | None = None) -> None:
        self._rates = {stream: list(rates) for stream, rates in (known or {}).items()}

    @classmethod
    def of(cls, store: Store) -> CommonRates:
        """Return the rates in a store."""
        rates: dict[str, dict[float, None]] = {}
        for info in store.index:
            for stream in store.streams_of(info.id):
                rates.setdefault(stream, {})[store.rate(info.id, stream)] = None
        return cls(rates)

    @property
    def several(self) -> dict[str, list[float]]:
        """The streams that have several rates, each with them in order."""
        return {stream: sorted(rates) for stream, rates in self._rates.items() if len(rates) > 1}

    def united(self, recording: Recording) -> Recording:
        """Return a recording at the common rate of each stream, which its history states."""
        estimated = recording.reading is not None and recording.reading.rate_estimated
        streams: dict[str, Signal] = {}
        history = []
        for name, signal in recording.streams.items():
            rate = self._rate(name, signal.rate, estimated=estimated)
            if abs(rate - signal.rate) <= ACCURACY * rate:
                streams[name] = replace(signal, rate=rate)
                if abs(rate - signal.rate) > ROUNDING * rate:
                    history.append(f"estimated rate of {signal.rate:.9g} Hz taken as {rate:g} Hz")
            else:
                streams[name] = resample(signal, rate)
                history.append(
                    f"resampled from {signal.rate:g} Hz to {rate:g} Hz, the rate of other recordings"
                )
        if all(streams[name].rate == signal.rate for name, signal in recording.streams.items()):
            return recording
        return replace(recording, streams=streams, history=(*recording.history, *history), id="")

    def _rate(self, stream: str, rate: float, *, estimated: bool) -> float:
        known = self._rates.setdefault(stream, [])
        if estimated:
            near = min(known, key=lambda other: abs(other - rate), default=0.0)
            rate = near if abs(near - rate) <= UNITED * rate else _rounded(rate)
        if rate not in known:
            known.append(rate)
        return rate


def _rounded(rate: float) -> float:
    """Return the number with the fewest digits within `ACCURACY` of a rate."""
    digits = (float(f"{rate:.{count}e}") for count in range(17))
    return next(number for number in digits if abs(number - rate) <= ACCURACY * rate)

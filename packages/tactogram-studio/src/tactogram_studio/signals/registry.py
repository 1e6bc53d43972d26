"""Cache of the signals that pages show: each is read and analysed once, outside of the event loop."""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np

from tactogram.errors import DataError
from tactogram.signal import Signal
from tactogram.signal.io import read_signal
from tactogram_studio.signals.traits import SignalTraits, traits_of

MOST_BYTES = 256 * 2**20
"""Samples and spectrograms in memory for the browser."""
MOST_FILES = 1000
"""Files whose signals' keys are remembered."""
T = TypeVar("T")
Source = Signal | Path
"""A signal, or the file that holds it."""


@dataclass(frozen=True, eq=False)
class ShownSignal:
    """A signal with its key (`key_of`) and traits."""

    key: str
    signal: Signal
    traits: SignalTraits


class ValueCache(Generic[T]):
    """Values by key up to a total size, the least recently used dropped first; concurrent calls make a value once."""

    def __init__(self, most: float, size: Callable[[T], float] = lambda value: 1.0) -> None:
        self.most, self._size = most, size
        self._values: OrderedDict[Hashable, T] = OrderedDict()
        self._making: dict[Hashable, threading.Lock] = {}
        self._lock = threading.Lock()

    def find(self, key: Hashable) -> T | None:
        """Return a value, or None if it is not in the cache."""
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
            return self._values.get(key)

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return a value, made by ``make`` if it is not in the cache."""
        with self._lock:
            lock = self._making.setdefault(key, threading.Lock())
        try:
            with lock:
                value = self.find(key)
                if value is None:
                    value = make()
                    self._put(key, value)
                return value
        finally:
            with self._lock:
                self._making.pop(key, None)

    def _put(self, key: Hashable, value: T) -> None:
        with self._lock:
            self._values[key] = value
            while len(self._values) > 1 and sum(map(self._size, self._values.values())) > self.most:
                self._values.popitem(last=False)


class ShownSignals:
    """Signals by key; the least recently used is dropped first."""

    def __init__(self, most: int = MOST_BYTES) -> None:
        self.signals: ValueCache[ShownSignal] = ValueCache(most, _bytes)
        self._keys: ValueCache[str] = ValueCache(MOST_FILES)

    def load(self, source: Source) -> ShownSignal:
        """Return a signal with its traits, which takes long for minutes of samples; concurrent calls share the work.

        Raises `DataError` if its file cannot be read.
        """
        if isinstance(source, Signal):
            key = key_of(source)
            return self.signals.get(key, lambda: ShownSignal(key, source, traits_of(source)))
        key = self._keys.get(_file(source), lambda: self.load(read_signal(source)).key)
        return self.signals.find(key) or self.load(read_signal(source))

    def cached(self, source: Source) -> ShownSignal | None:
        """Return a file's signal if it is in the cache; None for a `Signal`, whose key takes long to compute."""
        if not isinstance(source, Path):
            return None
        try:
            return self.signals.find(self._keys.find(_file(source)))
        except OSError:
            return None

    def get(self, key: str) -> ShownSignal:
        """Return a signal by its key; `DataError` if it is no longer in the cache."""
        shown = self.signals.find(key)
        if shown is None:
            raise DataError("this signal is no longer in memory; reload the page")
        return shown


def key_of(signal: Signal) -> str:
    """Return a hash of samples, rate, unit, axes and domain: 24 hexadecimal digits."""
    meaning = f"{signal.rate!r} {signal.unit} {signal.axes!r} {signal.domain}"
    digest = hashlib.sha256(meaning.encode())
    # In place: a copy would block all other threads.
    digest.update(np.ascontiguousarray(signal.samples).view(np.uint8).data)
    return digest.hexdigest()[:24]


def _file(path: Path) -> tuple[Path, int]:
    """Return a key that changes when the file is rewritten."""
    return path, path.stat().st_mtime_ns


def _bytes(shown: ShownSignal) -> int:
    return shown.signal.samples.nbytes + shown.traits.level.nbytes


SHOWN = ShownSignals()

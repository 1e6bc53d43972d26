"""Cache of the signals that pages show: each is read and analysed once, outside of the event loop."""

from __future__ import annotations

import hashlib
import threading
from collections import OrderedDict
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tactogram.errors import DataError
from tactogram.signal import Signal
from tactogram.signal.io import read_signal
from tactogram_studio.signals.traits import SignalTraits, traits_of

MOST_BYTES = 256 * 2**20
"""Samples and spectrograms in memory for the browser."""
MOST_FILES = 1000
"""Files whose signals' keys are remembered."""
Source = Signal | Path
"""A signal, or the file that holds it."""


@dataclass(frozen=True, eq=False)
class ShownSignal:
    """A signal with its key (`key_of`) and traits."""

    key: str
    signal: Signal
    traits: SignalTraits


@dataclass
class ShownSignals:
    """Signals by key; the least recently used is dropped first."""

    most: int = MOST_BYTES
    _signals: OrderedDict[str, ShownSignal] = field(default_factory=OrderedDict)
    _files: OrderedDict[tuple[Path, int], str] = field(default_factory=OrderedDict)
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _analysing: dict[Path | str, threading.Lock] = field(default_factory=dict)
    """Locks of signals being analysed, by file or key."""

    def load(self, source: Source) -> ShownSignal:
        """Return a signal with its traits, which takes long for minutes of samples; concurrent calls share the work.

        Raises `DataError` if its file cannot be read.
        """
        name = source if isinstance(source, Path) else key_of(source)
        with self._lock:
            lock = self._analysing.setdefault(name, threading.Lock())
        with lock:
            shown = self.cached(source) if isinstance(source, Path) else self._get(str(name))
            if shown is None:
                shown = self._analysed(source)
        with self._lock:
            self._analysing.pop(name, None)
        return shown

    def _analysed(self, source: Source) -> ShownSignal:
        signal = read_signal(source) if isinstance(source, Path) else source
        key = key_of(signal)
        shown = self._get(key) or ShownSignal(key, signal, traits_of(signal))
        with self._lock:
            if isinstance(source, Path):
                self._files[_file(source)] = key
                while len(self._files) > MOST_FILES:
                    self._files.popitem(last=False)
            self._put(shown)
        return shown

    def cached(self, source: Source) -> ShownSignal | None:
        """Return a file's signal if it is in the cache; None for a `Signal`, whose key takes long to compute."""
        if not isinstance(source, Path):
            return None
        try:
            return self._get(self._files.get(_file(source), ""))
        except OSError:
            return None

    def _get(self, key: str) -> ShownSignal | None:
        with self._lock:
            shown = self._signals.get(key)
            if shown is not None:
                self._signals.move_to_end(key)
            return shown

    def get(self, key: str) -> ShownSignal:
        """Return a signal by its key; `DataError` if it is no longer in the cache."""
        shown = self._get(key)
        if shown is None:
            raise DataError("this signal is no longer in memory; reload the page")
        return shown

    def _put(self, shown: ShownSignal) -> None:
        self._signals[shown.key] = shown
        self._signals.move_to_end(shown.key)
        while len(self._signals) > 1 and sum(_bytes(one) for one in self._signals.values()) > self.most:
            self._signals.popitem(last=False)


SHOWN = ShownSignals()


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

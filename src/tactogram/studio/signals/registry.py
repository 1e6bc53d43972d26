"""The signals that pages show at present, each read, named and worked out once, and never in the event loop."""

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
from tactogram.studio.signals.traits import SignalTraits, traits_of

MOST_BYTES = 256 * 2**20
"""Of samples that are held for the browser to fetch."""
MOST_FILES = 1000
"""Files of which it is remembered what they held."""
Source = Signal | Path
"""A signal, or the file that holds it."""


@dataclass(frozen=True, eq=False)
class ShownSignal:
    """A signal that is shown.

    Parameters
    ----------
    key : str
        See `key_of`.
    signal : Signal
    traits : Traits
    """

    key: str
    signal: Signal
    traits: SignalTraits


@dataclass
class ShownSignals:
    """Signals that pages show, by key; the least recently used goes first."""

    most: int = MOST_BYTES
    _held: OrderedDict[str, ShownSignal] = field(default_factory=OrderedDict)
    _files: OrderedDict[tuple[Path, int], str] = field(default_factory=OrderedDict)
    _lock: threading.Lock = field(default_factory=threading.Lock)
    _at_it: dict[Path | str, threading.Lock] = field(default_factory=dict)
    """What is being worked out, by file or key."""

    def load(self, source: Source) -> ShownSignal:
        """Hold a signal with what its pictures are made of; takes long for minutes of it.

        What several pages ask for at once is worked out once.

        Raises
        ------
        DataError
            If its file cannot be read.
        """
        name = source if isinstance(source, Path) else key_of(source)
        with self._lock:
            lock = self._at_it.setdefault(name, threading.Lock())
        with lock:
            held = self.known(source) if isinstance(source, Path) else self._found(str(name))
            if held is None:
                held = self._worked_out(source)
        with self._lock:
            self._at_it.pop(name, None)
        return held

    def _worked_out(self, source: Source) -> ShownSignal:
        signal = read_signal(source) if isinstance(source, Path) else source
        key = key_of(signal)
        held = self._found(key) or ShownSignal(key, signal, traits_of(signal))
        with self._lock:
            if isinstance(source, Path):
                self._files[_file(source)] = key
                while len(self._files) > MOST_FILES:
                    self._files.popitem(last=False)
            self._put(held)
        return held

    def known(self, source: Source) -> ShownSignal | None:
        """Return what was worked out of a file and is still held; None else, and of a signal, whose name takes long."""
        if not isinstance(source, Path):
            return None
        try:
            return self._found(self._files.get(_file(source), ""))
        except OSError:
            return None

    def _found(self, key: str) -> ShownSignal | None:
        with self._lock:
            held = self._held.get(key)
            if held is not None:
                self._held.move_to_end(key)
            return held

    def get(self, key: str) -> ShownSignal:
        """Return what is shown by its key.

        Raises
        ------
        DataError
            If it is no longer held.
        """
        held = self._found(key)
        if held is None:
            raise DataError("this signal is no longer held: reload the page")
        return held

    def _put(self, held: ShownSignal) -> None:
        self._held[held.key] = held
        self._held.move_to_end(held.key)
        while len(self._held) > 1 and sum(_bytes(one) for one in self._held.values()) > self.most:
            self._held.popitem(last=False)


SHOWN = ShownSignals()


def key_of(signal: Signal) -> str:
    """Return 24 hexadecimal digits that follow from the samples and what they mean."""
    said = f"{signal.rate!r} {signal.unit} {signal.axes!r} {signal.domain}"
    digest = hashlib.sha256(said.encode())
    # In place: a copy would hold up all other threads.
    digest.update(np.ascontiguousarray(signal.samples).view(np.uint8).data)
    return digest.hexdigest()[:24]


def _file(path: Path) -> tuple[Path, int]:
    """Return what tells a file from another, and from what it was before it was written anew."""
    return path, path.stat().st_mtime_ns


def _bytes(held: ShownSignal) -> int:
    return held.signal.samples.nbytes + held.traits.level.nbytes

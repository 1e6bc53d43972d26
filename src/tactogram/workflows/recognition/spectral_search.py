"""Search for recordings by their spectra alone, without a trained classifier.

The distance is the mean absolute difference in dB of levels in third octaves, each spectrum about its own mean level.
It depends on timbre, not on strength or material.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Store, open_store
from tactogram.errors import ParameterError
from tactogram.recipe import Preparation
from tactogram.signal import Signal
from tactogram.signal.io.atomic import atomic_write
from tactogram.workflows.progress import ProgressCallback, silent

MEASURE = "spectral distance: mean absolute difference of third-octave levels about their mean, dB; not a classifier"
LOWEST_HZ, HIGHEST_HZ = 20.0, 1000.0
LOOKED_AT_S = 4.0
"""Length of a recording's middle that is used, s (mm over displacement)."""
RANGE_DB = 60.0
"""Lower levels, relative to the strongest band, are raised to this."""
VERSION = 1

Array = NDArray[np.float32]


def band_centres(rate: float, domain: str) -> NDArray[np.float64]:
    """Return the centres of third octaves of 20 to 1000 Hz; over displacement, two decades below half the rate."""
    low, high = (LOWEST_HZ, HIGHEST_HZ) if domain == "time" else (rate / 200, rate / 2)
    high = min(high, rate / 2 / 10**0.05)
    return np.asarray(10 ** np.arange(math.log10(low), math.log10(high) + 1e-9, 0.1), np.float64)


def spectrum(signal: Signal, *, rate: float | None = None) -> Array:
    """Return levels in third octaves about their mean, float32, shape (band,), dB.

    ``rate`` is that of the slowest signal to compare: only bands below half of it are used.
    """
    middle = band_centres(min(rate or signal.rate, signal.rate), signal.domain)
    most = round(LOOKED_AT_S * signal.rate)
    start = max(0, (len(signal) - most) // 2)
    x = signal.samples[:, start : start + most].astype(np.float64)
    x = (x - x.mean(1, keepdims=True)) * np.hanning(x.shape[1])
    power = (np.abs(np.fft.rfft(x, axis=1)) ** 2).sum(0)
    edges = (np.arange(len(power) + 1) - 0.5) * signal.rate / x.shape[1]
    total = np.concatenate([[0.0], np.cumsum(power)])
    held = np.interp(middle * 10**0.05, edges, total) - np.interp(middle / 10**0.05, edges, total)
    if not held.max(initial=0.0) > 0:
        return np.zeros(len(middle), np.float32)
    level = 10 * np.log10(np.maximum(held / held.max(), 10 ** (-RANGE_DB / 10)))
    return np.asarray(level - level.mean(), np.float32)


def find_similar(
    data: Path | str | Store,
    signal: Signal,
    *,
    stream: str | None = None,
    count: int = 5,
    without: Iterable[str] = (),
    cache: Path | None = None,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Return the recordings of a store whose spectra are nearest to that of ``signal``.

    ``stream`` is by default as in training: ``acceleration``, else the first. Recordings with an id in ``without`` are
    left out. ``cache`` is a folder for the spectra of a store.

    Keys of the result: ``nearest`` (``id``, ``material``, ``distance`` in dB), ``materials`` (each once), ``measure``,
    ``stream``, ``recordings`` (number compared).

    Raises `ParameterError` if no recording can be compared.
    """
    if count < 1:
        raise ParameterError.must("count", "be at least 1", count)
    store = data if isinstance(data, Store) else open_store(data)
    name = Preparation(stream=stream).stream_of(tuple(store.streams))
    if store.streams[name].domain != signal.domain:
        raise ParameterError(
            f"{name} of {store.name} runs over {store.streams[name].domain}, the signal over {signal.domain}: "
            "bring them to one with `tactogram convert`"
        )
    ids, spectra, rates = _spectra(store, name, cache, progress)
    left_out = set(without)
    own = spectrum(signal)
    distances = []
    for id, held, rate in zip(ids, spectra, rates.tolist(), strict=True):
        if id in left_out:
            continue
        slowest = min(rate, signal.rate)
        n = len(band_centres(slowest, signal.domain))
        if n < 2 or n > min(len(own), len(held)):
            continue
        a, b = own[:n] - own[:n].mean(), held[:n] - held[:n].mean()
        distances.append((float(np.abs(a - b).mean()), id))
    if not distances:
        raise ParameterError(
            f"{store.name}: no other recording of {name} that the signal can be compared with"
        )
    distances.sort()
    nearest = [{"id": id, "material": store.info(id).material, "distance": d} for d, id in distances[:count]]
    materials: dict[str | None, float] = {}
    for distance, id in distances:
        materials.setdefault(store.info(id).material, distance)
    return {
        "nearest": nearest,
        "materials": [{"material": m, "distance": d} for m, d in list(materials.items())[:count]],
        "measure": MEASURE,
        "stream": name,
        "recordings": len(distances),
    }


def _spectra(
    store: Store, stream: str, cache: Path | None, progress: ProgressCallback
) -> tuple[list[str], list[Array], NDArray[np.float64]]:
    """Return ids, spectra and rates of all recordings of a stream; the cache keeps spectra by recording."""
    ids = [info.id for info in store.index if stream in store.streams_of(info.id)]
    file = None if cache is None else cache / f"{_name(store, stream)}.npz"
    held = cached(file)
    missing = [id for id in ids if id not in held]
    for done, id in enumerate(missing, 1):
        rate, length = store.rate(id, stream), store.length(id, stream)
        most = round(LOOKED_AT_S * rate)
        start = max(0, (length - most) // 2)
        held[id] = spectrum(store.signal(id, stream, start=start, stop=min(length, start + most)))
        progress("spectra", done, len(missing))
    if file is not None and missing:
        cache_vectors(file, held)
    rates = np.array([store.rate(id, stream) for id in ids], np.float64)
    return ids, [held[id] for id in ids], rates


def _name(store: Store, stream: str) -> str:
    text = f"{VERSION}|{store.path if isinstance(store.path, str) else store.path.resolve()}|{stream}"
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def cache_vectors(file: Path, held: Mapping[str, Array]) -> None:
    """Write vectors by recording, of any lengths, for `cached`."""
    table = np.full((len(held), max(map(len, held.values()))), np.nan, np.float32)
    for row, vector in zip(table, held.values(), strict=True):
        row[: len(vector)] = vector
    with atomic_write(file) as part:
        np.savez(part, ids=np.array(list(held)), vectors=table)


def cached(file: Path | None) -> dict[str, Array]:
    """Return the vectors in a file by recording; none if it is missing or broken: it can be made again."""
    if file is None:
        return {}
    try:
        with file.open("rb") as opened, np.load(opened, allow_pickle=False) as values:
            rows = zip(values["ids"].tolist(), values["vectors"], strict=True)
            return {id: row[~np.isnan(row)] for id, row in rows}
    except (OSError, ValueError, KeyError, BadZipFile):
        return {}

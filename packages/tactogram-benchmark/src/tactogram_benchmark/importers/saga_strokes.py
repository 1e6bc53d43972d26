"""Strokes of the laboratory of Saga et al.: acceleration of a finger over nine textures, three axes at about 1 kHz.

The recordings belong to "Machine Learning-based Classification and Generation of Vibrotactile Information" (Sec. III-B:
a wired accelerometer on the finger, strokes in one direction). Layout: a folder per texture (``ArtGrass01``,
``ArtLeather``, ``Carpet01``, ``CorkSheet``, ``EnbiPunch``, ``GreenTile``, ``Luncheon01`` to ``03``) with 80 takes of at
least 5 s, ``TEXTURE_NUMBER.csv``; ``TEXTURE_14(1).csv`` is a second take of the same number. Without heading; columns:
time in us, x, y and z in whole counts of an Arduino's converter, and two zeros, which are ignored.
**No real file was at hand**: the importer was tested on files made to a description of this layout.

The stamps jitter around steps of about 936 us: the rate is estimated from them, and samples are resampled band-limited
to ``rate``. A log may begin with a burst of samples that were queued before it: their stamps follow each other at once
and say nothing, so that they are left out, which ``history`` states. Counts become m/s^2 on the assumption that an
ADXL335 gives ``counts_per_g``, about 60. The zero of the converter is not stated: the mean of each axis, which holds it
beside gravity, is removed.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import ImportItem, Recording, check_positive, files_below, number_columns
from tactogram.errors import DataError
from tactogram.signal import STANDARD_GRAVITY, estimate_timing, to_uniform

TITLE = "Saga et al.: finger strokes over nine textures, 80 takes each"
LICENCE = "not stated"
DESCRIPTION = (
    "TEXTURE/TEXTURE_NUMBER.csv, also TEXTURE_14(1).csv: time (us), x, y, z in counts, without heading: acceleration "
    "(m/s^2). Options: rate (Hz, 1000), counts_per_g (assumed 60). Not checked on real files."
)

UNVERIFIED = (
    "no file of the set was at hand: layout, microseconds and counts per g are from a description; "
    "check the level"
)

RATE = 1000.0
COUNTS_PER_G = 60.0
"""300 mV per g at 3 V (ADXL335 data sheet), converted to 10 bits of 5 V: 61."""

LEAST = 16
"""Samples of a take; as many with usual steps end the burst at its beginning."""

_NAME = re.compile(r"(.+)_(\d+)(?:\s*\((\d+)\))?")


def find(folder: Path, *, rate: float = RATE, counts_per_g: float = COUNTS_PER_G) -> list[ImportItem]:
    """Return an item per take."""
    check_positive(rate=rate, counts_per_g=counts_per_g)
    info = {"rate": float(rate), "counts_per_g": float(counts_per_g)}
    items = []
    for name, path in files_below(folder, (".csv",)).items():
        if match := _NAME.fullmatch(path.stem):
            material, number, copy = match.groups()
            labels = {"recording": str(int(number)), "take": str(int(copy or 0) + 1)}
            items.append(ImportItem(name, (path,), {**info, "material": material, "labels": labels}))
    if not items:
        raise DataError(folder, "must hold takes such as ArtGrass01/ArtGrass01_03.csv, found none")
    return items


def read(item: ImportItem) -> list[Recording]:
    """Return one take."""
    [path] = item.paths
    rate, counts_per_g = item.info["rate"], item.info["counts_per_g"]
    stamps, *counts = number_columns(path, least=LEAST)[:4]
    queued = _queued(stamps)
    times = 1e-6 * stamps[queued:]
    samples = np.stack(counts)[:, queued:] * STANDARD_GRAVITY / counts_per_g
    samples -= samples.mean(axis=1, keepdims=True)
    timing = estimate_timing(times)
    return [
        Recording(
            streams={"acceleration": to_uniform(times, samples, "m/s^2", axes=("x", "y", "z"), rate=rate)},
            material=item.info["material"],
            contactor="finger",
            labels=item.info["labels"],
            source=item.name,
            history=(
                f"stamps show {timing.rate:.1f} Hz, jitter {timing.jitter_rms * 1e6:.0f} us rms, {timing.dropped} "
                f"samples lost; resampled to {rate:g} Hz",
                f"counts to m/s^2 at {counts_per_g:g} counts per g, assumed; the mean of each axis, gravity and the "
                "converter's zero, removed",
                *([f"the first {queued} samples, queued before the log began, left out"] * bool(queued)),
            ),
        )
    ]


def _queued(stamps: NDArray[np.float64]) -> int:
    """Return the number of samples in the burst at the beginning, whose stamps are closer than half the usual step."""
    short = np.flatnonzero(np.diff(stamps) < np.median(np.diff(stamps)) / 2)
    queued = 0
    while len(near := short[(short >= queued) & (short < queued + LEAST)]):
        queued = int(near[-1]) + 1
    return queued

"""Study of an ultrasonic display: vibrations of metal plates, display signals, and ratings of both in ten words.

K. Hatori, K. Takemura, "Conditional Generative Adversarial Network-Based Tactile Stimulus Generation for Ultrasonic
Tactile Display", IEEE Access 11, 2023; the data are IEEE DataPort, DOI 10.21227/5jwn-qx81.

**No copy was at hand, and the names of its files are not published.** The paper states the contents: vibrations of 12
plates, 10 measurements each by four gauges at 10 kHz (Sec. III-B), arbitrary signals (Sec. III-C), and 384 and 1,248
ratings in ten words on a scale from 1 to 7. The importer expects this layout, to which a copy may have to be adapted:

- ``plates/``: the first number in a file's path below it is the plate (``plates/3/07.csv`` or ``plates/3_07.csv``), a
  file is a measurement. A table has a column per gauge, or rows of 1,000 amplitudes, 1 to 1,000 Hz.
- ``signals/``: the first number is the signal (``signals/07.csv`` or ``.wav``): a column, or a row of 1,000 amplitudes.
- ``plates.csv`` and ``signals.csv``: ratings (`tactogram.datasets.ratings.table`), items by number.

Amplitudes become loops of 1 s with random phases, drawn by the file's name: their amplitude spectra are those of the
file, their waveforms are not. A file of several spectra has an axis for each.
"""

from __future__ import annotations

import re
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import (
    ImportItem,
    RatingColumns,
    Ratings,
    Recording,
    check_positive,
    files_below,
    join_ratings,
    read_table,
)
from tactogram.errors import DataError
from tactogram.signal import Signal, periodic_signal, random_phases
from tactogram.signal.io import READABLE, read_columns, read_signal

TITLE = "Hatori & Takemura 2023: metal plates, an ultrasonic display and word ratings"
LICENCE = "not stated"
DESCRIPTION = (
    "plates/PLATE_MEASUREMENT.csv (four gauges, or rows of 1,000 amplitudes), signals/SIGNAL.csv|wav, plates.csv and "
    "signals.csv (ratings in ten words, 1-7): strain and drive. Options: rate (Hz, 10000), full_scale (1, of the "
    "display signals). Not checked on real files: their names are not published."
)

BINS = 1000
"""Amplitudes of a spectrum, 1 Hz apart. Sec. III-B."""
KINDS = {"plates": "plate", "signals": "signal"}
"""Folders, and the names of their items."""


def find(folder: Path, *, rate: float = 10_000.0, full_scale: float = 1.0) -> list[ImportItem]:
    """Return an item per file, plates first."""
    check_positive(rate=rate, full_scale=full_scale)
    items = []
    for kind, prefix in KINDS.items():
        files = files_below(folder / kind, READABLE) if (folder / kind).is_dir() else {}
        numbered = [(name, path, re.search(r"\d+", name)) for name, path in files.items()]
        items_of_kind = [
            ImportItem(
                f"{kind}/{name}",
                (path,),
                {"item": f"{prefix}{int(number[0]):02d}", "rate": rate, "full_scale": full_scale},
            )
            for name, path, number in numbered
            if number
        ]
        if not items_of_kind:
            raise DataError(folder, f"must hold files with a number in their path below {kind}/, found none")
        items += items_of_kind
    return items


def read(item: ImportItem) -> list[Recording]:
    """Return one measurement of a plate, or one display signal."""
    [path] = item.paths
    name, rate = item.info["item"], item.info["rate"]
    plate = item.name.startswith("plates/")
    columns = [use.heading for use in read_columns(path)]
    signal = read_signal(path, rate=rate, unit="1", axes=columns or None)
    history = ["unit not stated"]
    if len(signal.axes) == BINS:
        signal = _loops(np.asarray(signal.samples.T, np.float64), rate, seed=zlib.crc32(item.name.encode()))
        history.append("amplitude spectra of 1 to 1,000 Hz, made loops of 1 s with random phases")
    if plate:
        return [
            Recording(
                streams={"strain": signal}, material=name, speed_mm_s=20.0, force_n=0.98,
                contactor="tactile sensor", session=f"{name}-{path.stem}", labels={"recording": path.stem},
                source=item.name, history=tuple(history),
            )
        ]  # fmt: skip
    if len(signal.axes) != 1:
        raise DataError(
            item.name, f"a display signal must be one column or one spectrum, got {len(signal.axes)}"
        )
    drive = Signal(signal.samples / np.float32(item.info["full_scale"]), signal.rate, "1", ("drive",))
    history.append(f"full scale taken as {item.info['full_scale']:g}")
    return [
        Recording(streams={"drive": drive}, labels={"item": name}, source=item.name, history=tuple(history))
    ]


def ratings(folder: Path) -> Ratings | None:
    """Return the ratings of plates and display signals; None without tables of them."""
    tables = [
        read_table(folder / f"{kind}.csv", columns=RatingColumns(item=prefix + "{:0>2}")).ratings
        for kind, prefix in KINDS.items()
        if (folder / f"{kind}.csv").is_file()
    ]
    return join_ratings(tables) if tables else None


def _loops(amplitudes: NDArray[np.float64], rate: float, *, seed: int) -> Signal:
    """Return a loop of 1 s per spectrum, (spectrum, bin)."""
    rng, length = np.random.default_rng(seed), round(rate)
    samples = [periodic_signal(row, random_phases(len(row), rng=rng), length=length) for row in amplitudes]
    axes = tuple(f"spectrum{number:02d}" for number in range(1, len(samples) + 1))
    return Signal(np.array(samples, np.float32), rate, "1", axes if len(samples) > 1 else ("spectrum",))

"""HapTex: friction of a bare finger over 120 fabrics, and a photograph of each.

J. Jiao, Y. Zhang, D. Wang, X. Guo, X. Sun, "HapTex: A Database of Fabric Textures for Surface Tactile Display", IEEE
World Haptics 2019, 331-336. It holds friction force, normal force, friction coefficient, displacement and velocity of
the fingertip, and photographs of 2362 x 2362 pixels (FrictGAN, Sec. 4).

**No copy was at hand, and its page (haptic.buaa.edu.cn/English_FabricDatabase.htm) does not describe its files.** The
importer expects this layout, to which a copy may have to be adapted:

- The first number in a file's path, relative to the folder, names the fabric: ``12/trial1.txt``, ``12.txt`` and
  ``images/12.jpg`` belong to ``fabric012``.
- A table (``.txt``, ``.csv``, ``.tsv``) has a heading with ``displacement`` and ``friction coefficient`` (or
  ``friction``, ``mu``, ``cof``), units in brackets if not mm; or no heading and either two columns, displacement in mm
  and friction coefficient, or the five quantities in the order above.
- A single photograph of a fabric belongs to all its recordings and is taken as registered: 2362 pixels are 100 mm at
  600 dots per inch, our inference, which ``history`` repeats; column 0 is where the displacement begins. Several
  photographs are not registered.

Displacement is what was recorded, not evenly spaced: samples where the finger goes back or rests are left out. The
friction coefficient becomes the stream ``friction``, evenly spaced over displacement. By default it has 1.25 samples
per pixel, as FrictGAN's spectrograms of 1280 samples for 1024 pixels; finer detail is removed, not folded back.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import (
    PICTURES,
    ImportedPhotograph,
    ImportItem,
    Recording,
    check_positive,
    files_below,
)
from tactogram.errors import DataError
from tactogram.signal import Signal, check_growth, resample
from tactogram.signal.io import column_numbers, heading, text_table

TITLE = "HapTex: friction of a finger over 120 fabrics"
LICENCE = "free access for research, no licence stated"
DESCRIPTION = (
    "NUMBER/*.txt|csv or NUMBER.txt|csv with displacement (mm) and friction coefficient, and a photograph per fabric: "
    "friction over displacement. Options: rate (samples per mm), width_mm (of a photograph). Not checked on real files."
)

UNVERIFIED = (
    "no file of HapTex was at hand and its page describes none: names, columns, mm, and the photographs' 100 mm and "
    "registration are assumed (tactogram_benchmark.importers.haptex); compare a fabric with its photograph first"
)

TABLES = (".txt", ".csv", ".tsv")
WIDTH_MM = 100.0
"""Width of a photograph of 2362 pixels at 600 dots per inch."""
RATE = 1.25 * 2362 / WIDTH_MM
"""Samples per mm: 1280 samples for 1024 pixels."""
FINE = 8
"""Factor by which the grid of the linear interpolation is finer than the result, before band-limiting."""
LEAST = 16
"""Fewest samples of a stroke."""


def find(folder: Path, *, rate: float = RATE, width_mm: float = WIDTH_MM) -> list[ImportItem]:
    """Return an item per table, by fabric."""
    check_positive(rate=rate, width_mm=width_mm)
    tables = _by_fabric(folder, TABLES)
    if not tables:
        raise DataError(
            folder, "must hold tables with a fabric's number in their path, such as 12/trial1.txt or 12.csv"
        )
    pictures = _by_fabric(folder, PICTURES)
    items = []
    for fabric, paths in tables.items():
        images = pictures.get(fabric, [])
        image = images[0] if len(images) == 1 else None
        common = {"fabric": fabric, "rate": float(rate), "registered": image is not None}
        for number, path in enumerate(paths, 1):
            info = common | {"recording": str(number)}
            name = path.relative_to(folder).as_posix()
            items.append(ImportItem(name, (path,), info, image, width_mm if image else None))
    return items


def photographs(folder: Path) -> list[ImportedPhotograph]:
    """Return the photographs of fabrics that have several of them, or no recording."""
    tables = _by_fabric(folder, TABLES)
    return [
        ImportedPhotograph(path.relative_to(folder).as_posix(), path, _name(fabric))
        for fabric, paths in _by_fabric(folder, PICTURES).items()
        if len(paths) > 1 or fabric not in tables
        for path in paths
    ]


def read(item: ImportItem) -> list[Recording]:
    """Return one stroke."""
    [path] = item.paths
    info = item.info
    displacement, friction = _columns(path)
    signal, density = friction_over(displacement, friction, info["rate"], item.name)
    history = [
        f"friction coefficient over displacement: {density:.3g} samples per mm recorded, {signal.rate:.5g} kept",
        "displacement in mm where the file does not say",
        "unverified: the layout of HapTex's files is assumed",
    ]
    if info["registered"]:
        history.append(
            "photograph taken as registered: 600 dots per inch, column 0 where the displacement begins"
        )
    return [
        Recording(
            streams={"friction": signal},
            material=_name(info["fabric"]),
            contactor="finger",
            labels={"recording": info["recording"]},
            source=item.name,
            history=tuple(history),
        )
    ]


def friction_over(
    displacement_mm: NDArray[np.float64], friction: NDArray[np.float64], rate: float, name: str
) -> tuple[Signal, float]:
    """Return friction at ``rate`` even samples per mm, and the samples per mm that were recorded."""
    if not (np.isfinite(displacement_mm).all() and np.isfinite(friction).all()):
        raise DataError(name, "displacement and friction must be finite in every row")
    forth = displacement_mm if displacement_mm[-1] >= displacement_mm[0] else -displacement_mm
    # Only new ground counts: a place is felt when the finger first gets there.
    furthest = np.concatenate([[-np.inf], np.maximum.accumulate(forth)[:-1]])
    new = forth > furthest
    displacement, coefficient = forth[new] - forth[0], friction[new]
    length = float(displacement[-1])
    if len(displacement) < LEAST or length * rate < LEAST:
        raise DataError(
            name,
            f"the finger must move over at least {LEAST} samples, got {len(displacement)} over {length:g} mm; "
            "is the displacement in mm?",
        )
    check_growth(length * FINE * rate, len(displacement), f"over {length:g} mm")
    grid = np.arange(0, length, 1 / (FINE * rate))
    fine = Signal(np.interp(grid, displacement, coefficient), FINE * rate, "1", ("along",), "displacement")
    return resample(fine, rate), len(displacement) / length


def _columns(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return displacement in mm and friction coefficient, float64, shape (time,)."""
    table = text_table(path, path.read_bytes())
    names = [heading(text).name for text in table.headings]
    if not table.named:
        if len(names) not in (2, 5):
            raise DataError(
                path,
                f"without a heading it must have 2 or 5 columns, got {len(names)}; name "
                "'displacement [mm]' and 'friction coefficient' in a first line",
            )
        places = (0, 1) if len(names) == 2 else (3, 2)
    else:
        places = (
            _named(path, names, r"displacement"),
            _named(path, names, r"friction[ _]?coef|^friction$|^mu$|^cof$"),
        )
    unit, factor = heading(table.headings[places[0]]).converted()
    displacement, friction = (column_numbers(table, column) for column in places)
    return displacement * (1e3 * factor if unit == "m" else 1.0), friction


def _named(path: Path, names: list[str], pattern: str) -> int:
    matches = [i for i, name in enumerate(names) if re.search(pattern, name, re.IGNORECASE)]
    if len(matches) != 1:
        raise DataError(path, f"needs one column named like {pattern!r}, got {', '.join(names)}")
    return matches[0]


def _by_fabric(folder: Path, suffixes: Iterable[str]) -> dict[int, list[Path]]:
    paths: dict[int, list[Path]] = {}
    for name, path in files_below(folder, suffixes).items():
        if number := re.search(r"\d+", name.removesuffix(path.suffix)):
            paths.setdefault(int(number[0]), []).append(path)
    return dict(sorted(paths.items()))


def _name(fabric: int) -> str:
    return f"fabric{fabric:03d}"

"""BioTac_slide: a BioTac finger sliding over materials, 40 recordings of each at one speed (about 2 cm/s).

Read from ``matNN.npz`` with ``materials.csv`` (names) and ``images/``, or from tables ``matN_R_bio.csv`` in any folder
(``raw_data/matN/``, as published; ``raw_csv/``) for a material without ``.npz``. Checked on real files of both kinds:
they give the same samples.

Notes on the data
- Every channel was rectified by the authors (distance from the reading at rest): the sign is lost, and the spectrum is
  that of a rectified signal.
- 22 pressure-vibration samples (PAC) come with each 100 Hz frame; flattened row by row they are the stream ``pac`` at
  2200 Hz. The other channels are separate streams at 100 Hz. The unit is "1": sensor counts.
- The rates are the sensor's nominal ones; frames arrive within some 50 us of them.
- Material 1 (Carpet net) lasts 6 s, the others 8 s. Nothing is cropped here, so the length of a whole recording reveals
  its material: compare windows of one length.
- There is one session per material, so differences between sessions cannot be separated from differences between
  materials.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import ImportItem, Recording, number_columns
from tactogram.errors import DataError
from tactogram.signal import Signal
from tactogram.signal.io import load_arrays
from tactogram.text_files import read_table

TITLE = "BioTac_slide: a BioTac finger sliding on materials"
LICENCE = "not stated"
DESCRIPTION = (
    "matNN.npz with materials.csv and images/, or raw_data/matN/matN_R_bio.csv: streams pac (2200 Hz), tdc, tac, pdc "
    "and electrodes (100 Hz), in rectified sensor counts. Checked on real files."
)

FRAME_RATE = 100.0
PAC_PER_FRAME = 22
ELECTRODES = 19
SPEED_MM_S = 20.0
"""Nominal: the authors state about 2 cm/s."""
HISTORY = (
    "rectified by its authors: distance from the reading at rest, the sign is lost",
    "pac: 22 samples of each 100 Hz frame in a row, 2200 Hz",
)


def find(folder: Path) -> list[ImportItem]:
    """Return an item per ``matNN.npz``, and one per raw recording of materials that have none."""
    arrays = {_number(path.stem): path for path in folder.glob("mat*.npz")}
    tables = [path for path in folder.rglob("mat*_bio.csv") if _number(path.stem) not in arrays]
    if not arrays and not tables:
        raise DataError(folder, "must hold matNN.npz or raw_data/matN/matN_R_bio.csv, found neither")
    materials = _materials(folder / "materials.csv")
    items = [_item(folder, path, materials.get(number, {})) for number, path in sorted(arrays.items())]
    tables.sort(key=lambda path: [int(n) for n in re.findall(r"\d+", path.stem)])
    return items + [_item(folder, path, materials.get(_number(path.stem), {})) for path in tables]


def read(item: ImportItem) -> list[Recording]:
    """Return the recordings of one file."""
    [path] = item.paths
    if path.suffix == ".npz":
        return _read_arrays(item, path)
    return [_recording(item, _number(path.stem, 1), _read_table(path))]


def _item(folder: Path, path: Path, material: Mapping[str, str]) -> ImportItem:
    number = _number(path.stem)
    image = folder / "images" / (material.get("image") or f"mat{number:02d}.jpg")
    return ImportItem(
        path.relative_to(folder).as_posix(),
        (path,),
        {"key": f"mat{number}", **material},
        image if image.is_file() else None,
    )


def _materials(path: Path) -> dict[int, dict[str, str]]:
    """Return the rows of ``materials.csv`` by number; empty if there is none."""
    if not path.is_file():
        return {}
    rows = read_table(path, needed=("material_id", "name"))
    try:
        return {int(row["material_id"]): row for _, row in rows}
    except ValueError as error:
        raise DataError(path, f"material_id must be a number: {error}") from error


def _read_arrays(item: ImportItem, path: Path) -> list[Recording]:
    streams = ("pac", "tdc", "tac", "pdc", "electrodes")
    content: Mapping[str, Any] = load_arrays(path, needed=(*streams, "lengths", "recording"))
    rates = [content[name].tolist() for name in ("frame_rate_hz", "pac_rate_hz") if name in content]
    if rates not in ([], [100, 2200]):
        raise DataError(path, f"rates must be 100 and 2200 Hz, got {rates}")
    arrays = {name: content[name] for name in streams}
    lengths, numbers = content["lengths"], content["recording"]
    if len(numbers) != len(lengths):
        raise DataError(path, f"{len(lengths)} lengths but {len(numbers)} recordings")
    for name, values in arrays.items():
        if len(values) != lengths.sum():
            raise DataError(path, f"{name} must have {lengths.sum()} rows as lengths say, got {len(values)}")
    if (lengths < 1).any():
        raise DataError(path, f"recording {numbers[lengths < 1][0]} is empty")
    recordings = []
    for number, stop, length in zip(numbers, np.cumsum(lengths), lengths, strict=True):
        frames = {name: values[stop - length : stop] for name, values in arrays.items()}
        recordings.append(_recording(item, int(number), frames))
    return recordings


def _read_table(path: Path) -> dict[str, NDArray[np.float64]]:
    """Return the frames of a raw CSV, whose rows end with a comma that the header lacks."""
    pac = [f"pac{i}" for i in range(1, PAC_PER_FRAME + 1)]
    electrodes = [f"ele{i}" for i in range(1, ELECTRODES + 1)]
    values = number_columns(path, ("tdc", "tac", "pdc", *pac, *electrodes)).T
    return {
        "pac": values[:, 3 : 3 + PAC_PER_FRAME],
        **dict(zip(("tdc", "tac", "pdc"), values.T[:3], strict=True)),
        "electrodes": values[:, -ELECTRODES:],
    }


def _recording(item: ImportItem, number: int, frames: Mapping[str, NDArray[Any]]) -> Recording:
    pac, electrodes = np.asarray(frames["pac"]), np.asarray(frames["electrodes"])
    if pac.ndim != 2 or pac.shape[1] != PAC_PER_FRAME or electrodes.shape[1:] != (ELECTRODES,):
        raise DataError(
            item.name, f"pac must have 22 columns and electrodes 19, got {pac.shape} and {electrodes.shape}"
        )
    streams = {"pac": Signal(pac.reshape(-1), FRAME_RATE * PAC_PER_FRAME, "1", ("pac",))}
    streams |= {
        name: Signal(np.asarray(frames[name]).reshape(-1), FRAME_RATE, "1", (name,))
        for name in ("tdc", "tac", "pdc")
    }
    axes = tuple(f"e{i}" for i in range(1, ELECTRODES + 1))
    streams["electrodes"] = Signal(electrodes.T, FRAME_RATE, "1", axes)
    info = item.info
    labels = ("key", "code", "thickness", "roughness")
    return Recording(
        streams=streams,
        material=info.get("name") or info["key"],
        contactor="BioTac",
        speed_mm_s=SPEED_MM_S,
        session=info["key"],
        labels={"recording": str(number)} | {name: info[name] for name in labels if info.get(name)},
        source=f"{item.name}#{number}" if item.name.endswith(".npz") else item.name,
        history=HISTORY,
    )


def _number(stem: str, index: int = 0) -> int:
    """Return a number in ``matN`` or ``matN_R_bio``."""
    numbers = re.findall(r"\d+", stem)
    if len(numbers) <= index:
        raise DataError(stem, "name must be matNN.npz or matN_R_bio.csv")
    return int(numbers[index])

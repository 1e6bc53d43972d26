"""Cluster Haptic Texture Dataset: 118 textures, 8 directions, 5 speeds, 2 forces, twice each.

M. Eguchi, T. Hayase, Y. Hiroi, T. Hiraki, "Cluster Haptic Texture Dataset: Haptic Texture Dataset with Varied
Velocity-Direction Sliding Contacts", arXiv:2407.16206; files at doi:10.6084/m9.figshare.29438288.

Layout, as stated in its ``dataset_details.md``: ``sensor_data/{accel,force,position,audio}/``, each file
``TEXTURE_DIRECTION_VELOCITY_FORCE_REPEAT.csv`` (audio ``.wav``), directly or in a folder per texture;
``images/images_scan_area/imgTEXTURE.jpg`` (100 x 100 mm; also ``TEXTURE.jpg``); ``texture_list.xlsx`` names the
textures. **No real file was at hand**: the importer was tested on files made to that description.

Converted to SI units: acceleration from g (gravity stays in it), position from mm to m; velocity stays mm/s in
``speed_mm_s``, force goes from mN to ``force_n``. Time stamps of acceleration and force jitter; samples are resampled
band-limited to the nominal 6 kHz, position to 100 Hz, and ``history`` reports the timing. A stream begins at its first
stamp, within about a millisecond of the others. ``raw_audio`` is not read.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import openpyxl
import pyarrow as pa
import pyarrow.csv
from numpy.typing import NDArray

from tactogram.datasets.importer import ImportItem
from tactogram.datasets.recording import Recording
from tactogram.errors import DataError
from tactogram.signal import Signal
from tactogram.signal.io import read_signal
from tactogram.signal.timing import estimate_timing, to_uniform
from tactogram.signal.units import STANDARD_GRAVITY

TITLE = "Cluster Haptic Texture Dataset"
LICENCE = "see doi:10.6084/m9.figshare.29438288"
DESCRIPTION = (
    "sensor_data/{accel,force,position,audio}/TEXTURE_DIRECTION_VELOCITY_FORCE_REPEAT.*: acceleration (m/s^2, 6 kHz), "
    "force (N, 6 kHz), position (m, 100 Hz), sound (44.1 kHz), photos. Not checked on real files."
)

UNVERIFIED = "no file of the set was at hand: the layout is that of its dataset_details.md"

SCAN_MM = 100.0
"""Width of the photographed area."""


@dataclass(frozen=True)
class StreamFormat:
    """Format of the CSV files in one folder."""

    stream: str
    columns: tuple[str, ...]
    axes: tuple[str, ...]
    unit: str
    rate: float
    scale: float = 1.0
    note: str = ""


TABLES: Mapping[str, StreamFormat] = {
    "accel": StreamFormat(
        *("acceleration", ("X", "Y", "Z"), ("x", "y", "z"), "m/s^2", 6000.0, STANDARD_GRAVITY),
        note=f"acceleration from g to m/s^2 (x {STANDARD_GRAVITY}); gravity is in it",
    ),
    "force": StreamFormat("force", ("force",), ("z",), "N", 6000.0),
    "position": StreamFormat(
        "position", ("X", "Y"), ("x", "y"), "m", 100.0, 1e-3, note="position from mm to m"
    ),
}
SUFFIXES: Mapping[str, str] = {**dict.fromkeys(TABLES, ".csv"), "audio": ".wav"}

_NAME = re.compile(r"(\d+)_(\d+)_(\d+)_(\d+)_(\d+)")


def find(folder: Path) -> list[ImportItem]:
    """Return an item per stroke; a kind of file that exists for one stroke must exist for all."""
    root = next((r for r in (folder, folder / "texture_dataset") if (r / "sensor_data").is_dir()), None)
    if root is None:
        raise DataError(f"{folder}: must hold a folder sensor_data with accel, force, position or audio")
    sensor_data = root / "sensor_data"
    found: dict[str, dict[str, Path]] = {}
    strokes: dict[str, str] = {}
    for kind, suffix in SUFFIXES.items():
        for path in (sensor_data / kind).rglob(f"*{suffix}"):
            if not path.name.startswith("."):
                found.setdefault(kind, {})[path.stem] = path
                strokes.setdefault(path.stem, path.relative_to(sensor_data / kind).parent.as_posix())
    if not strokes:
        raise DataError(f"{sensor_data}: must hold {', '.join(SUFFIXES)}, found none")
    names = _texture_names(root / "texture_list.xlsx")
    items = []
    for stem in sorted(strokes, key=lambda s: [int(n) for n in re.findall(r"\d+", s)]):
        paths = {
            kind: files.get(stem, sensor_data / kind / strokes[stem] / f"{stem}{SUFFIXES[kind]}")
            for kind, files in found.items()
        }
        texture = stem.partition("_")[0]
        image = _image(root / "images" / "images_scan_area", texture)
        name = next(iter(paths.values())).relative_to(folder).as_posix()
        info = {"kinds": tuple(paths), "material": names.get(texture, f"texture {texture}")}
        items.append(ImportItem(name, tuple(paths.values()), info, image, None if image is None else SCAN_MM))
    return items


def read(item: ImportItem) -> list[Recording]:
    """Return one stroke."""
    stem = item.paths[0].stem
    match = _NAME.fullmatch(stem)
    if match is None:
        raise DataError(f"{item.name}: name must be TEXTURE_DIRECTION_VELOCITY_FORCE_REPEAT of numbers")
    texture, direction, speed, force, repeat = match.groups()
    paths = dict(zip(item.info["kinds"], item.paths, strict=True))
    streams, history = _even({kind: path for kind, path in paths.items() if kind in TABLES})
    if "audio" in paths:
        streams["sound"] = read_signal(paths["audio"], unit="1")
        history.append("sound after the noise cancelling of its authors")
    return [
        Recording(
            streams=streams,
            material=item.info["material"],
            speed_mm_s=float(speed),
            force_n=int(force) / 1000,
            direction_deg=float(direction),
            contactor="artificial finger",
            labels={"texture": texture, "repeat": repeat},
            source=item.name,
            history=tuple(history),
        )
    ]


def _table(path: Path, names: tuple[str, ...]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the column ``time`` (s) and the named ones, float64, shape (column, time)."""
    wanted = ("time", *names)
    try:
        table = pa.csv.read_csv(
            path,
            read_options=pa.csv.ReadOptions(use_threads=False),  # other processes have the other cores
            convert_options=pa.csv.ConvertOptions(
                column_types=dict.fromkeys(wanted, pa.float64()), include_columns=wanted, null_values=[]
            ),
        )
    except (pa.ArrowException, KeyError) as error:
        raise DataError(f"{path}: needs columns {','.join(wanted)} of numbers: {error}") from error
    columns = np.stack([table[name].to_numpy() for name in wanted])
    if columns.shape[1] < 2:
        raise DataError(f"{path}: must have at least two rows of samples, got {columns.shape[1]}")
    bad = np.argwhere(~np.isfinite(columns))
    if len(bad):
        column, row = bad[0]
        raise DataError(
            f"{path}: row {row + 2}, column {wanted[column]}: must be finite, got {columns[column, row]}"
        )
    return columns[0], columns[1:]


def _even(paths: Mapping[str, Path]) -> tuple[dict[str, Signal], list[str]]:
    """Return evenly sampled streams and their history; files with the same stamps are resampled together."""
    tables = {kind: _table(path, TABLES[kind].columns) for kind, path in paths.items()}
    streams: dict[str, Signal] = {}
    history = []
    for kind, (times, _) in tables.items():
        if TABLES[kind].stream in streams:
            continue
        same = [
            k
            for k, (t, _) in tables.items()
            if TABLES[k].rate == TABLES[kind].rate and np.array_equal(t, times)
        ]
        stacked = np.vstack([tables[k][1] * TABLES[k].scale for k in same])
        axes = tuple(f"{k}-{column}" for k in same for column in TABLES[k].columns)
        timing = estimate_timing(times)
        even = to_uniform(times, stacked, "1", axes=axes, rate=TABLES[kind].rate)
        for k in same:
            rows = even.select(*(f"{k}-{column}" for column in TABLES[k].columns)).samples
            streams[TABLES[k].stream] = Signal(rows, TABLES[k].rate, TABLES[k].unit, TABLES[k].axes)
        history.append(
            f"{', '.join(TABLES[k].stream for k in same)}: stamps show {timing.rate:.1f} Hz, jitter "
            f"{timing.jitter_rms * 1e6:.0f} us rms, {timing.dropped} samples lost; resampled to {even.rate:g} Hz"
        )
    return streams, history + [TABLES[kind].note for kind in paths if TABLES[kind].note]


def _texture_names(path: Path) -> dict[str, str]:
    """Return the name of each texture by its number; empty without a list."""
    if not path.is_file():
        return {}
    try:
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        rows = book.worksheets[0].iter_rows(values_only=True)
        head, *rest = [[str(cell).strip() if cell is not None else "" for cell in row] for row in rows]
    except Exception as error:  # openpyxl raises whatever the zip or the XML holds
        raise DataError(f"{path}: not a readable list of textures: {error}") from error
    titles = [title.lower() for title in head]
    number = next((i for i, t in enumerate(titles) if re.search(r"\b(id|no)\b", t.replace("_", " "))), None)
    name = next(
        (i for i, t in enumerate(titles) if re.search("name|material|texture", t) and i != number), None
    )
    if number is None or name is None:
        raise DataError(f"{path}: needs a column with the id and one with the name, got {', '.join(head)}")
    names = {row[number].removesuffix(".0"): row[name] for row in rest if row[number] and row[name]}
    shared = {text for text in names.values() if list(names.values()).count(text) > 1}
    return {id: f"{text} ({id})" if text in shared else text for id, text in names.items()}


def _image(folder: Path, texture: str) -> Path | None:
    for name in (f"img{texture}.jpg", f"{texture}.jpg"):
        if (folder / name).is_file():
            return folder / name
    return None

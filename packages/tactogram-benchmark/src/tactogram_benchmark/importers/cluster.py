"""Cluster Haptic Texture Dataset: 118 textures, 8 directions, 5 speeds, 2 forces, twice each.

M. Eguchi, T. Hayase, Y. Hiroi, T. Hiraki, "Cluster Haptic Texture Dataset: Haptic Texture Dataset with Varied
Velocity-Direction Sliding Contacts", arXiv:2407.16206; files at doi:10.6084/m9.figshare.29438288.

Layout, as stated in its ``dataset_details.md``: ``sensor_data/{accel,force,position,audio}/``, each file
``TEXTURE_DIRECTION_VELOCITY_FORCE_REPEAT.csv`` (audio ``.wav``; in the copy on the Hugging Face Hub ``.parquet`` and
``.flac``), directly or in a folder per texture;
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

import pandas as pd

from tactogram.datasets import ImportItem, Recording, number_columns
from tactogram.errors import DataError
from tactogram.extras import imported
from tactogram.signal import Signal, estimate_timing, parse_unit, to_uniform
from tactogram.signal.io import read_signal

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
    """Format of the tables in one folder."""

    stream: str
    columns: tuple[str, ...]
    axes: tuple[str, ...]
    unit: str  # of the files
    rate: float
    note: str = ""


TABLES: Mapping[str, StreamFormat] = {
    "accel": StreamFormat(
        *("acceleration", ("X", "Y", "Z"), ("x", "y", "z"), "g", 6000.0),
        note="acceleration from g to m/s^2; gravity is in it",
    ),
    "force": StreamFormat("force", ("force",), ("z",), "N", 6000.0),
    "position": StreamFormat("position", ("X", "Y"), ("x", "y"), "mm", 100.0, note="position from mm to m"),
}
SUFFIXES: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(TABLES, (".csv", ".parquet")),
    "audio": (".wav", ".flac"),
}

_NAME = re.compile(r"(\d+)_(\d+)_(\d+)_(\d+)_(\d+)")


def find(folder: Path) -> list[ImportItem]:
    """Return an item per stroke; a kind of file that exists for one stroke must exist for all."""
    root = next((r for r in (folder, folder / "texture_dataset") if (r / "sensor_data").is_dir()), None)
    if root is None:
        raise DataError(folder, "must hold a folder sensor_data with accel, force, position or audio")
    sensor_data = root / "sensor_data"
    files_of_kind: dict[str, dict[str, Path]] = {}
    strokes: dict[str, str] = {}
    for kind, suffixes in SUFFIXES.items():
        for path in (sensor_data / kind).rglob("*.*"):
            if path.suffix.lower() in suffixes and not path.name.startswith("."):
                files_of_kind.setdefault(kind, {})[path.stem] = path
                strokes.setdefault(path.stem, path.relative_to(sensor_data / kind).parent.as_posix())
    if not strokes:
        raise DataError(sensor_data, f"must hold {', '.join(SUFFIXES)}, found none")
    names = _texture_names(root / "texture_list.xlsx")
    items = []
    for stem in sorted(strokes, key=lambda s: [int(n) for n in re.findall(r"\d+", s)]):
        paths = {
            kind: files.get(stem, sensor_data / kind / strokes[stem] / f"{stem}{SUFFIXES[kind][0]}")
            for kind, files in files_of_kind.items()
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
        raise DataError(item.name, "name must be TEXTURE_DIRECTION_VELOCITY_FORCE_REPEAT of numbers")
    texture, direction, speed, force, repeat = match.groups()
    paths = dict(zip(item.info["kinds"], item.paths, strict=True))
    streams, history = {}, []
    for kind, form in TABLES.items():
        if kind in paths:
            streams[form.stream], timing = _even(paths[kind], form)
            history += [timing, form.note]
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
            history=tuple(filter(None, history)),
        )
    ]


def _even(path: Path, form: StreamFormat) -> tuple[Signal, str]:
    """Return the evenly sampled stream of a table, and its timing."""
    times, *columns = number_columns(path, ("time", *form.columns), least=2)
    unit, factor = parse_unit(form.unit)
    timing = estimate_timing(times)
    signal = to_uniform(times, [factor * column for column in columns], unit, axes=form.axes, rate=form.rate)
    return signal, (
        f"{form.stream}: stamps show {timing.rate:.1f} Hz, jitter {timing.jitter_rms * 1e6:.0f} us rms, "
        f"{timing.dropped} samples lost; resampled to {form.rate:g} Hz"
    )


def _texture_names(path: Path) -> dict[str, str]:
    """Return the name of each texture by its number; empty without a list."""
    if not path.is_file():
        return {}
    imported("openpyxl", extra="formats", what="workbooks")
    try:
        table = pd.read_excel(path, dtype=str, engine="openpyxl")
    except Exception as error:  # whatever the zip or the XML holds
        raise DataError(path, f"not a readable list of textures: {error}") from error
    titles = {title: str(title).lower().replace("_", " ") for title in table}
    number = next((t for t, text in titles.items() if re.search(r"\b(id|no)\b", text)), None)
    name = next(
        (t for t, text in titles.items() if re.search("name|material|texture", text) and t != number), None
    )
    if number is None or name is None:
        raise DataError(path, f"needs a column with the id and one with the name, got {', '.join(titles)}")
    named = table[[number, name]].dropna().apply(lambda column: column.str.strip())
    shared = named[name].duplicated(keep=False)
    texts = named[name].where(~shared, named[name] + " (" + named[number] + ")")
    return dict(zip(named[number].str.removesuffix(".0"), texts, strict=True))


def _image(folder: Path, texture: str) -> Path | None:
    paths = (folder / f"img{texture}.jpg", folder / f"{texture}.jpg")
    return next((path for path in paths if path.is_file()), None)

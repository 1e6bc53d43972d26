"""A plain folder: one folder per material with signal files in it, and a table of what else is known.

``MATERIAL/*.{wav,flac,csv,tsv,npz,xlsx}``, also deeper; the first folder names the material. A picture in a material's
folder, if it is the only one there, is the photograph of all its recordings.

An optional ``recordings.csv`` has a column ``file`` (relative path) and any of ``material``, ``speed_mm_s``,
``force_n``, ``direction_deg``, ``contactor``, ``session``, ``subject``, ``image`` (relative path),
``image_width_mm``, ``simulated`` (yes or no); ``unit``, ``rate`` (Hz) and ``axes`` (``x y z``), where the file does
not say; ``stream`` (by default after the unit: m/s^2 is ``acceleration``, 1 is ``vibration``); ``rating_WORD``.
Other columns become labels; ``recording``, a number, gives the order in time. A row whose file is missing is an
error; a file without a row is not. A file that says of itself that it is simulated is.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactogram.datasets.importer import Item
from tactogram.datasets.recording import Recording
from tactogram.errors import DataError
from tactogram.signal.io import read_file

NAME = "folder"
TITLE = "a plain folder of recordings"
LICENCE = "not stated"
DESCRIPTION = (
    "MATERIAL/*.{wav,flac,csv,tsv,npz,xlsx}, with an optional recordings.csv: file, material, speed_mm_s, force_n, "
    "direction_deg, contactor, session, subject, image, unit, rate, axes, stream, rating_WORD, and labels."
)

TABLE = "recordings.csv"
SUFFIXES = (".wav", ".flac", ".csv", ".tsv", ".npz", ".xlsx")
PICTURES = (".jpg", ".jpeg", ".png", ".webp", ".bmp", ".tif", ".tiff")
NUMBERS = ("speed_mm_s", "force_n", "direction_deg")
TEXTS = ("contactor", "session", "subject")
READING = ("unit", "rate", "axes", "stream", "image", "image_width_mm", "material", "file")
STREAM_OF_UNIT = {
    "m/s^2": "acceleration",
    "m/s": "velocity",
    "m": "position",
    "N": "force",
    "V": "voltage",
    "1": "vibration",
}


def find(folder: Path) -> list[Item]:
    """Return an item per signal file."""
    rows = _table(folder / TABLE)
    pictures: dict[Path, list[Path]] = {}
    signals: dict[str, Path] = {}
    for path in sorted(folder.rglob("*"), key=_natural):
        relative = path.relative_to(folder)
        if not path.is_file() or any(part.startswith(".") for part in relative.parts):
            continue
        if path.suffix.lower() in PICTURES:
            pictures.setdefault(path.parent, []).append(path)
        elif path.suffix.lower() in SUFFIXES and relative.as_posix() != TABLE:
            signals[relative.as_posix()] = path
    missing = sorted(rows.keys() - signals.keys())
    if missing:
        raise DataError(
            f"{folder / TABLE}: row {rows[missing[0]]['row']}: there is no signal file {missing[0]}"
        )
    items = []
    for name, path in signals.items():
        info = dict(rows.get(name, {}))
        top = name.split("/")[0] if "/" in name else ""
        info["material"] = info.get("material") or top
        if not info["material"]:
            raise DataError(f"{name}: must stand in a folder named after its material, or have it in {TABLE}")
        own = pictures.get(folder / top, []) if top else []
        image = folder / info["image"] if info.get("image") else own[0] if len(own) == 1 else None
        items.append(Item(name, (path,), info, image, info.pop("image_width_mm", None)))
    return items


def read(item: Item) -> list[Recording]:
    """Return the recording in one file."""
    [path] = item.paths
    info = item.info
    file = read_file(path, unit=info.get("unit"), rate=info.get("rate"), axes=info.get("axes"))
    signal, timing = file.signal, file.timing
    history: tuple[str, ...] = ()
    if timing is not None and not timing.even:
        history = (
            f"stamps show {timing.rate:g} Hz, jitter {timing.jitter_rms * 1e6:.0f} us rms, {timing.dropped} samples "
            f"lost; resampled to {signal.rate:g} Hz",
        )
    known: dict[str, Any] = {name: info.get(name) for name in (*NUMBERS, *TEXTS)}
    return [
        Recording(
            streams={info.get("stream") or STREAM_OF_UNIT[signal.unit]: signal},
            material=info["material"],
            ratings=info.get("ratings", {}),
            labels=info.get("labels", {}),
            source=item.name,
            history=history,
            simulated=info.get("simulated", False) or str(file.metadata.get("simulated")).lower() == "true",
            **known,
        )
    ]


def _table(path: Path) -> dict[str, dict[str, Any]]:
    """Return the rows of ``recordings.csv`` by file; empty if there is none."""
    if not path.is_file():
        return {}
    rows: dict[str, dict[str, Any]] = {}
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file)
            if "file" not in (reader.fieldnames or ()):
                raise DataError(f"{path}: needs a column 'file', got {', '.join(reader.fieldnames or ())}")
            for number, values in enumerate(reader, 2):
                row = _row(f"{path}: row {number}", values)
                if row["file"] in rows:
                    raise DataError(
                        f"{path}: row {number}: {row['file']} stands in row {rows[row['file']]['row']} too"
                    )
                rows[row["file"]] = row | {"row": number}
    except UnicodeDecodeError as error:
        raise DataError(f"{path}: must be UTF-8 text: {error}") from error
    return rows


def _row(where: str, values: Mapping[str | None, Any]) -> dict[str, Any]:
    """Return what one row says, in its types."""
    if None in values:
        raise DataError(f"{where} has more values than there are columns")
    texts = {str(name): text.strip() for name, text in values.items() if text and text.strip()}
    if "file" not in texts:
        raise DataError(f"{where} names no file")
    row: dict[str, Any] = {"ratings": {}, "labels": {}, "file": Path(texts["file"]).as_posix()}
    for name, text in texts.items():
        if name in (*NUMBERS, "rate", "image_width_mm"):
            row[name] = _number(where, name, text)
        elif name.startswith("rating_"):
            row["ratings"][name.removeprefix("rating_")] = _number(where, name, text)
        elif name == "axes":
            row["axes"] = tuple(re.split(r"[\s,;]+", text))
        elif name == "simulated":
            row["simulated"] = _yes(where, name, text)
        elif name in (*TEXTS, *READING):
            row.setdefault(name, text)
        else:
            row["labels"][name] = text
    return row


def _number(where: str, name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise DataError(f"{where}: {name} must be a number, got {text!r}")
    return value


def _yes(where: str, name: str, text: str) -> bool:
    if text.lower() not in ("yes", "true", "1", "no", "false", "0"):
        raise DataError(f"{where}: {name} must be yes or no, got {text!r}")
    return text.lower() in ("yes", "true", "1")


def _natural(path: Path) -> list[tuple[int, int, str]]:
    return [(0, int(p), "") if p.isdecimal() else (1, 0, p) for p in re.split(r"(\d+)", path.as_posix()) if p]

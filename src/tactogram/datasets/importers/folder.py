"""A plain folder: one folder per material with signal files in it, and an optional table of metadata.

``MATERIAL/*.{wav,flac,csv,tsv,txt,npz,xlsx,mat,lvm}``, also deeper; the first folder names the material. A picture with
the name of a recording (``MATERIAL/take1.jpg``, ``take1.wav``) is that recording's photograph. Of the other pictures
in a material's folder, a single one is the photograph of all its recordings without one; several are photographs of
the material. A folder may hold photographs alone.

Items that are rated but have no material, such as display signals or images, lie in folders that the option ``items``
names (``items=signals,images``): each file's name without suffix becomes the label ``item`` of a signal, or the
material of a picture. A row of ``recordings.csv`` may set another ``item``.

An optional ``recordings.csv`` has a column ``file`` (relative path) and any of ``material``, ``speed_mm_s``,
``force_n``, ``direction_deg``, ``contactor``, ``session``, ``subject``, ``image`` (relative path),
``image_width_mm``, ``simulated`` (yes or no); ``unit``, ``rate`` (Hz) and ``axes`` (``x y z``), where the file does
not state them; ``stream`` (by default after the unit: m/s^2 is ``acceleration``, 1 is ``vibration``); ``rating_WORD``.
Other columns become labels; ``recording``, a number, gives the order in time. A row whose file is missing is an
error; a file without a row is not. A file whose metadata marks it as simulated stays simulated.

A table with a column of words or codes headed ``material``, ``surface``, ``texture``, ``label``, ``class`` or
``activity`` is cut where the label changes, time goes back or samples are missing for longer than is interpolated:
each part is a recording of that material, unless the file's row states one. Beside it, columns ``session``,
``subject`` or ``participant``, and ``trial`` or ``take`` (the label ``trial``) also cut.

The options ``unit``, ``rate``, ``axes`` (``x,y,z``) and ``stream`` apply to all files; a row takes precedence. The
option ``mapping`` says what the columns of tables with certain headings hold, and ``material_from`` names the material
by something else than the first folder (`MATERIAL_FROM`): then a folder's pictures are those of recordings alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Any

from tactogram.datasets.cells import finite_number
from tactogram.datasets.file_parts import FilePart, read_parts
from tactogram.datasets.importer import ImportedPhotograph, ImportItem, LeftOut, check_positive, files_below
from tactogram.datasets.mapping import TableMapping
from tactogram.datasets.recording import FileReading, Recording
from tactogram.datasets.store.photographs import PICTURES
from tactogram.errors import DataError, ParameterError
from tactogram.signal.io import SignalFile
from tactogram.signal.io.layout import IGNORED, TRIAL, ColumnUse
from tactogram.signal.io.table import is_table
from tactogram.signal.units import parse_unit
from tactogram.text_files import read_table

TITLE = "a plain folder of recordings"
LICENCE = "not stated"
DESCRIPTION = (
    "MATERIAL/*.{wav,flac,csv,tsv,txt,npz,xlsx,mat,lvm}, with an optional recordings.csv: file, material, speed_mm_s, "
    "force_n, direction_deg, contactor, session, subject, image, unit, rate, axes, stream, rating_WORD, and labels. "
    "Pictures in MATERIAL/ are its photographs, or a recording's own if they have its name."
)

TABLE = "recordings.csv"
DOCUMENTS = (
    *(".md", ".rst", ".pdf", ".doc", ".docx", ".odt", ".rtf", ".html"),
    *(".json", ".toml", ".yaml", ".yml", ".xml", ".ini", ".cfg", ".py", ".m", ".r", ".ino"),
)
"""Suffixes of files that are no recordings, and are not mentioned."""
METADATA = ("meta/device.csv", "meta/time.csv", "Metadata.csv")
"""Ends of the names of such tables, as phyphox and Sensor Logger write them."""
SUFFIXES = (".wav", ".flac", ".csv", ".tsv", ".npz", ".xlsx", ".mat", ".lvm")
NUMBERS = ("speed_mm_s", "force_n", "direction_deg")
TEXTS = ("contactor", "session", "subject")
READING = ("unit", "rate", "axes", "stream", "image", "image_width_mm", "material", "file")
MATERIAL_FROM: dict[str, Callable[[PurePosixPath], str]] = {
    "folder": lambda path: path.parts[0] if len(path.parts) > 1 else "",
    "last_folder": lambda path: path.parent.name,
    "file": lambda path: re.sub(r"[\s_.-]*(\d+|\(\d+\))$", "", path.stem) or path.stem,
    "file_start": lambda path: path.stem.partition("_")[0] or path.stem,
}
"""Material by the path of a file: first folder, last folder, name without a number at its end, or up to its first _."""


def find(
    folder: Path,
    *,
    items: str = "",
    unit: str = "",
    rate: float | None = None,
    axes: str | Sequence[str] = "",
    stream: str = "",
    mapping: TableMapping | None = None,
    material_from: str = "folder",
) -> list[ImportItem]:
    """Return an item per signal file; those in the folders ``items``, separated by commas, have no material."""
    if material_from not in MATERIAL_FROM:
        raise ParameterError(
            f"material_from must be one of {', '.join(MATERIAL_FROM)}, got {material_from!r}"
        )
    rows = _table(folder / TABLE)
    defaults = _options(unit, rate, axes, stream)
    if mapping is not None:
        if not isinstance(mapping, TableMapping):
            raise ParameterError(f"mapping must be a TableMapping, got {mapping!r}; read_mapping reads one")
        defaults["layouts"] = mapping.layout
    signals = _signals(folder)
    recording_pictures, material_pictures = _pictures(folder, signals)
    missing = sorted(rows.keys() - signals.keys())
    if missing:
        raise DataError(
            f"{folder / TABLE}: row {rows[missing[0]]['row']}: there is no signal file {missing[0]}"
        )
    found = []
    item_folders = _item_folders(folder, items)
    for name, path in signals.items():
        info = defaults | rows.get(name, {})
        top = name.split("/")[0] if "/" in name else ""
        info["whole"] = bool(info.get("material")) or top in item_folders
        if top in item_folders:
            info["labels"] = {"item": path.stem} | info.get("labels", {})
            info.setdefault("material", None)
        else:
            info["material"] = info.get("material") or MATERIAL_FROM[material_from](PurePosixPath(name))
        if not info["material"] and not info.get("labels", {}).get("item"):
            info["problem"] = (
                f"{name}: must be in a folder named after its material, or have it in {TABLE}, or in its own name "
                "with `material_from=file`"
            )
        info["material"] = info["material"] or None
        ours = material_from == "folder" and top not in item_folders
        pictures = material_pictures.get(top, []) if ours else []
        shared = pictures[0] if len(pictures) == 1 else None
        image = folder / info["image"] if info.get("image") else recording_pictures.get(name, shared)
        found.append(ImportItem(name, (path,), info, image, info.pop("image_width_mm", None)))
    return found


def photographs(folder: Path, *, items: str = "", material_from: str = "folder") -> list[ImportedPhotograph]:
    """Return the pictures of materials with several pictures or no recording, and those of ``items``."""
    rows = _table(folder / TABLE)
    signals = _signals(folder)
    _, material_pictures = _pictures(folder, signals)
    named = {folder / row["image"] for row in rows.values() if row.get("image")}
    recorded: dict[str, set[str]] = {}
    for name in signals:
        top = name.split("/")[0]
        recorded.setdefault(top, set()).add(rows.get(name, {}).get("material") or top)
    found = []
    item_folders = _item_folders(folder, items)
    for top, paths in material_pictures.items():
        materials = recorded.get(top, {top})
        if top in item_folders:
            chosen = [(path, path.stem) for path in paths]
        elif material_from == "folder" and len(materials) == 1 and (len(paths) > 1 or top not in recorded):
            [material] = materials
            chosen = [(path, material) for path in paths if path not in named]
        else:
            continue
        found += [
            ImportedPhotograph(path.relative_to(folder).as_posix(), path, shown) for path, shown in chosen
        ]
    return found


def read(item: ImportItem) -> list[Recording | LeftOut]:
    """Return the recording in one file, or those in a table with labels and the parts of it that are none."""
    [path] = item.paths
    parts = read_parts(path, item.info, name=item.name)
    return [part if isinstance(part, LeftOut) else _recording(item, part) for part in parts]


def _recording(item: ImportItem, part: FilePart) -> Recording:
    info = item.info
    file = next(iter(part.streams.values()))
    timing = file.timing
    history: tuple[str, ...] = ()
    if timing is not None and not timing.even:
        history = (
            f"stamps show {timing.rate:g} Hz, jitter {timing.jitter_rms * 1e6:.0f} us rms, {timing.dropped} samples "
            f"lost; resampled to {file.signal.rate:g} Hz",
        )
    metadata: dict[str, Any] = {name: info.get(name) for name in ("material", *NUMBERS, *TEXTS)}
    metadata |= {role: label for role, label in part.labels.items() if role != TRIAL}
    trial = {TRIAL: part.labels[TRIAL]} if TRIAL in part.labels else {}
    return Recording(
        streams={name: read.signal for name, read in part.streams.items()},
        ratings=info.get("ratings", {}),
        labels=info.get("labels", {}) | trial,
        source=item.name if part.number is None else f"{item.name}#{part.number}",
        history=history,
        simulated=info.get("simulated", False) or str(file.metadata.get("simulated")).lower() == "true",
        reading=FileReading(
            columns=_uses(part.streams),
            mapped=file.layout is not None,
            timing=timing,
            rate_estimated=timing is not None
            and (info.get("rate") or (file.layout and file.layout.rate)) is None,
        ),
        **metadata,
    )


def _uses(files: Mapping[str, SignalFile]) -> tuple[ColumnUse, ...]:
    """Return what each column was read as; of several streams, the axes have their stream's name in front."""
    found: list[ColumnUse] = []
    for stream, file in files.items():
        uses = file.columns
        if len(files) > 1:
            uses = tuple(
                replace(use, role=f"{stream}: {use.role}") if use.role in file.signal.axes else use
                for use in uses
            )
        found = [new if old.role == IGNORED else old for old, new in zip(found or uses, uses, strict=True)]
    return tuple(found)


def _item_folders(folder: Path, items: str) -> set[str]:
    names = {name.strip() for name in items.split(",") if name.strip()}
    for name in sorted(names):
        if not (folder / name).is_dir():
            raise DataError(f"{folder / name}: must be a folder of rated files")
    return names


def left_out(folder: Path) -> list[tuple[str, str]]:
    """Return the files in folders of materials that may be recordings in another format, with the reason."""
    signals, pictures = _signals(folder), files_below(folder, PICTURES)
    read = {path.with_suffix("") for path in (*signals.values(), *pictures.values())}
    return [
        (name, f"{name}: {_reason(path)}")
        for name, path in files_below(folder, None).items()
        if "/" in name
        and path.suffix.lower() not in DOCUMENTS
        and not name.endswith(METADATA)
        and path.with_suffix("") not in read
    ]


def _reason(path: Path) -> str:
    if path.suffix.lower() == ".txt":
        return "not a table of numbers"
    known = ", ".join((*SUFFIXES, ".txt"))
    return f"suffix must be one of {known}, got {path.suffix or 'none'}; export it as .csv"


def _signals(folder: Path) -> dict[str, Path]:
    files = files_below(folder, (*SUFFIXES, ".txt"))
    return {
        name: path
        for name, path in files.items()
        if name != TABLE and not name.endswith(METADATA) and (path.suffix.lower() != ".txt" or is_table(path))
    }


def _pictures(folder: Path, signals: Mapping[str, Path]) -> tuple[dict[str, Path], dict[str, list[Path]]]:
    """Return the picture of each recording that has one of its name, and the others by material folder."""
    stems = {path.with_suffix(""): name for name, path in signals.items()}
    recording_pictures: dict[str, Path] = {}
    material_pictures: dict[str, list[Path]] = {}
    for name, path in files_below(folder, PICTURES).items():
        if path.with_suffix("") in stems:
            recording_pictures[stems[path.with_suffix("")]] = path
        elif "/" in name:
            material_pictures.setdefault(name.split("/")[0], []).append(path)
    return recording_pictures, material_pictures


def _table(path: Path) -> dict[str, dict[str, Any]]:
    """Return the rows of ``recordings.csv`` by file; empty if there is none."""
    if not path.is_file():
        return {}
    rows: dict[str, dict[str, Any]] = {}
    for number, values in read_table(path, needed=("file",)):
        row = _row(f"{path}: row {number}", values)
        if row["file"] in rows:
            raise DataError(
                f"{path}: row {number}: {row['file']} is also in row {rows[row['file']]['row']}; leave one out"
            )
        rows[row["file"]] = row | {"row": number}
    return rows


def _row(where: str, values: Mapping[str, str]) -> dict[str, Any]:
    texts = {name: text.strip() for name, text in values.items() if text.strip()}
    if "file" not in texts:
        raise DataError(f"{where} names no file")
    row: dict[str, Any] = {"ratings": {}, "labels": {}, "file": Path(texts["file"]).as_posix()}
    for name, text in texts.items():
        if name in (*NUMBERS, "rate", "image_width_mm"):
            row[name] = finite_number(where, name, text)
            if name in ("speed_mm_s", "force_n") and row[name] < 0:
                raise DataError(f"{where}: {name} must be at least 0, got {text}")
        elif name.startswith("rating_"):
            row["ratings"][name.removeprefix("rating_")] = finite_number(where, name, text)
        elif name == "axes":
            row["axes"] = _names(text)
        elif name == "simulated":
            row["simulated"] = _yes(where, name, text)
        elif name in (*TEXTS, *READING):
            row.setdefault(name, text)
        else:
            row["labels"][name] = text
    return row


def _options(unit: str, rate: float | None, axes: str | Sequence[str], stream: str) -> dict[str, Any]:
    """Return the options as a row that applies to every file; invalid ones are refused before any file is read."""
    row: dict[str, Any] = {}
    if unit != "":
        parse_unit(str(unit))
        row["unit"] = str(unit)
    if rate is not None:
        check_positive(rate=rate)
        row["rate"] = float(rate)
    if axes != "":
        row["axes"] = tuple(map(str, axes)) if isinstance(axes, list | tuple) else _names(str(axes))
    if stream != "":
        row["stream"] = str(stream)
    return row


def _names(text: str) -> tuple[str, ...]:
    return tuple(re.findall(r"[^\s,;]+", text))


def _yes(where: str, name: str, text: str) -> bool:
    if text.lower() not in ("yes", "true", "1", "no", "false", "0"):
        raise DataError(f"{where}: {name} must be yes or no, got {text!r}")
    return text.lower() in ("yes", "true", "1")

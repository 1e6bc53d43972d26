"""A plain folder: one folder per material with signal files in it, and an optional table of metadata.

``MATERIAL/*.{wav,flac,csv,tsv,txt,npz,xlsx,mat,lvm}``, also deeper. The first folder names the material, unless
``path`` (`PathPattern`) or ``material_from`` (`MATERIAL_FROM`) says otherwise; without either, first folders that look
like people, speeds, takes and so on are asked about. Files of one take are streams of one recording
(`tactogram.datasets.takes`); labels in a table and holes divide it (`tactogram.datasets.file_parts`).

A picture with the name of a recording (``MATERIAL/take1.jpg``, ``take1.wav``) is that recording's photograph. Of the
other pictures in a material's folder, a single one is the photograph of all its recordings without one; several are
photographs of the material. A folder may hold photographs alone. With ``path`` or ``material_from`` the pictures of a
folder are those of recordings alone.

Items that are rated but have no material, such as display signals or images, lie in folders that the option ``items``
names (``items=signals,images``): each file's name without suffix becomes the label ``item`` of a signal, or the
material of a picture. A row of ``recordings.csv`` may set another ``item``.

An optional ``recordings.csv`` has a column ``file`` (relative path) and any of `NUMBERS`, `TEXTS` and `READING`,
``simulated`` (yes or no) and ``rating_WORD``. Other columns become labels; ``recording``, a number, gives the order in
time. A row whose file is missing is an error; a file without a row is not. A file whose metadata marks it as simulated
stays simulated. The options ``unit`` (several, separated by commas, for streams of several quantities), ``rate``,
``axes`` (``x,y,z``), ``stream`` and ``mapping`` apply to all files; a row takes precedence.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

from tactogram.datasets.cells import finite_number
from tactogram.datasets.file_parts import FilePart, has_labels, read_parts
from tactogram.datasets.importer import ImportedPhotograph, ImportItem, LeftOut, check_positive, files_below
from tactogram.datasets.mapping import TableMapping
from tactogram.datasets.path_reading import PathPattern, PathReading, read_paths
from tactogram.datasets.recording import Recording
from tactogram.datasets.store.photographs import PICTURES
from tactogram.datasets.takes import Take, is_no_signal, quantity_of, takes
from tactogram.errors import DataError, Message, ParameterError, Remedy
from tactogram.signal.io.content import TRIAL
from tactogram.signal.io.files import READABLE, USUAL
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
METADATA = ("meta/device.csv", "meta/time.csv", "Metadata.csv", "Annotation.csv")
"""Ends of the names of such tables, as phyphox and Sensor Logger write them."""
NOTES = (".txt", ".dat", ".asc", ".log", ".tab")
"""Suffixes of texts, which are recordings only if they hold a table."""
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
    path: str = "",
    material_from: str = "",
) -> list[ImportItem]:
    """Return an item per take; those in the folders ``items``, separated by commas, have no material."""
    pattern = _pattern(path, material_from)
    rows = _table(folder / TABLE)
    defaults = _options(unit, rate, axes, stream)
    if mapping is not None:
        if not isinstance(mapping, TableMapping):
            raise ParameterError.must(
                "mapping", "be a TableMapping", mapping, remedy="read_mapping reads one"
            )
        defaults["layouts"] = mapping.layout
    signals, _ = _signals(folder)
    found_takes = takes(signals)
    recording_pictures, material_pictures = _pictures(folder, found_takes)
    missing = sorted(rows.keys() - signals.keys())
    if missing:
        raise DataError(
            f"{folder / TABLE}: row {rows[missing[0]]['row']}", f"there is no signal file {missing[0]}"
        )
    import_items = []
    item_folders = _item_folders(folder, items)
    for take in found_takes:
        name = take.files[0][0]
        info: dict[str, Any] = dict(defaults)
        for file, _ in reversed(take.files):
            info |= rows.get(file, {})
        top = name.split("/")[0] if "/" in name else ""
        if pattern is not None and top not in item_folders:
            stated = _fields(pattern, take)
            if stated is None:
                problem = f"must be named as path={pattern.text} says"
                info["mismatch"] = Message(problem, "correct it", "move it away", place=name)
            else:
                info = stated | info | {"labels": stated["labels"] | info.get("labels", {})}
        info["whole"] = bool(info.get("material")) or top in item_folders
        info["streams"] = tuple(stream for _, stream in take.files)
        if top in item_folders:
            info["labels"] = {"item": PurePosixPath(name).stem} | info.get("labels", {})
            info.setdefault("material", None)
        elif pattern is None:
            rule = MATERIAL_FROM[material_from or "folder"]
            info["material"] = info.get("material") or rule(PurePosixPath(_place(take)))
        named = info.get("material") or info.get("labels", {}).get("item")
        if not named and (
            path or material_from or any("/" in signal for signal in signals)
        ):  # else it is asked
            info["problem"] = Message(
                f"must be in a folder named after its material, or have it in {TABLE}",
                Remedy("have it in its own name with", "path", "{material}_{take}"),
                place=name,
            )
        info["material"] = info.get("material") or None
        ours = pattern is None and not material_from and top not in item_folders
        pictures = material_pictures.get(top, []) if ours else []
        shared = pictures[0] if len(pictures) == 1 else None
        image = folder / info["image"] if info.get("image") else recording_pictures.get(take.name, shared)
        paths = tuple(signals[file] for file, _ in take.files)
        import_items.append(ImportItem(name, paths, info, image, info.pop("image_width_mm", None)))
    return import_items


def paths(
    folder: Path,
    *,
    items: str = "",
    path: str = "",
    material_from: str = "",
    mapping: TableMapping | None = None,
) -> PathReading:
    """Return a pattern that the paths suggest, what to ask about their materials, and which files hold no signals."""
    signals, without = _signals(folder)
    listed = ", ".join(dict.fromkeys(PurePosixPath(name).name for name in without))
    notes = (f"no signals, not read: {listed} ({len(without)} file{'s' * (len(without) != 1)})",) * bool(
        without
    )
    if apart := _axes_apart(signals):
        notes += (
            f"files of one axis each ({', '.join(apart)}, …) become recordings of one axis: put the axes of a take "
            "into one table to keep them together",
        )
    rows, item_folders = _table(folder / TABLE), _item_folders(folder, items)
    unnamed = [
        take
        for take in takes(signals)
        if not any(rows.get(file, {}).get("material") for file, _ in take.files)
        and take.files[0][0].split("/")[0] not in item_folders
    ]
    if path or material_from or not unnamed:
        return PathReading(notes=notes)
    places = [_place(take) for take in unnamed]
    reading = read_paths(
        [take.name for take in unnamed], [take_path.split("/")[0] for take_path in places if "/" in take_path]
    )
    layouts = () if mapping is None else mapping.layout
    if reading.question and has_labels(signals[unnamed[0].files[0][0]], layouts):
        return PathReading(notes=notes)
    question = reading.question and Message(reading.question, place=folder)
    return PathReading(reading.proposed, question, notes)


def photographs(
    folder: Path, *, items: str = "", path: str = "", material_from: str = ""
) -> list[ImportedPhotograph]:
    """Return the pictures of materials with several pictures or no recording, and those of ``items``."""
    rows = _table(folder / TABLE)
    signals, _ = _signals(folder)
    _, material_pictures = _pictures(folder, takes(signals))
    named = {folder / row["image"] for row in rows.values() if row.get("image")}
    recorded: dict[str, set[str]] = {}
    for name in signals:
        top = name.split("/")[0]
        recorded.setdefault(top, set()).add(rows.get(name, {}).get("material") or top)
    imported = []
    item_folders = _item_folders(folder, items)
    for top, pictures in material_pictures.items():
        materials = recorded.get(top, {top})
        if top in item_folders:
            chosen = [(picture, picture.stem) for picture in pictures]
        elif (
            not (path or material_from) and len(materials) == 1 and (len(pictures) > 1 or top not in recorded)
        ):
            [material] = materials
            chosen = [(picture, material) for picture in pictures if picture not in named]
        else:
            continue
        imported += [
            ImportedPhotograph(picture.relative_to(folder).as_posix(), picture, shown)
            for picture, shown in chosen
        ]
    return imported


def read(item: ImportItem) -> list[Recording | LeftOut]:
    """Return the recording in the files of a take, or those that they divide into and the parts that are none."""
    if "mismatch" in item.info:
        raise DataError(item.info["mismatch"])
    parts = read_parts(item.paths, item.info["streams"], item.info, name=item.name)
    return [part if isinstance(part, LeftOut) else _recording(item, part) for part in parts]


def _pattern(path: str, material_from: str) -> PathPattern | None:
    if material_from and material_from not in MATERIAL_FROM:
        raise ParameterError.one_of("material_from", MATERIAL_FROM, material_from)
    if path and material_from:
        remedy = Remedy("or omit the short spelling of patterns,", "material_from")
        raise ParameterError.must("path", "be omitted", remedy=remedy)
    return PathPattern(str(path)) if path else None


def _place(take: Take) -> str:
    """Return the path of a take's first file, without a folder that names its quantity."""
    name = take.files[0][0]
    return name if name.startswith(take.name) else take.name


def _fields(pattern: PathPattern, take: Take) -> dict[str, Any] | None:
    """Return the metadata in the path of a take: without the quantity in its files' names, or with it."""
    ways = (take.name, take.files[0][0])
    alike = sorted(ways, key=lambda name: name.count("/") + 1 != pattern.levels)
    return next((fields for name in alike if (fields := pattern.fields(name)) is not None), None)


def _recording(item: ImportItem, part: FilePart) -> Recording:
    info, timing = item.info, part.reading.timing
    history: tuple[str, ...] = ()
    if timing is not None and not timing.even:
        rate = next(iter(part.streams.values())).rate
        history = (
            f"stamps show {timing.rate:g} Hz, jitter {timing.jitter_rms * 1e6:.0f} us rms, {timing.dropped} samples "
            f"lost; resampled to {rate:g} Hz",
        )
    metadata: dict[str, Any] = {name: info.get(name) for name in ("material", *NUMBERS, *TEXTS)}
    metadata |= {role: label for role, label in part.labels.items() if role != TRIAL}
    trial = {TRIAL: part.labels[TRIAL]} if TRIAL in part.labels else {}
    return Recording(
        streams=part.streams,
        ratings=info.get("ratings", {}),
        labels=info.get("labels", {}) | trial,
        source=item.name if part.number is None else f"{item.name}#{part.number}",
        history=history,
        simulated=info.get("simulated", False) or str(part.metadata.get("simulated")).lower() == "true",
        reading=part.reading,
        **metadata,
    )


def _item_folders(folder: Path, items: str) -> set[str]:
    names = {name.strip() for name in items.split(",") if name.strip()}
    for name in sorted(names):
        if not (folder / name).is_dir():
            raise DataError(folder / name, "must be a folder of rated files")
    return names


def left_out(folder: Path) -> list[tuple[str, str]]:
    """Return the files in folders of materials that may be recordings in another format, with the reason."""
    (signals, without), pictures = _signals(folder), files_below(folder, PICTURES)
    read = {path.with_suffix("") for path in (*signals.values(), *pictures.values())}
    return [
        (name, Message(_reason(path), place=name))
        for name, path in files_below(folder, None).items()
        if "/" in name
        and path.suffix.lower() not in DOCUMENTS
        and name not in without
        and path.with_suffix("") not in read
    ]


def _reason(path: Path) -> str:
    if path.suffix.lower() in NOTES:
        return "not a table of numbers"
    return f"suffix must be one of {USUAL}, got {path.suffix or 'none'}; export it as .csv"


def _signals(folder: Path) -> tuple[dict[str, Path], list[str]]:
    """Return the signal files, and the tables beside those of sensors that hold none."""
    files = files_below(folder, READABLE)
    sensors = {str(path.parent) for path in files.values() if quantity_of(path.stem)}
    without = [
        name
        for name, path in files.items()
        if name.endswith(METADATA) or (is_no_signal(name) and str(path.parent) in sensors)
    ]
    signals = {
        name: path
        for name, path in files.items()
        if name != TABLE and name not in without and (path.suffix.lower() not in NOTES or is_table(path))
    }
    return signals, without


def _axes_apart(signals: Iterable[str]) -> list[str]:
    """Return the first files that are named alike but for x, y and z at their ends."""
    stems: dict[str, list[str]] = {}
    for name in signals:
        if match := re.fullmatch(r"(?:(.*)[\W_])?[xyzXYZ]", str(PurePosixPath(name).with_suffix(""))):
            stems.setdefault(match[1] or "", []).append(name)
    return next((names for names in stems.values() if len(names) > 1), [])


def _pictures(folder: Path, found: Sequence[Take]) -> tuple[dict[str, Path], dict[str, list[Path]]]:
    """Return the picture of each take that has one of its name, or of a file's, and the others by material folder."""
    stems = {take.name: take.name for take in found}
    stems |= {str(PurePosixPath(name).with_suffix("")): take.name for take in found for name, _ in take.files}
    recording_pictures: dict[str, Path] = {}
    material_pictures: dict[str, list[Path]] = {}
    for name, path in files_below(folder, PICTURES).items():
        if take := stems.get(str(PurePosixPath(name).with_suffix(""))):
            recording_pictures[take] = path
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
                f"{path}: row {number}",
                f"{row['file']} is also in row {rows[row['file']]['row']}; leave one out",
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
                raise DataError(where, f"{name} must be at least 0, got {text}")
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
        for each in str(unit).split(","):
            parse_unit(each.strip())
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
        raise DataError(where, f"{name} must be yes or no, got {text!r}")
    return text.lower() in ("yes", "true", "1")

"""LMT-108 surface materials: sound and acceleration of a tool stroked freely over a surface, and photographs.

M. Strese, C. Schuwerk, A. Iepure, E. Steinbach, "Multimodal Feature-Based Surface Material Classification", IEEE
Transactions on Haptics 10(2), 2017.

Read from files in any folder by their names: ``G1RhombAluminumMesh_Sound_Movement_train1.wav`` (or ``.flac``), and
accelerations ``G1RhombAluminumMesh_Movement_X_train1.txt``, one number per line, one file per axis, 10 kHz. Sound and
acceleration of one stroke become one recording.

Photographs are ``ImageScans/NoFlash/Training/G1RhombAluminumMesh_Image_1_train1.jpg``, ten per material and part, of
320 x 480 pixels without a scale; those in a folder ``Flash`` are left out, as in the visual-tactile GAN (Sec. 4.1).
They belong to their material, not to a stroke: which place was photographed and which was stroked is unknown.

Sound (44.1 kHz, WAV and FLAC) was checked on real files. **No real acceleration file was at
hand**: that they are in m/s^2 is our assumption, which ``history`` repeats. **No real photograph was at hand**: folder
and file names are those that public code for this set opens. Sound is a microphone signal, full scale 1: band-limit it
to 20-1000 Hz before treating it as vibration, and call it sound.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import PICTURES, ImportedPhotograph, ImportItem, Recording, number_columns
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import read_signal

TITLE = "LMT-108 surface materials"
LICENCE = "not stated"
DESCRIPTION = (
    "Files named G1Material_Sound_Movement_train1.flac|wav (sound, full scale) and "
    "G1Material_Movement_X_train1.txt (acceleration, taken as m/s^2, 10 kHz). Sound checked on real files, "
    "acceleration not; ImageScans/NoFlash/**/G1Material_Image_1_train1.jpg (photographs of materials), not checked "
    "either. Options: part (train or test), materials (such as G4Bamboo,G9Jeans)."
)

ACCELERATION_RATE = 10_000.0

_SOUND = re.compile(r"(G\d+)(.+)_Sound_Movement_([A-Za-z]*)(\d+)\.(?:flac|wav)", re.IGNORECASE)
_AXIS = re.compile(r"(G\d+)(.+)_Movement_([XYZ])_([A-Za-z]*)(\d+)\.txt", re.IGNORECASE)
_IMAGE = re.compile(r"(G\d+)(.+?)_Image(?:_\d+)?_([A-Za-z]*)(\d+)", re.IGNORECASE)


def find(folder: Path, *, part: str = "", materials: str = "") -> list[ImportItem]:
    """Return an item per stroke, of one part and of some materials if asked for."""
    strokes: dict[tuple[str, ...], dict[str, Any]] = {}
    named = list(_named(folder))
    known = {"part": {file[4] for file in named}, "materials": {file[3] for file in named}}
    for option, given in (("part", part), ("materials", materials)):
        if unknown := {name for name in given.split(",") if name} - known[option]:
            raise ParameterError.one_of(option, sorted(known[option]), ", ".join(sorted(unknown)))
    for kind, path, group, material, of_part, number in named:
        if not _is_wanted(material, of_part, materials, part):
            continue
        facts = {"material": material, "group": group, "part": of_part, "recording": number}
        stroke = strokes.setdefault((material, of_part, number), facts)
        if kind in stroke and stroke[kind].stem == path.stem and stroke[kind].suffix != path.suffix:
            continue  # the same sound in another format
        if kind in stroke:
            raise DataError(path, f"a second {kind} of {material}, recording {of_part}{number}; keep one")
        stroke[kind] = path
    items = []
    for stroke in strokes.values():
        paths = [stroke[kind] for kind in ("sound", "X", "Y", "Z") if kind in stroke]
        if 0 < sum(kind in stroke for kind in "XYZ") < 3:
            # All three, so that the reader names the missing one.
            axis = next(kind for kind in "XYZ" if kind in stroke)
            paths = [stroke["sound"]] if "sound" in stroke else []
            paths += [_sibling(stroke[axis], axis, kind) for kind in "XYZ"]
        items.append(ImportItem(paths[0].relative_to(folder).as_posix(), tuple(paths), stroke))
    return items


def photographs(folder: Path, *, part: str = "", materials: str = "") -> list[ImportedPhotograph]:
    """Return the photographs taken without flash."""
    pictures = []
    for path in folder.rglob("*_Image_*"):
        named = _IMAGE.fullmatch(path.stem)
        relative = path.relative_to(folder)
        flash = any(part.lower() == "flash" for part in relative.parts)
        if named and not flash and path.suffix.lower() in PICTURES:
            group, material, of_part, number = named.groups()
            name = group.upper() + material
            key = (int(group[1:]), name, of_part.lower(), int(number))
            if _is_wanted(name, of_part.lower(), materials, part):
                pictures.append((key, ImportedPhotograph(relative.as_posix(), path, name)))
    return [picture for _, picture in sorted(pictures, key=lambda f: (f[0], f[1].name))]


def read(item: ImportItem) -> list[Recording]:
    """Return one stroke."""
    streams, history = {}, []
    tables = [path for path in item.paths if path.suffix.lower() == ".txt"]
    if tables:
        columns = [number_columns(path)[0] for path in tables]
        if len({len(column) for column in columns}) > 1:
            lengths = ", ".join(f"{path.name} {len(c)}" for path, c in zip(tables, columns, strict=True))
            raise DataError(item.name, f"axes must be equally long, got {lengths}")
        streams["acceleration"] = Signal(np.stack(columns), ACCELERATION_RATE, "m/s^2")
        history.append("acceleration taken as m/s^2 at 10 kHz: the files do not say")
    for path in item.paths:
        if path not in tables:
            streams["sound"] = read_signal(path, unit="1")
            history.append("sound of a microphone, full scale 1")
    labels = {name: item.info[name] for name in ("recording", "group", "part")}
    return [
        Recording(
            streams=streams,
            material=item.info["material"],
            contactor="tool",
            labels={name: text for name, text in labels.items() if text},
            source=item.name,
            history=tuple(history),
        )
    ]


def _named(folder: Path) -> Iterator[tuple[str, Path, str, str, str, str]]:
    """Yield kind, path, group, material, part and number of all files below ``folder``, in order."""
    files = []
    for path in folder.rglob("*_Movement_*"):
        if axis := _AXIS.fullmatch(path.name):
            group, material, kind, part, number = axis.groups()
        elif sound := _SOUND.fullmatch(path.name):
            (group, material, part, number), kind = sound.groups(), ""
        else:
            continue
        name = group.upper() + material
        files.append((kind.upper() or "sound", path, group.upper(), name, part.lower(), number))
    if not files:
        raise DataError(folder, "must hold files named like G1Material_Sound_Movement_train1.wav, found none")
    yield from sorted(files, key=lambda f: (int(f[2][1:]), f[3], f[4], int(f[5]), f[0], f[1].suffix))


def _is_wanted(material: str, of_part: str, materials: str, part: str) -> bool:
    asked = ((material, materials), (of_part, part))
    return all(not given or name in given.split(",") for name, given in asked)


def _sibling(path: Path, axis: str, other: str) -> Path:
    return path.with_name(re.sub(f"_Movement_{axis}_", f"_Movement_{other}_", path.name, flags=re.IGNORECASE))

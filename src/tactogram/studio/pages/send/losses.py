"""Haptic files of one signal beside each other: their names, what each loses, and all of them in a zip."""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactogram.rendering.files.catalogue import formats_with, haptic_format
from tactogram.signal.io.atomic import atomic_write


def losses_table(files: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return a row per format (and axis): ``format``, ``axis``, ``bytes`` and the fields of `Loss`, or ``refused``."""
    rows: list[dict[str, Any]] = []
    for name, facts in files.items():
        if "refused" in facts:
            rows.append({"format": name, "axis": "", "refused": facts["refused"]})
            continue
        written = facts["written"]
        loss = written["loss"]
        by_axis = loss if isinstance(next(iter(loss.values()), None), Mapping) else {"": loss}
        rows += [
            {"format": name, "axis": axis, "bytes": written["bytes"], **values}
            for axis, values in by_axis.items()
        ]
    return rows


def file_name(stem: str, name: str) -> str:
    """Return a name that says the format also where formats share a suffix."""
    suffix = haptic_format(name).suffix
    return f"{stem}-{name}{suffix}" if len(formats_with(suffix)) > 1 else f"{stem}{suffix}"


def zip_files(folder: Path, name: str, files: Mapping[str, Any], *, simulated: bool) -> None:
    """Write the files of a folder and the table of what they lose as ``name`` beside them."""
    rows = losses_table(files)
    columns = list(dict.fromkeys(key for row in rows for key in row))
    text = io.StringIO()
    table = csv.DictWriter(text, columns, lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    with atomic_write(folder / name) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
        for facts in files.values():
            if "file" in facts:
                archive.write(folder / facts["file"], facts["file"])
        archive.writestr("losses.csv", text.getvalue())
        if simulated:
            archive.writestr("SIMULATED.txt", "The signal in these files is simulated.\n")

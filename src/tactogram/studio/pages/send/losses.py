"""Losses of haptic files: table, strength over time, and a ZIP of all files."""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.rendering.drive.axes import to_one_axis
from tactogram.rendering.drive.level_scaling import without_constant
from tactogram.rendering.files.analysis import envelope_of
from tactogram.rendering.files.catalogue import haptic_format
from tactogram.rendering.files.conversion import GRAVITY
from tactogram.rendering.files.reading import read_haptic
from tactogram.signal import Signal
from tactogram.signal.displacement import played
from tactogram.signal.io.atomic import atomic_write

MOST_POINTS = 500
Curve = tuple[list[float], list[float]]
"""Times, s, and strengths in the signal's unit."""


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


def loss_text(row: Mapping[str, Any], key: str) -> str:
    """Return one loss for people; "none" where a file has no waveform to compare."""
    value = row[key]
    if key in ("waveform_correlation", "snr_db") and haptic_format(row["format"]).holds != "waveform":
        return "none"
    if value is None:
        return "none"
    return f"{value:.0f}" if key == "snr_db" else f"{value + 0.0:.3f}".replace("-0.000", "0.000")


def strength_curves(
    signal: Signal, folder: Path, files: Mapping[str, Any], *, axis: str, play_at: float | None
) -> dict[str, Curve]:
    """Return the strength over time of a signal and of each file, read back with its level, by name."""
    if signal.domain != "time":
        if play_at is None:
            raise ParameterError("the strength over time of a signal over displacement needs a speed")
        signal = played(signal, play_at, signal.rate * play_at)
    one, _ = to_one_axis(without_constant(signal, least=GRAVITY)[0], axis or None)
    curves = {"signal": _curve(one)}
    for name, facts in files.items():
        if "file" in facts:
            stored = read_haptic(folder / facts["file"], format=name).signal
            if stored.domain == "time":
                curves[haptic_format(name).title] = _curve(to_one_axis(stored, None)[0])
    return curves


def _curve(signal: Signal) -> Curve:
    envelope = envelope_of(signal)
    count = min(MOST_POINTS, len(envelope.times))
    places = np.unique(np.linspace(0, len(envelope.times) - 1, count).astype(int))
    strengths = [float(f"{value:.4g}") for value in envelope.amplitude[places]]
    return [round(float(t), 4) for t in envelope.times[places]], strengths


def zip_files(folder: Path, name: str, files: Mapping[str, Any], *, simulated: bool) -> None:
    """Write the files in a folder and the table of their losses to a ZIP ``name`` in it."""
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

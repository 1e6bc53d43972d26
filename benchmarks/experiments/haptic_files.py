"""Losses of each haptic file format: every effect of VibViz written, checked, read back and compared.

Needs the files of VibViz: ``--set data=FOLDER`` with its WAV files (8 to 48 kHz, one or two channels; two become one
by their mean where a format holds one). No table of a publication: designers ask which format keeps what.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.rendering.files import (
    check_file,
    haptic_format,
    haptic_formats,
    read_haptic,
    to_one_axis,
    write_haptic,
)
from tactogram.rendering.files.conversion import losses
from tactogram.signal import Signal
from tactogram.signal.io import read_signal, write_signal
from tactogram.workflows.progress import ProgressCallback

FIGURES = {
    "envelope_correlation": "envelope r",
    "envelope_error": "envelope error",
    "level_db": "level, dB",
    "frequency_octaves": "frequency, octaves",
    "waveform_correlation": "waveform r",
    "snr_db": "SNR, dB",
}
SIGNAL_FORMATS: dict[str, dict[str, Any]] = {"wav": {}, "wav PCM_16": {"subtype": "PCM_16"}, "csv": {}}


def run(folder: Path, *, paper: bool, progress: ProgressCallback, data: str = "") -> dict[str, Any]:
    """Return figures of each format: the median over effects, the 10th and the 90th percentile.

    Parameters
    ----------
    folder, progress
        As of every experiment.
    paper : bool
        Every effect; else every fourth, which takes a quarter of the time.
    data : str
        Folder with WAV files.
    """
    paths = sorted(Path(data).rglob("*.wav")) if data else []
    if not paths:
        raise ParameterError("data must be a folder with the WAV files of VibViz")
    paths = paths if paper else paths[::4]
    formats: dict[str, dict[str, Any]] = {name: _empty() for name in (*SIGNAL_FORMATS, *haptic_formats())}
    rates, axes, seconds = set(), set(), 0.0
    for path in paths:
        signal = read_signal(path, unit="1")
        rates.add(signal.rate)
        axes.add(len(signal.axes))
        seconds += signal.seconds
        for name, found in formats.items():
            start = time.perf_counter()
            try:
                found["losses"] += _through(name, signal, folder / "files" / path.stem, found)
            except ParameterError as error:
                found["refused"].append(str(error))
            found["seconds"] += time.perf_counter() - start
    rows = {name: _row(found, len(paths), seconds) for name, found in formats.items()}
    result = {
        "effects": len(paths),
        "seconds": round(seconds, 1),
        "rates_hz": sorted(rates),
        "channels": sorted(axes),
        "simulated": False,
        "formats": rows,
    }
    return result | {"text": _text(result)}


def _empty() -> dict[str, Any]:
    return {"losses": [], "refused": [], "seconds": 0.0, "bytes": 0, "valid": 0, "scaled": 0, "reduced": 0}


def _through(name: str, signal: Signal, place: Path, found: dict[str, Any]) -> list[dict[str, Any]]:
    """Write, check and read one effect; return the loss of each axis."""
    if name in SIGNAL_FORMATS:
        path = place.with_suffix(f".{name[:3]}")
        write_signal(path, signal, **SIGNAL_FORMATS[name])
        loss = losses(signal, read_signal(path))
        found["valid"] += 1
    else:
        path = place.with_suffix(haptic_format(name).suffix)
        written = write_haptic(path, signal, format=name)
        found["valid"] += check_file(path, format=name)["valid"]
        found["scaled"] += written["full_scale"] != 1.0
        found["reduced"] += written["reduced_by"] is not None
        one = signal if haptic_format(name).holds == "waveform" else to_one_axis(signal)[0]
        loss = losses(one, read_haptic(path, format=name).signal)
    found["bytes"] += path.stat().st_size
    path.unlink()
    return [loss] if "envelope_error" in loss else list(loss.values())


def _row(found: dict[str, Any], effects: int, seconds: float) -> dict[str, Any]:
    figures: dict[str, Any] = {}
    for figure in FIGURES:
        values = [loss[figure] for loss in found["losses"] if loss[figure] is not None]
        if values:
            low, middle, high = (float(q) for q in np.percentile(values, [10, 50, 90]))
            figures[figure] = {"median": middle, "p10": low, "p90": high, "of": len(values)}
    return {
        "effects": effects,
        "valid": found["valid"],
        "refused": found["refused"],
        "scaled": found["scaled"],
        "made_one_axis": found["reduced"],
        "bytes_per_s": found["bytes"] / seconds,
        "seconds_per_s": found["seconds"] / seconds,
        **figures,
    }


def _text(result: dict[str, Any]) -> str:
    rates = ", ".join(f"{rate:g}" for rate in result["rates_hz"])
    lines = [
        f"{result['effects']} effects of VibViz, {result['seconds']:g} s, {rates} Hz, "
        f"{' or '.join(map(str, result['channels']))} channels; median (10th, 90th percentile)",
        f"{'format':12}{'valid':>7}{'kB/s':>8}" + "".join(f"{title:>26}" for title in FIGURES.values()),
    ]
    for name, row in result["formats"].items():
        cells = ""
        for figure in FIGURES:
            values = row.get(figure)
            text = (
                "-"
                if values is None
                else f"{values['median']:.3g} ({values['p10']:.3g}, {values['p90']:.3g})"
            )
            cells += f"{text:>26}"
        lines.append(f"{name:12}{row['valid']:>7}{row['bytes_per_s'] / 1e3:>8.1f}{cells}")
    return "\n".join(lines)

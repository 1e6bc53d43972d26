"""Losses of each haptic file format: every effect of VibViz written, checked, read back and compared.

Needs the WAV files of VibViz: ``--set data=FOLDER`` (8 to 48 kHz, one or two channels; two are averaged
for formats with one). Not a table of a publication: it helps designers to choose a format.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
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
from tactogram.rendering.files.loss import loss_between
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


@dataclass(frozen=True)
class RoundTrip:
    """One effect written to a format and read back; ``losses`` are per axis, ``refused`` the error if it failed."""

    losses: tuple[Mapping[str, Any], ...] = ()
    refused: str = ""
    seconds: float = 0.0
    bytes: int = 0
    valid: bool = False
    scaled: bool = False
    reduced: bool = False


def run(folder: Path, *, paper: bool, progress: ProgressCallback, data: str = "") -> dict[str, Any]:
    """Return the losses of each format: median, 10th and 90th percentile over effects.

    Parameters
    ----------
    folder, progress
        As in every experiment.
    paper : bool
        Every effect; else every fourth.
    data : str
        Folder with WAV files.
    """
    paths = sorted(Path(data).rglob("*.wav")) if data else []
    if not paths:
        raise ParameterError("data must be a folder with the WAV files of VibViz")
    paths = paths if paper else paths[::4]
    trips: dict[str, list[RoundTrip]] = {name: [] for name in (*SIGNAL_FORMATS, *haptic_formats())}
    rates, axes, seconds = set(), set(), 0.0
    for path in paths:
        signal = read_signal(path, unit="1")
        rates.add(signal.rate)
        axes.add(len(signal.axes))
        seconds += signal.seconds
        for name, made in trips.items():
            made.append(round_trip(name, signal, folder / "files" / path.stem))
    rows = {name: _row(made, seconds) for name, made in trips.items()}
    result = {
        "effects": len(paths),
        "seconds": round(seconds, 1),
        "rates_hz": sorted(rates),
        "channels": sorted(axes),
        "simulated": False,
        "formats": rows,
    }
    return result | {"text": _text(result)}


def round_trip(name: str, signal: Signal, place: Path) -> RoundTrip:
    """Write an effect to a file, check it, read it back and remove it."""
    start = time.perf_counter()
    try:
        trip = _round_trip(name, signal, place)
    except ParameterError as error:
        trip = RoundTrip(refused=str(error))
    return replace(trip, seconds=time.perf_counter() - start)


def _round_trip(name: str, signal: Signal, place: Path) -> RoundTrip:
    if name in SIGNAL_FORMATS:
        path = place.with_suffix(f".{name[:3]}")
        write_signal(path, signal, **SIGNAL_FORMATS[name])
        one, copy = signal, read_signal(path)
        trip = RoundTrip(valid=True)
    else:
        path = place.with_suffix(haptic_format(name).suffix)
        written = write_haptic(path, signal, format=name)
        trip = RoundTrip(
            valid=check_file(path, format=name)["valid"],
            scaled=written["full_scale"] != 1.0,
            reduced=written["reduced_by"] is not None,
        )
        one = signal if haptic_format(name).holds == "waveform" else to_one_axis(signal)[0]
        copy = read_haptic(path, format=name).signal
    size = path.stat().st_size
    path.unlink()
    axes = zip(one.axes, copy.axes, strict=True)
    by_axis = tuple(asdict(loss_between(one.select(name), copy.select(other))) for name, other in axes)
    return replace(trip, losses=by_axis, bytes=size)


def _row(trips: Sequence[RoundTrip], seconds: float) -> dict[str, Any]:
    figures: dict[str, Any] = {}
    for figure in FIGURES:
        values = [loss[figure] for trip in trips for loss in trip.losses if loss[figure] is not None]
        if values:
            low, middle, high = (float(q) for q in np.percentile(values, [10, 50, 90]))
            figures[figure] = {"median": middle, "p10": low, "p90": high, "of": len(values)}
    return {
        "effects": len(trips),
        "valid": sum(trip.valid for trip in trips),
        "refused": [trip.refused for trip in trips if trip.refused],
        "scaled": sum(trip.scaled for trip in trips),
        "made_one_axis": sum(trip.reduced for trip in trips),
        "bytes_per_s": sum(trip.bytes for trip in trips) / seconds,
        "seconds_per_s": sum(trip.seconds for trip in trips) / seconds,
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

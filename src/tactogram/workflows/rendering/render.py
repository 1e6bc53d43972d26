"""Signals rendered to displays as files, and the response of a display measured by a sweep."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.catalogue import display_family, open_display, shipped
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.response import write_response
from tactogram.rendering.drive.fit import Drive, fit
from tactogram.rendering.drive.friction_calibration import calibration_of
from tactogram.rendering.drive.sweep import exponential_sweep, identify
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal
from tactogram.signal.io import WRITABLE, read_metadata, read_signal, write_signal
from tactogram.signal.io.atomic import atomic_write
from tactogram.validation import validated
from tactogram.workflows.rendering.requests import RenderRequest, ResponseRequest, SweepRequest
from tactogram.workflows.request import takes


def list_displays() -> dict[str, Any]:
    """Return the facts by which to choose a display, for each that comes with the package."""
    return {
        name: {
            "title": display.title,
            "family": display.family,
            "rate": display.rate,
            "channels": list(display.channels),
            "unit": display.unit,
            "limit": display.limit,
            "band": display.band,
        }
        for name in shipped()
        for display in [open_display(name)]
    }


def show_display(name: str, *, changes: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return the settings of a display, by name or file, as JSON values."""
    display = open_display(name, changes=changes)
    return {**display.model_dump(mode="json"), "levels": levels_of(display)}


def levels_of(display: Display) -> list[str]:
    """Return the kinds of level that make sense for the display with some signal, tried on 0.2 s."""
    t = np.arange(200) / 1000
    probe = np.sin(2 * np.pi * 100 * t) + 1.5
    found = []
    for text in ("physical", "sensation", "gain=0.1", "peak=0.5"):
        for unit in ("m/s^2", "N", "1"):
            try:
                fit(Signal(probe.astype(np.float32), 1000, unit), display, level=parse_level(text))
            except (ParameterError, UnitError):
                continue
            found.append(text.partition("=")[0])
            break
    return found


@takes(RenderRequest)
def render(request: RenderRequest) -> dict[str, Any]:
    """Write the drive that renders a file on a display, and the report next to it.

    Keys of the result: ``file``, ``report_file``, ``report`` (see `Report`), ``text``, and ``figure``.

    Raises `ParameterError` if ``out`` is no signal file or the signal itself, or ``person`` comes without
    ``calibration``.
    """
    out, file, changes = Path(request.out), request.file, request.changes or {}
    if out.suffix.lower() not in WRITABLE:
        raise ParameterError(
            f"{out}: suffix must be one of {', '.join(WRITABLE)}, got {out.suffix or 'none'}"
        )
    if out.exists() and Path(file).exists() and out.samefile(file):
        raise ParameterError(f"{out}: is the signal itself, which the drive would replace; name another file")
    level = parse_level(request.level) if isinstance(request.level, str) else request.level
    display = open_display(request.display, changes=changes)
    if request.calibration is not None:
        display = calibrated_display(display, request.calibration, request.person, kept=changes)
    elif request.person is not None:
        raise ParameterError("`person` chooses among the people of `calibration`: give both")
    signal = read_signal(file, **request.reading)
    drive = fit(signal, display, level=level, axes=request.how, speed_mm_s=request.speed_mm_s)
    report = drive.report.as_json() | {"source_file": str(file)}
    simulated = read_metadata(file).get("simulated")
    if simulated is not None:
        report["simulated"] = simulated
    written = write_drive(out, drive, report=report)
    result = {"file": str(out), "report_file": str(written), "report": report, "text": drive.report.as_text()}
    if request.report_figure:
        result["figure"] = str(save_drive_figure(out.with_suffix(".report.png"), drive, display))
    return result


def calibrated_display(
    display: Display, calibration: Path | str, person: str | None, *, kept: Mapping[str, Any]
) -> Display:
    """Return an electrovibration display with the constants of a person.

    Raises `DataError` or `ParameterError` if there is no such calibration, the display is of another family, or
    ``kept`` (changes by dotted key) holds one of the constants: whose it then is could not be said.
    """
    family = display_family(display.family)
    if not family.calibrated:
        raise ParameterError(
            f"{display.name}: a calibration is for an electrostatic display, this one is {family.name}"
        )
    found = calibration_of(calibration, person)
    constants = found.settings()
    if both := [key for key in kept if key.removeprefix(f"{family.name}.") in constants]:
        raise ParameterError(f"{both[0]} comes from {calibration}: omit `changes` or `calibration`")
    settings = {**display.settings.model_dump(), **constants}
    checked = validated(family.settings, settings, where=f"{calibration}: {found.person}")
    return display.of(settings=checked)


def write_drive(out: Path, drive: Drive, *, report: Mapping[str, Any]) -> Path:
    """Write a drive with the display's name in its metadata, and the report next to it; return the report's file."""
    facts = {"display": drive.report.display, "level": str(drive.report.level["asked"])}
    if "simulated" in report:
        facts["simulated"] = report["simulated"]
    report_file = out.with_suffix(".report.json")
    with atomic_write(report_file) as part:
        part.write_text(json.dumps(report, indent=1) + "\n", encoding="utf-8")
        write_signal(out, drive.signal, metadata=facts)
    return report_file


def save_drive_figure(path: Path, drive: Drive, display: Display) -> Path:
    """Write the figure of a drive and return its path."""
    from tactogram.rendering.figures import drive_figure

    with atomic_write(path) as part:
        drive_figure(drive, display).savefig(part, format="png", dpi=150)
    return path


@takes(SweepRequest)
def write_sweep(request: SweepRequest) -> dict[str, Any]:
    """Write the sweep that measures a display's response, as a drive, and return its facts."""
    display = open_display(request.display, changes=request.changes)
    sweep = exponential_sweep(display, seconds=request.seconds, level=request.share, band=request.band)
    measured = request.band or display.band or (10.0, 0.45 * display.rate)
    facts = {"display": display.name, "sweep": True, "band": list(measured), "share_of_limit": request.share}
    write_signal(request.out, sweep, metadata=facts)
    return {"file": str(request.out), "seconds": sweep.seconds, "rate": sweep.rate, **facts}


@takes(ResponseRequest)
def write_identified(request: ResponseRequest) -> dict[str, Any]:
    """Write the response that leads from a played sweep to its recordings as CSV, and return a summary.

    Raises `ParameterError` if ``out`` is no CSV, the sweep does not state its band, or a recording has several axes and
    none is named.
    """
    out = Path(request.out)
    if out.suffix.lower() != ".csv":
        raise ParameterError(f"{out}: a response is written as .csv")
    sweep = read_signal(request.played)
    band = request.band or read_metadata(request.played).get("band")
    if band is None:
        raise ParameterError(f"{request.played} does not state the band it sweeps: give `band`")
    recordings = [read_signal(file, **request.reading) for file in request.recorded]
    if request.axis:
        recordings = [recording.select(request.axis) for recording in recordings]
    for file, recording in zip(request.recorded, recordings, strict=True):
        if len(recording.axes) > 1:
            raise ParameterError(f"{file} has axes {', '.join(recording.axes)}: choose one with `axis`")
    low, high = band
    found = identify(
        sweep.select(sweep.axes[0]), recordings[0], band=(low, high), repeats=tuple(recordings[1:])
    )
    write_response(out, found.frequency, found.response, unit=found.unit, coherence=found.coherence)
    trusted = found.frequency[found.coherence >= 0.9]
    return {
        "file": str(out),
        "unit": found.unit,
        "band": [low, high],
        "delay_ms": 1e3 * found.delay_s,
        "gain_largest": float(np.abs(found.response).max()),
        "at_hz": float(found.frequency[np.abs(found.response).argmax()]),
        "coherence_median": float(np.median(found.coherence)),
        "coherence_least": float(found.coherence.min()),
        "trusted_hz": [float(trusted.min()), float(trusted.max())] if len(trusted) else None,
        "takes": len(recordings),
    }

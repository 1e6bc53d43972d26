"""Signals rendered to displays as files, and the response of a display measured by a sweep."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.catalogue import open_display, shipped
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.family import display_family
from tactogram.rendering.displays.response import write_response
from tactogram.rendering.drive.fit import Drive, fit
from tactogram.rendering.drive.friction_calibration import calibration_of
from tactogram.rendering.drive.sweep import exponential_sweep, identify
from tactogram.rendering.level import Level, parse_level
from tactogram.signal import Signal
from tactogram.signal.io import WRITABLE, read_metadata, read_signal, write_signal
from tactogram.signal.io.atomic import atomic_write
from tactogram.validation import validated


def list_displays() -> dict[str, Any]:
    """Return the displays that come with the package, by name, with what there is to choose by."""
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
    """Return all that is known of a display, by name or file, as JSON values."""
    display = open_display(name, changes=changes)
    return {**display.model_dump(mode="json"), "levels": levels_of(display)}


def levels_of(display: Display) -> list[str]:
    """Return the kinds of level that have a meaning for the display and some signal, tried on one of 0.2 s."""
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


def render(
    file: Path | str,
    display: str,
    out: Path | str,
    *,
    level: Level | str,
    how: str | None = None,
    speed_mm_s: float | None = None,
    changes: Mapping[str, Any] | None = None,
    calibration: Path | str | None = None,
    person: str | None = None,
    report_figure: bool = False,
    **options: Any,
) -> dict[str, Any]:
    """Write the drive that renders a file on a display, and the report beside it.

    Parameters
    ----------
    file : Path
        Any file that `read_signal` reads; ``options`` are passed to it.
    display : str
        Name of a shipped one, or a TOML file.
    out : Path
        Of the drive, at the display's rate: ``.wav``, ``.csv``, ``.npz`` …; the report is written beside it with the
        suffix ``.report.json``, and its figure as ``.report.png`` where ``report_figure`` is asked for.
    level : Level or str
    how : str, optional
        How several axes become the display's: ``axes`` of `fit`.
    speed_mm_s : float, optional
        As in `fit`.
    changes : mapping, optional
        Values of the display to change, by dotted key.
    calibration : Path, optional
        Of an electrovibration display: what `tactogram.workflows.rendering.actuators.calibrate` wrote.
    person : str, optional
        Whose of it; may be left out where it holds one.

    Returns
    -------
    dict
        ``file``, ``report_file``, ``report`` (see `Report`), and ``figure``.

    Raises
    ------
    ParameterError
        If ``out`` is no signal file or the signal itself, or ``person`` has no calibration beside it.
    """
    out = Path(out)
    if out.suffix.lower() not in WRITABLE:
        raise ParameterError(
            f"{out}: suffix must be one of {', '.join(WRITABLE)}, got {out.suffix or 'none'}"
        )
    if out.exists() and Path(file).exists() and out.samefile(file):
        raise ParameterError(f"{out}: is the signal itself, which the drive would replace; name another file")
    asked = parse_level(level) if isinstance(level, str) else level
    opened = open_display(display, changes=changes)
    if calibration is not None:
        opened = calibrated_display(opened, calibration, person, kept=changes or {})
    elif person is not None:
        raise ParameterError("--person is whose calibration to take: give --calibration FILE, too")
    signal = read_signal(file, **options)
    drive = fit(signal, opened, level=asked, axes=how, speed_mm_s=speed_mm_s)
    report = drive.report.as_json() | {"source_file": str(file)}
    simulated = read_metadata(file).get("simulated")
    if simulated is not None:
        report["simulated"] = simulated
    written = write_drive(out, drive, report=report)
    result = {"file": str(out), "report_file": str(written), "report": report, "text": drive.report.as_text()}
    if report_figure:
        result["figure"] = str(save_drive_figure(out.with_suffix(".report.png"), drive, opened))
    return result


def calibrated_display(
    display: Display, calibration: Path | str, person: str | None, *, kept: Mapping[str, Any]
) -> Display:
    """Return an electrovibration display with the constants of a person.

    Raises
    ------
    DataError, ParameterError
        If there is no such calibration, the display is of another family, or ``kept`` (changes by dotted key) holds one
        of the constants: whose it then is could not be said.
    """
    family = display_family(display.family)
    if not family.calibrated:
        raise ParameterError(
            f"{display.name}: a calibration is for an electrostatic display, this one is {family.name}"
        )
    found = calibration_of(calibration, person)
    constants = found.settings()
    if both := [key for key in kept if key.removeprefix(f"{family.name}.") in constants]:
        raise ParameterError(f"{both[0]} comes from {calibration}: leave out --set or --calibration")
    settings = {**display.settings.model_dump(), **constants}
    checked = validated(family.settings, settings, where=f"{calibration}: {found.person}")
    return display.of(settings=checked)


def write_drive(out: Path, drive: Drive, *, report: Mapping[str, Any]) -> Path:
    """Write a drive with the display's name in its metadata, and the report beside it; return the report's file."""
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
    from tactogram.rendering.drive.figures import drive_figure

    with atomic_write(path) as part:
        drive_figure(drive, display).savefig(part, format="png", dpi=150)
    return path


def write_sweep(
    display: str,
    out: Path | str,
    *,
    seconds: float = 10.0,
    share: float = 0.25,
    band: tuple[float, float] | None = None,
    changes: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Write the sweep that a display's response is measured with, as a drive, and return what it is."""
    opened = open_display(display, changes=changes)
    sweep = exponential_sweep(opened, seconds=seconds, level=share, band=band)
    measured = band or opened.band or (10.0, 0.45 * opened.rate)
    facts = {"display": opened.name, "sweep": True, "band": list(measured), "share_of_limit": share}
    write_signal(out, sweep, metadata=facts)
    return {"file": str(out), "seconds": sweep.seconds, "rate": sweep.rate, **facts}


def write_identified(
    played: Path | str,
    recorded: list[str],
    out: Path | str,
    *,
    band: tuple[float, float] | None = None,
    axis: str | None = None,
    **options: Any,
) -> dict[str, Any]:
    """Write the response that leads from a played sweep to its recordings as CSV, and return what was found.

    Parameters
    ----------
    played : Path
        As `write_sweep` wrote it.
    recorded : list of Path
        One or more recordings of it; ``options`` are passed to `read_signal`.
    out : Path
        A CSV of frequency, gain, phase and coherence.
    band : tuple of float, optional
        In which it is read, Hz; by default that of the sweep.
    axis : str, optional
        Of the recordings, where they have several.

    Raises
    ------
    ParameterError
        If ``out`` is no CSV, the sweep does not say its band, or a recording has several axes and none is named.
    """
    if Path(out).suffix.lower() != ".csv":
        raise ParameterError(f"{out}: a response is written as .csv")
    sweep = read_signal(played)
    asked = band or read_metadata(played).get("band")
    if asked is None:
        raise ParameterError(f"{played} does not say which band it sweeps: give --band LO HI")
    takes = [read_signal(file, **options) for file in recorded]
    takes = [take.select(axis) if axis else take for take in takes]
    for file, take in zip(recorded, takes, strict=True):
        if len(take.axes) > 1:
            raise ParameterError(f"{file} has axes {', '.join(take.axes)}: give --axis NAME")
    low, high = asked
    found = identify(sweep.select(sweep.axes[0]), takes[0], band=(low, high), repeats=tuple(takes[1:]))
    write_response(Path(out), found.frequency, found.response, unit=found.unit, coherence=found.coherence)
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
        "takes": len(takes),
    }

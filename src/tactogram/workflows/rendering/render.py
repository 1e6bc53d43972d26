"""Signals rendered to displays as files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.errors import ParameterError, Remedy, UnitError
from tactogram.parameters import Settings, checked, with_further
from tactogram.workflows.data.convert import reading_parameters

if TYPE_CHECKING:
    from tactogram.rendering.displays.display import Display
    from tactogram.rendering.drive.fit import Drive
    from tactogram.rendering.level import Level


def list_displays() -> dict[str, Any]:
    """Return the facts by which to choose a display, for each that comes with the package."""
    from tactogram.rendering.displays.catalogue import open_display, shipped

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


@checked
def describe_displays(name: str | None = None, *, changes: Settings | None = None) -> dict[str, Any]:
    """List the displays, or show one.

    Parameters
    ----------
    name : str, optional
        Display to show, by name or file (default: list all).
    changes : dict, optional
        Change a value of the display, e.g. limit=2.

    Returns
    -------
    dict
        Of one its settings as JSON values, and the ``levels`` that make sense for it; else `list_displays`.

    Raises
    ------
    ParameterError, DataError
        If there is no such display, or a value is wrong.
    """
    from tactogram.rendering.displays.catalogue import open_display

    if name is None:
        return list_displays()
    display = open_display(name, changes=changes)
    return {**display.model_dump(mode="json"), "levels": levels_of(display)}


def levels_of(display: Display) -> list[str]:
    """Return the kinds of level that make sense for the display with some signal, tried on 0.2 s."""
    import numpy as np

    from tactogram.rendering.drive.fit import fit
    from tactogram.rendering.level import parse_level
    from tactogram.signal import Signal

    t = np.arange(200) / 1000
    probe = np.sin(2 * np.pi * 100 * t) + 1.5
    levels = []
    for text in ("physical", "sensation", "gain=0.1", "peak=0.5"):
        for unit in ("m/s^2", "N", "1"):
            try:
                fit(Signal(probe.astype(np.float32), 1000, unit), display, level=parse_level(text))
            except (ParameterError, UnitError):
                continue
            levels.append(text.partition("=")[0])
            break
    return levels


@checked
@with_further(reading_parameters)
def render(
    file: Path | str,
    out: Path | str,
    *,
    display: str,
    level: str | Level,
    how: str | None = None,
    speed_mm_s: float | None = None,
    calibration: Path | str | None = None,
    person: str | None = None,
    figure: bool = False,
    changes: Settings | None = None,
    **reading: Any,
) -> dict[str, Any]:
    """Render a signal to the drive of a display, with a report of what changed.

    ``reading`` are the options of `tactogram.convert` on how a file is read.

    Parameters
    ----------
    file : Path or str
        The signal.
    out : Path or str
        The drive: .wav, .csv, .npz …; its report, with the suffix .report.json, is written next to it.
    display : str
        One of `displays`, or a TOML file.
    level : str or Level
        physical, sensation, sensation=DB, gain=FACTOR or peak=SHARE.
    how : str, optional
        How axes become one: dft321, mean, channels or the name of an axis.
    speed_mm_s : float, optional
        Finger speed, mm/s, for a signal over displacement.
    calibration : Path or str, optional
        Calibration of an electrovibration display, as `calibrate` wrote it (.toml).
    person : str, optional
        Person, where the calibration holds several.
    figure : bool
        Also draw the report, with the suffix .report.png.
    changes : dict, optional
        Change a value of the display, e.g. limit=2.

    Returns
    -------
    dict
        ``file``, ``report_file``, ``report`` (see `Report`), ``text``, and ``figure``.

    Raises
    ------
    ParameterError
        If ``out`` is no signal file or the signal itself, or ``person`` comes without ``calibration``.
    """
    from tactogram.rendering.displays.catalogue import open_display
    from tactogram.rendering.drive.fit import fit
    from tactogram.rendering.level import parse_level
    from tactogram.signal.io import WRITABLE, read_metadata, read_signal

    out = Path(out)
    if out.suffix.lower() not in WRITABLE:
        raise ParameterError(
            f"{out}: suffix must be one of {', '.join(WRITABLE)}, got {out.suffix or 'none'}"
        )
    if out.exists() and Path(file).exists() and out.samefile(file):
        raise ParameterError(f"{out}: is the signal itself, which the drive would replace; name another file")
    known = open_display(display, changes=changes)
    if calibration is not None:
        known = calibrated_display(known, calibration, person, kept=changes or {})
    elif person is not None:
        remedy = Remedy("give it with", "calibration")
        raise ParameterError("chooses among the people of a calibration", parameter="person", remedy=remedy)
    signal = read_signal(file, **reading)
    drive_level = parse_level(level) if isinstance(level, str) else level
    drive = fit(signal, known, level=drive_level, axes=how, speed_mm_s=speed_mm_s)
    report = drive.report.as_json() | {"source_file": str(file)}
    simulated = read_metadata(file).get("simulated")
    if simulated is not None:
        report["simulated"] = simulated
    written = write_drive(out, drive, report=report)
    result = {"file": str(out), "report_file": str(written), "report": report, "text": drive.report.as_text()}
    if figure:
        result["figure"] = str(save_drive_figure(out.with_suffix(".report.png"), drive, known))
    return result


def calibrated_display(
    display: Display, calibration: Path | str, person: str | None, *, kept: Mapping[str, Any]
) -> Display:
    """Return an electrovibration display with the constants of a person.

    Raises `DataError` or `ParameterError` if there is no such calibration, the display is of another family, or
    ``kept`` (changes by dotted key) holds one of the constants: whose it then is could not be said.
    """
    from tactogram.rendering.displays.catalogue import display_family
    from tactogram.rendering.drive.friction_calibration import calibration_of
    from tactogram.validation import validated

    family = display_family(display.family)
    if not family.calibrated:
        raise ParameterError(
            f"{display.name}: a calibration is for an electrostatic display, this one is {family.name}"
        )
    calibrated = calibration_of(calibration, person)
    constants = calibrated.settings()
    if both := [key for key in kept if key.removeprefix(f"{family.name}.") in constants]:
        remedies = Remedy("omit", "changes"), Remedy("", "calibration")
        raise ParameterError(f"{both[0]} comes from {calibration}", remedy=remedies)
    settings = {**display.settings.model_dump(), **constants}
    checked = validated(family.settings, settings, where=f"{calibration}: {calibrated.person}")
    return display.of(settings=checked)


def write_drive(out: Path, drive: Drive, *, report: Mapping[str, Any]) -> Path:
    """Write a drive with the display's name in its metadata, and the report next to it; return the report's file."""
    from tactogram.signal.io import write_signal
    from tactogram.signal.io.atomic import atomic_write

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
    from tactogram.signal.io.atomic import atomic_write

    with atomic_write(path) as part:
        drive_figure(drive, display).savefig(part, format="png", dpi=150)
    return path

"""CdpLab friction set: copper, fabric, leather, paper, stone and wood stroked, and a photograph of each.

Read from ``multidata/NAME.xlsx`` (columns ``speed``, ``force``, ``accel``, ``friction``; about 19,000 rows) and
``image/NAME.png`` (1200 x 1200), as the set is published, also in a folder below, or from ``xlsx/`` and ``images/``.
Checked on real files.

Notes on the data
- **Sampling rate and units are not stated.** 1 kHz, mm/s, N and m/s^2 are guesses from the ranges (speeds of 130-320,
  forces of 0.6-4.3, friction of 0.01-1.0); the first two are options of the import. ``history`` repeats them.
- There is one recording per material, so differences between recordings cannot be separated from differences between
  materials, and only intervals of one recording can be held out.
- The speed never falls below 130, so that friction over displacement is the plain integral of the speed. How the
  surface moved is not stated; at these speeds 19 s are 3-5 m, so the same ground was passed many times.
- Photographs have no scale and are not registered: which place was felt when is unknown.
- Acceleration and friction may not be aligned.
"""

from __future__ import annotations

from pathlib import Path

from tactogram.datasets import ImportItem, Recording, check_positive, number_columns
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal, over_displacement, parse_unit

TITLE = "CdpLab friction: copper, fabric, leather, paper, stone and wood"
LICENCE = "not stated"
DESCRIPTION = (
    "multidata/NAME.xlsx and image/NAME.png: friction over displacement, and friction_time, speed, force and "
    "acceleration over time. Options: rate (Hz, guessed 1000), speed_unit (guessed mm/s), per_mm (samples of friction "
    "over displacement). Checked on real files."
)

COLUMNS = ("speed", "force", "accel", "friction")
FOLDERS = {"multidata": "image", "xlsx": "images"}
"""Folders of the worksheets, each with that of the photographs."""
RATE = 1000.0
SPEED_UNIT = "mm/s"
PER_MM = 6.0
"""Samples per mm, the same for all materials, and no fewer than any was recorded with at its mean speed."""


def find(
    folder: Path, *, rate: float = RATE, speed_unit: str = SPEED_UNIT, per_mm: float = PER_MM
) -> list[ImportItem]:
    """Return an item per worksheet."""
    check_positive(rate=rate, per_mm=per_mm)
    if parse_unit(str(speed_unit))[0] != "m/s":
        raise ParameterError.must("speed_unit", "be a unit of speed, such as mm/s", speed_unit)
    paths = sorted(path for path in folder.rglob("*.xlsx") if path.parent.name in FOLDERS)
    if not paths:
        raise DataError(folder, "must hold multidata/NAME.xlsx, or xlsx/NAME.xlsx, found neither")
    info = {"rate": float(rate), "speed_unit": str(speed_unit), "per_mm": float(per_mm)}
    images = {path: path.parents[1] / FOLDERS[path.parent.name] / f"{path.stem}.png" for path in paths}
    return [
        ImportItem(path.relative_to(folder).as_posix(), (path,), info, image if image.is_file() else None)
        for path, image in images.items()
    ]


def read(item: ImportItem) -> list[Recording]:
    """Return the one recording of a material."""
    [path] = item.paths
    rate, speed_unit = item.info["rate"], item.info["speed_unit"]
    speed, force, acceleration, friction = number_columns(path, COLUMNS)
    over_time = Signal(friction, rate, "1", ("along",))
    velocity = Signal(speed * parse_unit(speed_unit)[1], rate, "m/s", ("along",))
    return [
        Recording(
            streams={
                "friction": over_displacement(over_time, velocity, rate=item.info["per_mm"]),
                "friction_time": over_time,
                "speed": velocity,
                "force": Signal(force, rate, "N"),
                "acceleration": Signal(acceleration, rate, "m/s^2", ("along",)),
            },
            material=path.stem,
            speed_mm_s=round(1e3 * float(velocity.samples.mean()), 1),
            force_n=round(float(force.mean()), 3),
            labels={"recording": "1"},
            source=item.name,
            history=(
                f"rate of {rate:g} Hz taken, none is stated",
                f"speed taken in {speed_unit}, force in N, acceleration in m/s^2: no unit is stated",
                f"friction over displacement by integrating the speed, {item.info['per_mm']:g} samples per mm",
            ),
        )
    ]

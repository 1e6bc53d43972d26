"""Displays from TOML files, by name or path, and the families that drive them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from tactogram.errors import ParameterError
from tactogram.plugins import PluginGroup
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.response import read_response
from tactogram.rendering.level import Level
from tactogram.signal.signal import Signal
from tactogram.text_files import path_of, read_toml
from tactogram.validation import validated, with_changes

FOLDER = Path(__file__).parent


def shipped() -> dict[str, Path]:
    """Return the files of the displays that come with the package, by name."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.toml"))}


def open_display(name: str | Path, *, changes: Mapping[str, Any] | None = None) -> Display:
    """Return a display by the name of a shipped one, or by the path of its TOML file.

    ``changes`` replace the file's values by dotted key, such as ``{"limit": 2.0, "linear.cap_db": 10}``. Raises
    `DataError` if there is no such file, or it is not TOML; `ParameterError` if a name is unknown, or a key or value
    is not valid for a display or its family.

    >>> tactogram.open_display("audio", changes={"limit": 0.5}).limit
    0.5
    """
    known = shipped()
    path = known.get(str(name)) or path_of(name, "name")
    if path.suffix != ".toml":
        raise ParameterError.must(
            "display", f"be one of {', '.join(known)}, or a TOML file", str(name), choices=known
        )
    return display_of(with_changes(read_toml(path), changes), where=str(path), folder=path.parent)


def display_of(values: Mapping[str, Any], *, where: str = "display", folder: Path = Path()) -> Display:
    """Return the display for a file's ``values``: the keys of `Display`, and the family's settings under its name.

    ``where`` is a prefix of errors, ``folder`` that of the response's file. Raises `DataError` if the response's file
    cannot be read; `ParameterError` if a key or value is wrong.
    """
    values = dict(values)
    family = values.get("family")
    if not isinstance(family, str) or family not in FAMILIES:
        raise ParameterError(f"{where}: family must be one of {', '.join(FAMILIES.names())}, got {family!r}")
    if "settings" in values:
        raise ParameterError(f"{where}: the settings of a {family} display belong in a table [{family}]")
    own = values.pop(family, {})
    if not isinstance(own, Mapping):
        raise ParameterError(f"{where}: [{family}] must be a table, got {own!r}")
    settings = validated(display_family(family).settings, own, where=f"{where}: {family}")
    response = values.get("response")
    if isinstance(response, Mapping) and isinstance(response.get("file"), str):
        points = read_response(folder / response["file"])
        rest = {key: value for key, value in response.items() if key != "file"}
        values["response"] = {**rest, "points": points}
    return validated(Display, {**values, "settings": settings}, where=where)


class DriveFunction(Protocol):
    """Function from a signal to the drive of a display."""

    def __call__(
        self, signal: Signal, settings: Any, *, display: Display, level: Level
    ) -> tuple[Signal, dict[str, Any]]:
        """Return the drive and JSON facts.

        ``signal`` is over time, in its own unit and at its own rate: one axis, or all of them
        (`rendering.drive.axes`). ``settings`` are the family's. The drive is at ``display.rate``, in ``display.unit``,
        with ``display.channels`` as axes; fades, DC and the limits are checked afterwards (`rendering.drive.safety`).
        Of the facts, ``scaled``, ``clipped`` and ``unreachable`` are lists of sentences, and ``faded`` is true if the
        drive already begins and ends at rest. Raises `UnitError` or `ParameterError` if the level does not apply to
        the signal or the display, or the settings do not fit.
        """
        ...


class MotionSamples(NamedTuple):
    """The finger at the samples of a block: position and length of the path so far in mm.

    ``contact`` and ``movement`` are gains from 0 (lifted, at rest) to 1 (touching, sliding).
    """

    x_mm: NDArray[np.float64]
    y_mm: NDArray[np.float64]
    path_mm: NDArray[np.float64]
    speed_mm_s: NDArray[np.float64]
    force_n: NDArray[np.float64]
    contact: NDArray[np.float32]
    movement: NDArray[np.float32]


class MotionBlock:
    """`MotionSamples` with room for ``most``, of which the first ``count`` are valid."""

    def __init__(self, most: int) -> None:
        self.count = 0
        self.samples = MotionSamples(*np.zeros((5, most)), *np.zeros((2, most), np.float32))
        self.x_mm, self.y_mm, self.path_mm, self.speed_mm_s, self.force_n, *gains = self.samples
        self.contact, self.movement = gains


class StreamDrive(Protocol):
    """Drive of a display, block by block."""

    runs_on: bool
    """Whether `process` is called without motion, too: a carrier held at an instant would be a direct voltage."""

    def process(self, block: NDArray[np.float32], motion: MotionBlock | None) -> NDArray[np.float64]:
        """Return the drive of a block, float64, shape (channel, time).

        ``block`` is float32, shape (axis, time); ``motion`` the finger over it, None while its position is unknown.
        """
        ...

    def facts(self) -> dict[str, Any]:
        """Return JSON facts; ``equaliser`` is among them if it has one."""
        ...


@dataclass(frozen=True)
class DisplayFamily:
    """A family of displays.

    Parameters
    ----------
    name : str
        That of the module's file, and of the table of settings in a display's file.
    settings : type
        Frozen pydantic model that refuses unknown keys.
    renders : {"vibration", "friction"}
        Friction is a coefficient, one axis of unit 1.
    stream_signal : callable, optional
        Returns a `StreamDrive` for the display, the unit of the signal and the facts of ``drive`` on a rehearsal.
    stream_surface : callable, optional
        Returns one for the display, the whole surface (over displacement), what it is laid out along (path, x or y)
        and the level. A family without either cannot be streamed to.
    response_known : callable
        Whether the display's response is known.
    measured_by : str
        How to measure the response, as an imperative sentence.
    swept : bool
        Whether the drive has the shape of the output, so that a sweep measures the response.
    calibrated : bool
        Whether `rendering.drive.friction_calibration` fits its settings to a person.
    sampled : bool
        False for a drive of strengths, a few hundred per second, which no sound card plays.
    hazard : str
        Warning before the drive is played; ``{peak}`` is its largest value.
    close_up_s : float
        Length of the close-up in the figure of a drive, s.
    """

    name: str
    settings: type[BaseModel]
    drive: DriveFunction
    renders: Literal["vibration", "friction"] = "vibration"
    stream_signal: Callable[[Display, str, Mapping[str, Any]], StreamDrive] | None = None
    stream_surface: Callable[[Display, Signal, str, Level], StreamDrive] | None = None
    response_known: Callable[[Display], bool] = lambda display: display.response is not None
    measured_by: str = ""
    swept: bool = False
    calibrated: bool = False
    sampled: bool = True
    hazard: str = ""
    close_up_s: float = 0.1


FAMILIES = PluginGroup(
    "display family",
    "tactogram.rendering.families",
    "tactogram.display_families",
    "TACTOGRAM_DISPLAY_FAMILIES",
)
"""Modules with a ``FAMILY``, a `DisplayFamily`."""


def display_family(name: str) -> DisplayFamily:
    """Return a family by name; `ParameterError` if there is none, or its module does not define one."""
    return FAMILIES.definition(name, "FAMILY", DisplayFamily)

"""Tablet with strings of Saga et al.: a vibration as a force on the finger, and string tensions that exert it.

The publication presents three-axis accelerations on a tablet whose strings pull the finger pad (Saga et al., Sec. IV),
without stating how three axes become its drive. Here the display's ``axes`` decides:

- ``dft321`` (or ``mean``, or an axis's name): one vibration, rendered along ``along``, the direction of the stroke;
- ``channels``: x and y unchanged, in the plane of the screen. Strings in that plane cannot render z.

The force of an acceleration is not stated either: ``moved_mass_kg`` sets it, or the level's gain.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator
from scipy.optimize import linprog

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.family import DisplayFamily
from tactogram.rendering.displays.response import edges
from tactogram.rendering.drive.band_table import out_of_band_db
from tactogram.rendering.drive.report import amount
from tactogram.rendering.level import Level
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal

CORNERS = ("upper-left", "upper-right", "lower-left", "lower-right")
"""Channels of a display with strings, by the position of their motors."""


class Settings(BaseModel):
    """Geometry and mechanics of the strings."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    size_mm: tuple[float, float] = (200.0, 150.0)
    """Width and height of the rectangle that the motors span, mm."""
    finger_mm: tuple[float, float] = (100.0, 75.0)
    """Position of the finger from the lower left, mm, which determines the strings' directions."""
    along: tuple[float, float] = (1.0, 0.0)
    """Direction in which a single axis is rendered: that of the stroke."""
    pretension_n: float = Field(default=0.3, gt=0)
    """Least tension of a string, N: a slack one jerks."""
    moved_mass_kg: float | None = Field(default=None, gt=0)
    """Force per acceleration, kg; None is unknown, and a level is a gain in N per m/s^2, or a peak."""
    over: Literal["scale", "refuse"] = "scale"
    """If a tension would exceed the limit: reduce everything, or refuse."""

    @model_validator(mode="after")
    def _finger_is_inside(self) -> Settings:
        inside = all(0.02 * s < f < 0.98 * s for s, f in zip(self.size_mm, self.finger_mm, strict=True))
        if not inside:
            raise ValueError(
                f"finger_mm must lie inside of {self.size_mm}, 2 % off its edges, got {self.finger_mm}"
            )
        if not np.hypot(*self.along) > 0:
            raise ValueError("along must be a direction, not 0 0")
        return self


def drive(
    signal: Signal, settings: Settings, *, display: Display, level: Level
) -> tuple[Signal, dict[str, Any]]:
    """Return the tensions of four strings, N, whose pull on the finger equals the wanted force at every moment.

    Raises `UnitError` if a physical level lacks a force or a known mass, or the level is a sensation level;
    `ParameterError` if the channels are not the four corners, or a tension exceeds the limit and ``over`` is
    ``refuse``.
    """
    if set(display.channels) != set(CORNERS):
        raise ParameterError(
            f"{display.name}: channels must be {', '.join(CORNERS)}, got {', '.join(display.channels)}"
        )
    per_unit, words = _newtons(signal, settings, display, level)
    scaled, unreachable = [words], []
    band = (display.band or (0.0, np.inf))[0], min((display.band or (0.0, np.inf))[1], display.rate / 2)
    lost = out_of_band_db(signal, band)
    if lost > 0.1:
        unreachable.append(
            f"frequencies outside {band[0]:g} to {band[1]:g} Hz: {lost:.1f} dB of the signal's power"
        )
    plane, left_out = _in_plane(signal, settings)
    if left_out is not None:
        unreachable.append(left_out)
    force = _banded(resample(plane, display.rate), band) * per_unit
    pull = directions(settings)  # 2, string
    share = np.linalg.pinv(pull) @ force  # string, time
    slack = slackless(pull)  # string
    basis = settings.pretension_n / slack.min()
    needed = float(np.max(-share / slack[:, None]))
    # Tension = share k + slack (basis + k needed) stays above the pretension for every k >= 0.
    room = (display.limit - basis * slack) / np.maximum((share + slack[:, None] * needed).max(axis=1), 1e-12)
    if not room.min() > 0:
        raise ParameterError(
            f"pretension_n {settings.pretension_n:g} leaves no room below the limit of {display.limit:g} N here"
        )
    factor = 1.0
    if level.kind == "peak" and force.any():
        factor = float(room.min()) * float(level.value or 1.0)
        scaled.append(
            f"times {factor:.4g}: {level.value:g} of the largest force that keeps the strings tight within "
            f"{amount(display.limit, 'N')}; the signal's own level is lost"
        )
    elif room.min() < 1:
        if settings.over == "refuse":
            raise ParameterError(
                f"a string would need more than the limit of {display.limit:g} N; lower the level to "
                f"{room.min():.2g} of it"
            )
        factor = float(room.min())
        scaled.append(
            f"times {factor:.4g} ({20 * np.log10(factor):.1f} dB): a string would be over {amount(display.limit, 'N')}"
        )
    tension = factor * share + slack[:, None] * (basis + factor * needed)
    order = [CORNERS.index(name) for name in display.channels]
    facts: dict[str, Any] = {
        "newton_per_unit": per_unit * factor,
        "limiting": factor if level.kind != "peak" else 1.0,
        "pretension_n": float((slack * (basis + factor * needed)).min()),
        "force_peak_n": float(np.hypot(*force).max() * factor),
        "strings": {name: pull[:, CORNERS.index(name)].tolist() for name in display.channels},
        "net_force_error_n": float(np.abs(pull @ tension - factor * force).max()),
        "out_of_band_db": lost,
        "scaled": scaled,
        "clipped": [],
        "unreachable": unreachable,
    }
    return Signal(tension[order].astype(np.float32), display.rate, display.unit, display.channels), facts


def directions(settings: Settings) -> NDArray[np.float64]:
    """Return the unit vectors from the finger to the motors, float64, shape (x and y, string), by `CORNERS`."""
    width, height = settings.size_mm
    corners = np.array([[0, height], [width, height], [0, 0], [width, 0]], np.float64).T
    away = corners - np.array(settings.finger_mm, np.float64)[:, None]
    unit: NDArray[np.float64] = away / np.linalg.norm(away, axis=0)
    return unit


def slackless(pull: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return tensions of sum 1 without a net force, the least as large as possible; float64, shape (string,)."""
    count = pull.shape[1]
    balance = np.vstack([np.column_stack([pull, np.zeros(2)]), [[1.0] * count + [0.0]]])
    found = linprog(
        [0.0] * count + [-1.0],
        A_ub=np.column_stack([-np.eye(count), np.ones(count)]),
        b_ub=np.zeros(count),
        A_eq=balance,
        b_eq=[0.0, 0.0, 1.0],
    )
    tensions: NDArray[np.float64] = np.asarray(found.x[:count], np.float64)
    return tensions


def _newtons(signal: Signal, settings: Settings, display: Display, level: Level) -> tuple[float, str]:
    """Return the force per unit of the signal before limits, N, and a sentence."""
    match level.kind:
        case "peak":
            return 1.0, "a force in the shape of the signal"
        case "gain":
            return float(
                level.value or 1.0
            ), f"{level.value:g} N per {signal.unit} of the signal, as requested"
        case "physical" if signal.unit == "N":
            return 1.0, "nothing: the force is the signal"
        case "physical" if signal.unit == "m/s^2" and settings.moved_mass_kg is not None:
            mass = settings.moved_mass_kg
            return mass, f"{mass:g} N per m/s^2: the display's moved mass is {mass:g} kg"
    known = "does not state" if settings.moved_mass_kg is None else "states"
    raise UnitError(
        f"level {level.kind} needs a force in N, or an acceleration and the display's moved_mass_kg, which "
        f"{display.name} {known}; the signal is in {signal.unit}: use gain=FACTOR (N per unit) or peak=SHARE"
    )


def _in_plane(signal: Signal, settings: Settings) -> tuple[Signal, str | None]:
    """Return the two axes in the plane of the screen, and a sentence on the omitted ones."""
    if len(signal.axes) == 1:
        along = np.array(settings.along) / np.hypot(*settings.along)
        return signal.with_samples(along[:, None] * signal.samples, axes=("x", "y")), None
    names = ("x", "y") if {"x", "y"} <= set(signal.axes) else signal.axes[:2]
    rest = [name for name in signal.axes if name not in names]
    plane = signal.select(*names)
    if not rest:
        return plane, None
    power = np.square(signal.samples - signal.samples.mean(axis=1, keepdims=True), dtype=np.float64)
    in_plane = float(power[[signal.axes.index(name) for name in names]].sum())
    share = 1 - in_plane / float(power.sum()) if power.any() else 0.0
    return (
        plane,
        f"axis {', '.join(rest)}: strings pull in the plane; it has {100 * share:.3g} % of the signal's power",
    )


def _banded(plane: Signal, band: tuple[float, float]) -> NDArray[np.float64]:
    """Return the samples within ``band``, with the edges of `response.edges`; the ends are mirrored."""
    x = plane.samples.astype(np.float64)
    x = np.concatenate([x, x[:, ::-1]], axis=1)
    frequency = np.fft.rfftfreq(x.shape[1], 1 / plane.rate).astype(np.float64)
    filtered = np.fft.irfft(np.fft.rfft(x, axis=1) * edges(frequency, band), n=x.shape[1], axis=1)
    return np.asarray(filtered[:, : len(plane)])


FAMILY = DisplayFamily(
    name="tablet",
    settings=Settings,
    drive=drive,
    hazard="Strings pull at a finger: start with a small share of the limit.",
)

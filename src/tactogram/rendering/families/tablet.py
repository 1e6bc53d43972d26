"""Tablet with strings of Saga et al.: a vibration as a force on the finger, and string tensions that exert it.

The publication presents three-axis accelerations on a tablet whose strings pull the finger pad (Saga et al., Sec. IV),
without stating how three axes become its drive. Here the display's ``axes`` decides:

- ``dft321`` (or ``mean``, or an axis's name): one vibration, rendered along ``along``, the direction of the stroke;
- ``channels``: x and y unchanged, in the plane of the screen. Strings in that plane cannot render z.

The force of an acceleration is not stated either: ``moved_mass_kg`` sets it, or the level's gain.

In a file the finger rests at ``finger_mm``. In a stream the strings' directions follow the finger sample by sample, so
that the net force is the wanted one wherever it is.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.catalogue import DisplayFamily, MotionBlock
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.response import edges
from tactogram.rendering.drive.equaliser import Equaliser, equaliser
from tactogram.rendering.drive.report import amount, out_of_band_db
from tactogram.rendering.level import Level
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal
from tactogram.validation import FrozenModel

CORNERS = ("upper-left", "upper-right", "lower-left", "lower-right")
"""Channels of a display with strings, by the position of their motors."""
EDGE = 0.02
"""Share of the rectangle's sides within which strings cannot be told apart: no finger is placed there."""
TIGHTEST = 0.5
"""Share of the limit that pretension may use in a stream: near the edges two strings are long and the others tight."""


class Settings(FrozenModel):
    """Geometry and mechanics of the strings."""

    size_mm: tuple[float, float] = (200.0, 150.0)
    """Width and height of the rectangle that the motors span, mm."""
    finger_mm: tuple[float, float] = (100.0, 75.0)
    """Position of the finger from the lower left, mm, which determines the strings' directions; in a stream the place
    of x = y = 0."""
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
        inside = all(EDGE * s < f < (1 - EDGE) * s for s, f in zip(self.size_mm, self.finger_mm, strict=True))
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
    band = _band(display)
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
    slack = slackless(settings)  # string
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


def directions(settings: Settings, finger_mm: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
    """Return the unit vectors from the finger to the motors, float64, shape (x and y, string), by `CORNERS`.

    ``finger_mm``, float64, shape (x and y, …), are other positions than the settings'; the shape is then (2, 4, …).
    """
    away = _strings(settings, finger_mm)
    unit: NDArray[np.float64] = away / np.linalg.norm(away, axis=0)
    return unit


def slackless(settings: Settings, finger_mm: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
    """Return tensions of sum 1 without a net force, the least as large as possible; float64, shape (string, …).

    Forces in proportion to the strings' vectors balance with the weights of a bilinear interpolation, and still do with
    any share of (1, -1, -1, 1) added, since the motors are the corners of a rectangle. Of these tensions the least is
    largest where two of them are equal.
    """
    size = np.array(settings.size_mm, np.float64)
    away = _strings(settings, finger_mm)
    length = np.linalg.norm(away, axis=0)  # string, …
    u, v = -away[:, 2] / size.reshape(2, *[1] * (away.ndim - 2))
    balance = np.stack([(1 - u) * v, u * v, (1 - u) * (1 - v), u * (1 - v)]) * length
    balance /= balance.sum(axis=0)
    other = np.array([1.0, -1.0, -1.0, 1.0]).reshape(4, *[1] * (away.ndim - 2)) * length
    best, least = balance, balance.min(axis=0)
    for i, j in itertools.combinations(range(4), 2):
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (balance[j] - balance[i]) / (other[i] - other[j])
            tensions = (balance + share * other) / (1 + share * other.sum(axis=0))
        # NaN, where the two never meet, is not larger.
        better = tensions.min(axis=0) > least
        best, least = np.where(better, tensions, best), np.where(better, tensions.min(axis=0), least)
    return np.asarray(best)


class TabletStream:
    """Tensions of the strings, block by block, for a finger that moves."""

    runs_on = False

    def __init__(self, display: Display, unit: str, facts: Mapping[str, Any]) -> None:
        self._settings, self._limit = display.settings_as(Settings), display.limit
        self._order = [CORNERS.index(name) for name in display.channels]
        self._newton_per_unit = float(facts["newton_per_unit"])
        self._edges = Equaliser(equaliser(display.rate, _band(display), np.ones_like))
        self.limited = 0

    def process(self, block: NDArray[np.float32], motion: MotionBlock | None = None) -> NDArray[np.float64]:
        """Return the tensions, N, float64, shape (string, time); without a position the finger is at ``finger_mm``."""
        s, count = self._settings, block.shape[1]
        along = np.array(s.along) / np.hypot(*s.along)
        force = along[:, None] * self._edges.process(block[:1] * self._newton_per_unit)
        size, finger = np.array(s.size_mm)[:, None], np.array(s.finger_mm)[:, None]
        if motion is not None and motion.count == count:
            finger = finger + np.stack([motion.x_mm[:count], motion.y_mm[:count]])
        finger = np.clip(np.broadcast_to(finger, (2, count)), EDGE * size, (1 - EDGE) * size)
        pull, slack = directions(s, finger), slackless(s, finger)  # (2, 4, time), (4, time)
        # The least tensions with a net force f are P^T (P P^T)^-1 f.
        square = np.einsum("ast,bst->tab", pull, pull)
        solved = np.linalg.solve(square, force.T[..., None])[..., 0].T
        share = np.einsum("ast,at->st", pull, solved)
        needed = np.max(-share / slack, axis=0)
        basis = np.minimum(s.pretension_n / slack.min(axis=0), TIGHTEST * self._limit / slack.max(axis=0))
        room = ((self._limit - basis * slack) / np.maximum(share + slack * needed, 1e-12)).min(axis=0)
        factor = np.clip(room, 0.0, 1.0)
        self.limited += int(np.count_nonzero(room < 1))
        tension = factor * (share + slack * needed) + basis * slack
        return np.asarray(tension[self._order])

    def facts(self) -> dict[str, Any]:
        """Return the force per unit of the signal, and how many samples were reduced to keep within the limit."""
        return {"newton_per_unit": self._newton_per_unit, "limited_samples": self.limited}


def _strings(settings: Settings, finger_mm: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """Return the vectors from the finger to the motors, mm, float64, shape (x and y, string, …)."""
    width, height = settings.size_mm
    finger = np.array(settings.finger_mm) if finger_mm is None else finger_mm
    corners = np.array([[0, height], [width, height], [0, 0], [width, 0]], np.float64).T
    return np.asarray(corners.reshape(2, 4, *[1] * (finger.ndim - 1)) - finger[:, None])


def _band(display: Display) -> tuple[float, float]:
    low, high = display.band or (0.0, np.inf)
    return low, min(high, display.rate / 2)


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
    stream_signal=TabletStream,
    hazard="Strings pull at a finger: start with a small share of the limit.",
)

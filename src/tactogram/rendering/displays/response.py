"""Response of a display, its output per drive over frequency: a table, a formula or a constant; and its inverse."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray
from pydantic import AfterValidator, Field, model_validator

from tactogram.errors import DataError, ParameterError
from tactogram.signal.io.atomic import atomic_write
from tactogram.signal.signal import UNITS
from tactogram.text_files import csv_rows, read_text
from tactogram.validation import FrozenModel

HEADING = ("frequency [Hz]", "gain", "phase [rad]", "coherence")
"""Columns of a response's CSV; the last is optional, ``gain`` may have a unit as ``gain [m/s^2/V]``."""
EDGE_OCTAVES = 1 / 6
"""Width of the cosine edges of an inverse, inside its band."""

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Point = tuple[float, float, float]


def _known(unit: str) -> str:
    if unit not in UNITS:
        raise ValueError(f"must be one of {', '.join(UNITS)}")
    return unit


SignalUnit = Annotated[str, AfterValidator(_known)]


class _Source(FrozenModel):
    unit: SignalUnit
    """Unit of the output; the response is in ``unit`` per unit of the drive."""

    @property
    def range(self) -> tuple[float, float]:
        """Range in which it is known, Hz."""
        return 0.0, np.inf


class FlatResponse(_Source):
    """Constant response."""

    kind: Literal["flat"]
    gain: Positive
    """Output per drive."""

    def at(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the response at ``frequency`` in Hz, complex128, of the same shape."""
        return np.full(np.shape(frequency), self.gain, np.complex128)


class ResonatorResponse(_Source):
    """Mass on a spring driven by a force: acceleration rises by 12 dB per octave to a resonance, then stays constant.

    H(f) = gain (j r)^2 / ((j r)^2 + j r / q + 1) with r = f / resonance_hz: the acceleration of the moved mass per
    drive. General knowledge of inertial voice coils, no device's data sheet.
    """

    kind: Literal["resonator"]
    gain: Positive
    """Output per drive far above the resonance."""
    resonance_hz: Positive
    q: Positive
    """Height of the resonance above the plateau."""

    def at(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the response at ``frequency`` in Hz, complex128, of the same shape."""
        s = 1j * np.asarray(frequency, np.float64) / self.resonance_hz
        response: NDArray[np.complex128] = self.gain * s**2 / (s**2 + s / self.q + 1)
        return response


class TabulatedResponse(_Source):
    """Measured points; gain (in dB) and phase are interpolated smoothly over the logarithm of the frequency."""

    kind: Literal["table"]
    file: str | None = None
    """CSV of frequency, gain and phase, relative to the display's file; read together with it."""
    points: tuple[Point, ...] = ()
    """Frequency in Hz, gain in output per drive, phase in rad (unwrapped), by rising frequency."""

    @model_validator(mode="after")
    def _points_are_a_curve(self) -> TabulatedResponse:
        if self.file is not None and self.points:
            raise ValueError("give file or points, not both")
        if self.file is None and len(self.points) < 2:
            raise ValueError(f"needs a file or at least 2 points, got {len(self.points)}")
        values = np.array(self.points, np.float64).reshape(-1, 3)
        if not np.isfinite(values).all() or (values[:, :2] <= 0).any() or (np.diff(values[:, 0]) <= 0).any():
            raise ValueError("points must be (rising frequency > 0, gain > 0, phase), all finite")
        return self

    def at(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the response at ``frequency`` in Hz, complex128, of the same shape; constant outside of its range."""
        f, gain, phase = np.array(self.points, np.float64).reshape(-1, 3).T
        log_hz = np.log(np.clip(np.asarray(frequency, np.float64), f[0], f[-1]))
        level = scipy.interpolate.PchipInterpolator(np.log(f), np.log(gain))(log_hz)
        turn = scipy.interpolate.PchipInterpolator(np.log(f), phase)(log_hz)
        response: NDArray[np.complex128] = np.exp(level + 1j * turn)
        return response

    @property
    def range(self) -> tuple[float, float]:
        """Range in which it is known, Hz."""
        return self.points[0][0], self.points[-1][0]


Response = FlatResponse | ResonatorResponse | TabulatedResponse
ResponseSource = Annotated[Response, Field(discriminator="kind")]


@dataclass(frozen=True, eq=False)
class InverseResponse:
    """Inverse of a response within a band: drive per output, complex128, shape (bin,), 0 outside of the band.

    ``capped`` is where the cap keeps the output too small, bool, shape (bin,).
    """

    gain: NDArray[np.complex128]
    capped: NDArray[np.bool_]


def inverse(
    response: Response,
    frequency: NDArray[np.float64],
    band: tuple[float, float],
    *,
    cap_db: float,
    phase: bool = True,
) -> InverseResponse:
    """Return the drive per output at ``frequency`` (Hz, rising), 0 outside of ``band``, whose cosine edges lie inside.

    ``cap_db`` limits how far a frequency is raised relative to the most effective one in the band. ``phase`` inverts
    the phase as well. Raises `ParameterError` if no frequency lies in the band.
    """
    inside = (frequency >= band[0]) & (frequency <= band[1]) & (frequency > 0)
    if not inside.any():
        raise ParameterError(
            f"no frequency of the signal lies in the display's band, {band[0]:g} to {band[1]:g} Hz"
        )
    needed = np.zeros(len(frequency), np.complex128)
    needed[inside] = 1 / response.at(frequency[inside])
    size = np.abs(needed)
    most = size[inside].min() * 10 ** (cap_db / 20)
    capped = size > most
    limited = np.minimum(size, most)
    turn = np.exp(1j * np.angle(needed)) if phase else 1.0
    return InverseResponse(limited * turn * edges(frequency, band), capped)


def edges(frequency: NDArray[np.float64], band: tuple[float, float]) -> NDArray[np.float64]:
    """Return 1 inside ``band`` and 0 outside, with cosine edges of `EDGE_OCTAVES` inside; float64, shape (bin,)."""
    low, high = band
    octave = np.log2(np.maximum(frequency, 1e-9))
    rise = np.ones(len(frequency)) if low <= 0 else np.clip((octave - np.log2(low)) / EDGE_OCTAVES, 0, 1)
    fall = (
        np.ones(len(frequency)) if np.isinf(high) else np.clip((np.log2(high) - octave) / EDGE_OCTAVES, 0, 1)
    )
    smooth: NDArray[np.float64] = np.sin(np.pi / 2 * rise) ** 2 * np.sin(np.pi / 2 * fall) ** 2
    return smooth


def read_response(path: Path) -> tuple[Point, ...]:
    """Return the points of a CSV of frequency (Hz), gain and phase (rad, or deg if the heading says so), unwrapped.

    Without a phase column the phase is 0. Lines that begin with ``#`` are comments. Raises `DataError` naming file
    and line if it is invalid.
    """
    rows = [(n, row) for n, row in csv_rows(read_text(path), path) if not row[0].startswith("#")]
    if not rows:
        raise DataError(path, f"empty; expected columns {', '.join(HEADING[:3])}")
    degrees = False
    if not _is_number(rows[0][1][0]):
        heading = [cell.lower() for cell in rows[0][1]]
        if not heading[0].startswith("freq") or len(heading) < 2 or not heading[1].strip().startswith("gain"):
            raise DataError(
                f"{path}: line {rows[0][0]}", f"expected columns {', '.join(HEADING[:3])}, got {rows[0][1]}"
            )
        degrees = len(heading) > 2 and "deg" in heading[2]
        rows = rows[1:]
    values = []
    for number, row in rows:
        if len(row) < 2 or not all(_is_number(cell) for cell in row[:3]):
            raise DataError(
                f"{path}: line {number}", f"expected numbers for frequency, gain and phase, got {row}"
            )
        values.append([float(cell) for cell in row[:3]] + [0.0] * (3 - len(row)))
    points = np.array(values, np.float64).reshape(-1, 3)
    points[:, 2] = np.unwrap(np.radians(points[:, 2]) if degrees else points[:, 2])
    if len(points) < 2 or (points[:, :2] <= 0).any() or (np.diff(points[:, 0]) <= 0).any():
        raise DataError(path, "expected at least 2 rows of rising frequencies > 0 with a gain > 0")
    return tuple((float(f), float(g), float(p)) for f, g, p in points)


def write_response(
    path: Path,
    frequency: NDArray[np.float64],
    response: NDArray[np.complex128],
    *,
    unit: str,
    coherence: NDArray[np.float64] | None = None,
) -> None:
    """Write a response as CSV, atomically; ``unit`` is that of the gain, such as ``m/s^2/V``."""
    phase = np.unwrap(np.angle(response))
    columns: list[NDArray[Any]] = [frequency, np.abs(response), phase]
    heading = [HEADING[0], f"gain [{unit}]", HEADING[2]]
    if coherence is not None:
        columns.append(coherence)
        heading.append(HEADING[3])
    with atomic_write(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(heading)
        writer.writerows([f"{value:.6g}" for value in row] for row in np.stack(columns, axis=1))


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False

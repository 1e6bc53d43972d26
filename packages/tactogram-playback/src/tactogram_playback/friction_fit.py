"""Friction calibration: the square law's constant from voltage and friction, per person, with intervals.

The future work of Cai et al. 2020 (FrictGAN, Sec. 5): a regression between driving voltage and friction coefficient.
The model is mu = mu_0 + s V^2 / F_n with s = mu_0 k_e; least squares give mu_0 and s, and k_e = s / mu_0 with an
interval by Fieller's theorem. The square law is tested, not assumed: a free exponent is fitted, too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy
import tomli_w
from numpy.typing import NDArray

from tactogram.errors import DataError, ParameterError, Remedy
from tactogram.rendering import FrictionCalibration
from tactogram.signal.io import write_text
from tactogram.text_files import read_table

Array = NDArray[np.float64]

COLUMNS = ("voltage_v_rms", "friction")
OPTIONAL = ("person", "normal_force_n")
SIZES = (1e-9, 1e9)
"""Range of a number's magnitude in a table; anything outside cannot have been measured."""
LEAST_PAIRS, LEAST_VOLTAGES = 6, 3
"""Per person: two constants and a spread need that many pairs, and a curve needs three voltages."""


@dataclass(frozen=True)
class FrictionMeasurements:
    """Measurements of one person: voltages (V rms), friction coefficients and normal forces (N), same length."""

    person: str
    voltage_v_rms: Array
    friction: Array
    normal_force_n: Array


def read_pairs(path: Path | str, *, normal_force_n: float | None = None) -> list[FrictionMeasurements]:
    """Return the measurements in a CSV, one entry per person in the order of the file.

    Its columns are ``voltage_v_rms``, ``friction`` (coefficient), and optionally ``person`` and ``normal_force_n``,
    which is an argument for a file without it. Raises `DataError` if a column is missing or a cell is not a number;
    names file and line.
    """
    path = Path(path)
    by_person: dict[str, list[tuple[float, float, float]]] = {}
    for number, row in read_table(path, needed=COLUMNS):
        if unknown := [name for name in row if name not in (*COLUMNS, *OPTIONAL)]:
            raise DataError(path, f"unknown column {unknown[0]!r}; known: {', '.join((*COLUMNS, *OPTIONAL))}")
        if "normal_force_n" not in row and normal_force_n is None:
            remedy = Remedy("add it"), Remedy("give the force as", "normal_force_n")
            raise DataError(path, "has no column normal_force_n", remedy=remedy)
        person = (row.get("person") or "all").strip()
        by_person.setdefault(person, []).append(_numbers(row, normal_force_n, f"{path}, line {number}"))
    if not by_person:
        raise DataError(path, "no measurements")
    return [FrictionMeasurements(person, *np.array(rows).T) for person, rows in by_person.items()]


def calibrated(pairs: FrictionMeasurements, *, confidence: float = 0.95) -> FrictionCalibration:
    """Return the least-squares fit of the square law to the measurements.

    Raises `ParameterError` if there are too few measurements or voltages, friction does not rise with voltage, or
    mu_0 is not above 0.
    """
    v, mu, force = pairs.voltage_v_rms, pairs.friction, pairs.normal_force_n
    levels = len(np.unique(v))
    if len(v) < LEAST_PAIRS or levels < LEAST_VOLTAGES:
        raise ParameterError(
            f"{pairs.person}: a calibration needs {LEAST_PAIRS} pairs at {LEAST_VOLTAGES} voltages, got {len(v)} at "
            f"{levels}; 0 V among them"
        )
    if not 0 < confidence < 1:
        raise ParameterError.must("confidence", "lie between 0 and 1", confidence)
    u = v**2 / force
    fit = scipy.stats.linregress(u, mu)
    mu_0, slope = float(fit.intercept), float(fit.slope)
    t = float(scipy.stats.t.ppf((1 + confidence) / 2, len(v) - 2))
    half = t * float(fit.intercept_stderr)
    residual_sd = float(np.sqrt(np.sum((mu - mu_0 - slope * u) ** 2) / (len(v) - 2)))
    if mu_0 - half <= 0:
        raise ParameterError(
            f"{pairs.person}: friction at 0 V is {mu_0:.3g} ± {half:.2g}, not above 0: check the pairs"
        )
    if slope - t * fit.stderr <= 0:
        raise ParameterError(
            f"{pairs.person}: friction does not rise with the voltage beyond its scatter ({residual_sd:.2g}): more "
            "pairs, or a higher voltage"
        )
    covariance = -float(u.mean()) * fit.stderr**2
    exponent, interval = _exponent(v, mu, force, mu_0, slope, confidence)
    return FrictionCalibration(
        person=pairs.person,
        mu_0=mu_0,
        mu_0_interval=(mu_0 - half, mu_0 + half),
        newton_per_v2=slope / mu_0,
        newton_per_v2_interval=_fieller(slope, mu_0, (fit.stderr**2, fit.intercept_stderr**2, covariance), t),
        confidence=confidence,
        normal_force_n=float(force.mean()),
        pairs=len(v),
        residual_sd=residual_sd,
        r_squared=float(fit.rvalue**2),
        exponent=exponent,
        exponent_interval=interval,
        highest_v_rms=float(v.max()),
    )


def write_calibrations(path: Path | str, calibrations: Sequence[FrictionCalibration]) -> Path:
    """Write calibrations as TOML, one ``[[calibration]]`` each, atomically."""
    path = Path(path)
    rows = [calibration.model_dump(mode="json", exclude_none=True) for calibration in calibrations]
    write_text(path, tomli_w.dumps({"calibration": rows}))
    return path


def _numbers(row: dict[str, Any], force: float | None, where: str) -> tuple[float, float, float]:
    try:
        values = [float(row[name]) for name in COLUMNS]
        values.append(float(row["normal_force_n"]) if "normal_force_n" in row else float(force or math.nan))
    except (TypeError, ValueError):
        raise DataError(where, f"needs numbers, got {dict(row)}") from None
    plausible = all(SIZES[0] <= abs(value) <= SIZES[1] for value in values if value)
    if not plausible or values[0] < 0 or values[2] <= 0:
        raise DataError(
            where,
            f"voltage must be >= 0, the normal force > 0, each 0 or {SIZES[0]:g} to {SIZES[1]:g} in size, "
            f"got {values}",
        )
    return values[0], values[1], values[2]


def _fieller(a: float, b: float, variances: tuple[float, float, float], t: float) -> tuple[float, float]:
    """Return the interval of the ratio r = a / b, where (a - r b)^2 is t^2 times its variance (b is not near 0).

    ``variances`` are those of a and of b, and their covariance.
    """
    vaa, vbb, vab = variances
    p, q, r = b**2 - t**2 * vbb, a * b - t**2 * vab, a**2 - t**2 * vaa
    root = math.sqrt(max(q**2 - p * r, 0.0))
    return (q - root) / p, (q + root) / p


def _exponent(
    v: Array, mu: Array, force: Array, mu_0: float, slope: float, confidence: float
) -> tuple[float | None, tuple[float, float] | None]:
    """Return the exponent n of mu_0 + s V^n / F_n, and its interval."""
    top = float(v.max())

    def law(voltage: Array, base: float, rise: float, n: float) -> Array:
        return np.asarray(base + rise * (voltage / top) ** n / force)

    start, bounds = (mu_0, slope * top**2, 2.0), ([-np.inf, 0, 0.1], [np.inf, np.inf, 8])
    try:
        fitted, covariance = scipy.optimize.curve_fit(law, v, mu, p0=start, bounds=bounds)
    except (RuntimeError, ValueError):
        return None, None
    n = float(fitted[2])
    half = float(scipy.stats.t.ppf((1 + confidence) / 2, len(v) - 3)) * math.sqrt(float(covariance[2, 2]))
    return (n, (n - half, n + half)) if math.isfinite(half) else (None, None)

"""Friction calibration: the constants of the square law of electrovibration, per person.

The model is mu = mu_0 (1 + k_e V^2 / F_n); `tactogram_playback.friction_fit` fits it to measurements.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.text_files import read_toml
from tactogram.validation import FrozenModel, validated


class FrictionCalibration(FrozenModel):
    """The square law of one person on one display, with intervals (low, high)."""

    person: str
    mu_0: float = Field(gt=0)
    """Friction coefficient without voltage."""
    mu_0_interval: tuple[float, float]
    newton_per_v2: float = Field(gt=0)
    """k_e, N per square of the rms voltage."""
    newton_per_v2_interval: tuple[float, float]
    confidence: float = Field(gt=0, lt=1)
    normal_force_n: float = Field(gt=0)
    """Mean of the measurements'."""
    pairs: int
    residual_sd: float
    """Standard deviation of the friction coefficient from the law."""
    r_squared: float
    exponent: float | None = None
    """Of a fit of mu_0 + s V^n; None if it did not converge."""
    exponent_interval: tuple[float, float] | None = None
    highest_v_rms: float
    """Largest measured voltage; beyond it the law is extrapolated."""

    @property
    def square_law_holds(self) -> bool | None:
        """Whether the exponent's interval contains 2; None without one. No proof: the interval may be wide."""
        if self.exponent_interval is None:
            return None
        return self.exponent_interval[0] <= 2 <= self.exponent_interval[1]

    def settings(self) -> dict[str, Any]:
        """Return the keys of `electrovibration.Settings` determined by this calibration."""
        contradiction = ""
        if self.square_law_holds is False:
            contradiction = f"; they contradict the square law (exponent {self.exponent:.2f})"
        return {
            "newton_per_v2": self.newton_per_v2,
            "mu_0": self.mu_0,
            "normal_force_n": self.normal_force_n,
            "calibrated_by": f"{self.pairs} pairs of {self.person} up to {self.highest_v_rms:g} V rms{contradiction}",
            "calibrated_to_v_rms": self.highest_v_rms,
        }


class _Calibrations(FrozenModel):
    calibration: list[FrictionCalibration]


def read_calibrations(path: Path | str) -> list[FrictionCalibration]:
    """Return the calibrations in a TOML file.

    Raises `DataError` if it is not valid TOML; `ParameterError` if a key or value is wrong.
    """
    return validated(_Calibrations, read_toml(Path(path)), where=str(path)).calibration


def calibration_of(path: Path | str, person: str | None = None) -> FrictionCalibration:
    """Return the calibration of a person, who may be omitted if the file holds one, from `write_calibrations`' file.

    Raises the errors of `read_calibrations`, and `ParameterError` if the person is not in the file, appears twice, or
    must be named.
    """
    known = read_calibrations(path)
    names = ", ".join(calibration.person for calibration in known)
    if person is None and len(known) != 1:
        raise ParameterError(f"{path}: holds {names or 'no calibration'}: name the person")
    matching = [calibration for calibration in known if person in (None, calibration.person)]
    if len(matching) != 1:
        raise ParameterError(f"{path}: person must be one of {names}, got {person!r} {len(matching)} times")
    return matching[0]

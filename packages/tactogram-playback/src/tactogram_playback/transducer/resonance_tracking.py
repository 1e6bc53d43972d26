"""Resonance tracking: a coarse sweep, a lock, and steps that keep the carrier at a transducer's resonance, with a log.

The resonance moves with temperature and touch. Four methods follow it from a measured admittance Y(f):

- ``climb_admittance``: step, and turn round if abs(Y) fell.
- ``dither_admittance``: compare abs(Y) below and above the carrier, as in Hatori & Takemura 2023, Sec. III-C.
- ``dither_conductance``: the same with Re(Y), which is largest at the resonance itself; the maximum of abs(Y) lies
  below by 3 Hz at Q 300 and 27 Hz at Q 100 (simulated presets) because of C0's current.
- ``motional_phase``: the phase of Y - j w C0 is 0 at resonance; one measurement per step, which also tells the side.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field, model_validator

from tactogram.errors import ParameterError, TactogramError
from tactogram.signal.io import write_text
from tactogram.validation import FrozenModel
from tactogram_playback.transducer.circuit import Transducer, fitted_transducer

MeasureAdmittance = Callable[[float], complex]
"""Admittance in S at a frequency in Hz, measured after the transducer has settled there."""
Method = Literal["climb_admittance", "dither_admittance", "dither_conductance", "motional_phase"]
State = Literal["sweep", "lock", "track", "frozen", "lost"]

MOST_FAILURES = 5
"""Number of failed measurements in a row that ends the tracking."""
FAILED = f"{MOST_FAILURES} measurements in a row failed: check the probe"


class TrackingError(TactogramError):
    """No resonance was found, or the measurements keep failing; the carrier is not reliable."""


class TrackingSettings(FrozenModel):
    """Settings of the search for a resonance and of its tracking."""

    method: Method = "motional_phase"
    """The default is unbiased at every Q."""
    low_hz: float = Field(default=27_400.0, gt=0)
    """Lower end of the coarse sweep; the carrier never leaves the sweep's range."""
    high_hz: float = Field(default=29_000.0, gt=0)
    sweep_points: int = Field(default=81, ge=8)
    """Points of the coarse sweep; the default is every 20 Hz, less than half a width at Q 300."""
    q: float | None = Field(default=None, gt=0.5)
    """Quality factor that sets the step size; None: from the sweep. A lower true Q only makes the steps smaller."""
    c0_farad: float | None = Field(default=None, gt=0)
    """Subtracted by ``motional_phase``; None: from the sweep."""
    dither_hz: float | None = Field(default=None, gt=0)
    """Distance of the two measurements from the carrier; None: a sixth of half the width, 8 Hz at Q 300."""
    climb_hz: float | None = Field(default=None, gt=0)
    """Step of ``climb_admittance``; None: a twelfth of half the width, 4 Hz at Q 300."""
    gain: float = Field(default=0.5, gt=0, le=1)
    """Share of the estimated distance covered by a step: lower is less noisy, higher follows faster."""
    most_hz: float = Field(default=40.0, gt=0)
    """Longest step."""
    lost_share: float = Field(default=0.05, gt=0, lt=1)
    """Three steps in a row with a conductance below this share of the one at the lock mean lost, and start a new
    sweep."""

    @model_validator(mode="after")
    def _ordered(self) -> TrackingSettings:
        if not self.low_hz < self.high_hz:
            raise ValueError(f"low_hz must be below high_hz, got {self.low_hz:g} and {self.high_hz:g}")
        return self


@dataclass(frozen=True)
class TrackPoint:
    """A row of the log: a measurement, and the carrier's frequency after it."""

    step: int
    """Counts all measurements; a dither is one step."""
    state: State
    frequency_hz: float
    """Carrier during the measurement."""
    conductance_s: float
    susceptance_s: float
    next_hz: float
    """Carrier after the measurement."""

    @property
    def admittance(self) -> complex:
        """Admittance at ``frequency_hz``, S."""
        return complex(self.conductance_s, self.susceptance_s)


class ResonanceTracker:
    """Tracker that finds a resonance and follows it, step by step."""

    def __init__(self, measure: MeasureAdmittance, settings: TrackingSettings | None = None) -> None:
        self.settings = settings or TrackingSettings()
        self.log: list[TrackPoint] = []
        self.fitted: Transducer | None = None
        """Circuit fitted to the last sweep."""
        self._measure = measure
        self._frequency = math.nan
        self._frozen = False
        self._direction, self._before = 1.0, math.nan
        self._at_lock = math.nan
        self._weak = self._failures = 0

    @property
    def frequency_hz(self) -> float:
        """Where the carrier should be, Hz; NaN before `lock`."""
        return self._frequency

    def freeze(self) -> None:
        """Keep the frequency, as during a trial; measurements and the log continue."""
        self._frozen = True

    def resume(self) -> None:
        """Follow the resonance again."""
        self._frozen = False
        self._before = math.nan

    def lock(self) -> TrackPoint:
        """Sweep coarsely, fit the circuit and go to its resonance; lost points are ignored.

        Raises `TrackingError` if there is no distinct resonance in the range, or too many measurements failed.
        """
        s = self.settings
        frequencies = np.linspace(s.low_hz, s.high_hz, s.sweep_points)
        values = []
        for frequency in frequencies:
            value = complex(self._measure(float(frequency)))
            values.append(value)
            self._logged("sweep", float(frequency), value, float(frequency))
            if len(values) >= MOST_FAILURES and np.isnan(values[-MOST_FAILURES:]).all():
                raise TrackingError(f"no lock: {FAILED}")
        try:
            fitted = fitted_transducer(frequencies, values)
        except ParameterError as error:
            raise TrackingError(f"no lock: {error}") from None
        # A ripple can be fitted, too; a resonance is distinct from what C0 conducts.
        if fitted.q * fitted.c1_farad / fitted.c0_farad < 0.5 or not fitted.q < 1e5:
            raise TrackingError(
                f"no lock: no distinct resonance in {s.low_hz:g} to {s.high_hz:g} Hz; check the probe and the band"
            )
        self.fitted = fitted
        self._frequency = self._clipped(fitted.resonance_hz)
        value = complex(self._measure(self._frequency))
        # In this order: max returns its first argument if the measurement is NaN.
        self._at_lock = max(1 / fitted.r1_ohm / 2, value.real)
        self._before, self._weak, self._failures = math.nan, 0, 0
        return self._logged("lock", self._frequency, value, self._frequency)

    def step(self) -> TrackPoint:
        """Measure once (twice with a dither) and move the carrier, unless frozen.

        Raises `TrackingError` if `lock` was not called, a lost resonance is not found again, or measurements keep
        failing.
        """
        if self.fitted is None:
            raise TrackingError("there is no lock yet: call lock() first")
        now = self._frequency
        away, value = (0.0, complex(self._measure(now))) if self._frozen else self._estimate(self.fitted)
        if not (math.isfinite(value.real) and math.isfinite(value.imag) and math.isfinite(away)):
            self._failures += 1
            if self._failures >= MOST_FAILURES:
                raise TrackingError(FAILED)
            return self._logged("track", now, value, now)
        self._failures = 0
        if self._frozen:
            return self._logged("frozen", now, value, now)
        self._weak = self._weak + 1 if value.real < self.settings.lost_share * self._at_lock else 0
        if self._weak >= 3:
            self._logged("lost", now, value, now)
            return self.lock()
        most = self.settings.most_hz
        self._frequency = self._clipped(now - float(np.clip(away, -most, most)))
        return self._logged("track", now, value, self._frequency)

    def write_log(self, path: Path | str) -> Path:
        """Write the log as a CSV file with the fields of `TrackPoint`, atomically."""
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        names = [field.name for field in fields(TrackPoint)]
        table.writerow(names)
        table.writerows([getattr(point, name) for name in names] for point in self.log)
        path = Path(path)
        write_text(path, text.getvalue())
        return path

    def _estimate(self, fitted: Transducer) -> tuple[float, complex]:
        """Return the estimated distance of the carrier above the resonance, Hz (times the gain), and Y there."""
        s, now = self.settings, self._frequency
        q = s.q or fitted.q
        half_width = now / (2 * q)
        if s.method == "motional_phase":
            value = complex(self._measure(now))
            motional = value - 2j * math.pi * now * (s.c0_farad or fitted.c0_farad)
            # tan of the phase is -2 Q (f - f_s) / f_s; beyond 80 degrees only the side is used.
            slope = math.copysign(
                min(abs(motional.imag), 5.7 * max(motional.real, 1e-15)), motional.imag
            ) / max(motional.real, 1e-15)
            return -s.gain * slope * half_width, value
        if s.method == "climb_admittance":
            value = complex(self._measure(now))
            if abs(value) < self._before:
                self._direction = -self._direction
            self._before = abs(value)
            return -self._direction * (s.climb_hz or half_width / 12), value
        dither = s.dither_hz or half_width / 6
        below, above = complex(self._measure(now - dither)), complex(self._measure(now + dither))
        # Of a Lorentzian 1 / (1 + a x^2), (upper - lower) / (upper + lower) is -2 a x d / (1 + a (x^2 + d^2)); of its
        # root, half of that.
        a = 1 / half_width**2
        conductance = s.method == "dither_conductance"
        low, high = (below.real, above.real) if conductance else (abs(below), abs(above))
        unevenness = (high - low) / max(high + low, 1e-15)
        away = -unevenness * (1 + a * dither**2) / (a * dither) * (0.5 if conductance else 1.0)
        return s.gain * away, (below + above) / 2

    def _clipped(self, frequency: float) -> float:
        return min(max(frequency, self.settings.low_hz), self.settings.high_hz)

    def _logged(self, state: State, frequency_hz: float, value: complex, then: float) -> TrackPoint:
        point = TrackPoint(len(self.log), state, frequency_hz, value.real, value.imag, then)
        self.log.append(point)
        return point

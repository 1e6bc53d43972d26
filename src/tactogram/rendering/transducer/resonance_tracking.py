"""Keeping a carrier at a transducer's resonance: coarse sweep, lock, track, with a log, and a stop during a trial.

The resonance moves with temperature and with the finger. Four ways to follow it from a measured admittance Y(f):

- ``climb_admittance``: step, look whether abs(Y) rose, turn if not.
- ``dither_admittance``: abs(Y) a little below and a little above; the maximum as in Hatori & Takemura 2023, Sec. III-C.
- ``dither_conductance``: the same of Re(Y), whose maximum is the resonance itself; that of abs(Y) lies below it by
  3 Hz at Q 300 and 27 Hz at Q 100 (simulated, for the presets), since C0's current adds to it.
- ``motional_phase``: the phase of Y - j w C0 is 0 at resonance; one measurement per step, and it knows the side.

What measures is handed in, so that a transducer may be real or simulated.
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
from pydantic import BaseModel, ConfigDict, Field, model_validator

from tactogram.errors import ParameterError, TactogramError
from tactogram.rendering.transducer.circuit import Transducer, fitted
from tactogram.signal.io.atomic import write_text

MeasureAdmittance = Callable[[float], complex]
"""The admittance in S at a frequency in Hz, taken when the transducer has settled there."""
Method = Literal["climb_admittance", "dither_admittance", "dither_conductance", "motional_phase"]
State = Literal["sweep", "lock", "track", "frozen", "lost"]

UNFINISHED = 5
"""So many measurements in a row that are no numbers end the tracking."""
NO_NUMBERS = f"{UNFINISHED} measurements in a row were no numbers: check the probe"


class TrackingError(TactogramError):
    """No resonance was found, or measuring failed for good; the carrier must not be believed."""


class TrackingSettings(BaseModel):
    """Settings of the search for a resonance and of its tracking."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    method: Method = "motional_phase"
    """The default is the one that is right at every Q."""
    low_hz: float = Field(default=27_400.0, gt=0)
    """Lower end of the coarse sweep; the frequency never leaves it."""
    high_hz: float = Field(default=29_000.0, gt=0)
    sweep_points: int = Field(default=81, ge=8)
    """Of the coarse sweep; the default is every 20 Hz, less than half a width at Q 300."""
    q: float | None = Field(default=None, gt=0.5)
    """Quality factor that the steps are sized for; none: the sweep's own. A lower true Q only makes steps smaller."""
    c0_farad: float | None = Field(default=None, gt=0)
    """Subtracted by ``motional_phase``; none: the sweep's own."""
    dither_hz: float | None = Field(default=None, gt=0)
    """Distance of the two measurements from the carrier; none: a sixth of half the width, 8 Hz at Q 300."""
    climb_hz: float | None = Field(default=None, gt=0)
    """Step of ``climb_admittance``; none: a twelfth of half the width, 4 Hz at Q 300."""
    gain: float = Field(default=0.5, gt=0, le=1)
    """Share of the estimated distance that a step goes: lower is quieter, higher follows faster."""
    most_hz: float = Field(default=40.0, gt=0)
    """Longest step."""
    lost_share: float = Field(default=0.05, gt=0, lt=1)
    """Conductance below this share of that at the lock, three steps on end: lost, and swept for again."""

    @model_validator(mode="after")
    def _ordered(self) -> TrackingSettings:
        if not self.low_hz < self.high_hz:
            raise ValueError(f"low_hz must be below high_hz, got {self.low_hz:g} and {self.high_hz:g}")
        return self


@dataclass(frozen=True)
class TrackPoint:
    """A line of the log: what was measured at which frequency, and where the carrier went from there."""

    step: int
    """Counted over everything measured; a dither is one step."""
    state: State
    frequency_hz: float
    """Of the carrier when it was measured."""
    conductance_s: float
    susceptance_s: float
    next_hz: float
    """Of the carrier afterwards."""

    @property
    def admittance(self) -> complex:
        """Whole admittance at ``frequency_hz``, S."""
        return complex(self.conductance_s, self.susceptance_s)


class ResonanceTracker:
    """Finds a resonance and follows it, step by step.

    Parameters
    ----------
    measure : callable
        float to complex: the admittance in S at a frequency in Hz.
    settings : TrackingSettings
    """

    def __init__(self, measure: MeasureAdmittance, settings: TrackingSettings | None = None) -> None:
        self.settings = settings or TrackingSettings()
        self.log: list[TrackPoint] = []
        self.found: Transducer | None = None
        """The circuit fitted to the last sweep."""
        self._measure = measure
        self._frequency = math.nan
        self._frozen = False
        self._direction, self._before = 1.0, math.nan
        self._at_lock = math.nan
        self._weak = self._broken = 0

    @property
    def frequency_hz(self) -> float:
        """Where the carrier should be; not a number before `lock`."""
        return self._frequency

    @property
    def frozen(self) -> bool:
        """Whether the frequency stays as it is."""
        return self._frozen

    def freeze(self) -> None:
        """Keep the frequency from here on, as during a trial; measuring and the log go on."""
        self._frozen = True

    def resume(self) -> None:
        """Follow again."""
        self._frozen = False
        self._before = math.nan

    def lock(self) -> TrackPoint:
        """Sweep coarsely, fit the circuit, and go to its resonance; points that were lost are done without.

        Raises
        ------
        TrackingError
            If no resonance stands out between ``low_hz`` and ``high_hz``, or too many measurements were no numbers.
        """
        s = self.settings
        frequencies = np.linspace(s.low_hz, s.high_hz, s.sweep_points)
        values = []
        for frequency in frequencies:
            value = complex(self._measure(float(frequency)))
            values.append(value)
            self._note("sweep", float(frequency), value, float(frequency))
            if len(values) >= UNFINISHED and np.isnan(values[-UNFINISHED:]).all():
                raise TrackingError(f"no lock: {NO_NUMBERS}")
        try:
            found = fitted(frequencies, values)
        except ParameterError as error:
            raise TrackingError(f"no lock: {error}") from None
        # A ripple fits something, too: a resonance stands out of what C0 conducts.
        if found.q * found.c1_farad / found.c0_farad < 0.5 or not found.q < 1e5:
            raise TrackingError(
                f"no lock: nothing stands out between {s.low_hz:g} and {s.high_hz:g} Hz; check the probe and the band"
            )
        self.found = found
        self._frequency = self._kept(found.resonance_hz)
        value = complex(self._measure(self._frequency))
        # In this order: where the measurement is no number, max returns the first.
        self._at_lock = max(1 / found.r1_ohm / 2, value.real)
        self._before, self._weak, self._broken = math.nan, 0, 0
        return self._note("lock", self._frequency, value, self._frequency)

    def step(self) -> TrackPoint:
        """Measure once (twice with a dither) and move the carrier, unless frozen.

        Raises
        ------
        TrackingError
            If there was no `lock`, a lost resonance is not found again, or nothing is measured any more.
        """
        if self.found is None:
            raise TrackingError("the resonance was not looked for yet: call lock() first")
        now = self._frequency
        away, value = self._frozen_look() if self._frozen else self._look(self.found)
        if not (math.isfinite(value.real) and math.isfinite(value.imag) and math.isfinite(away)):
            self._broken += 1
            if self._broken >= UNFINISHED:
                raise TrackingError(NO_NUMBERS)
            return self._note("track", now, value, now)
        self._broken = 0
        if self._frozen:
            return self._note("frozen", now, value, now)
        self._weak = self._weak + 1 if value.real < self.settings.lost_share * self._at_lock else 0
        if self._weak >= 3:
            self._note("lost", now, value, now)
            return self.lock()
        most = self.settings.most_hz
        self._frequency = self._kept(now - float(np.clip(away, -most, most)))
        return self._note("track", now, value, self._frequency)

    def log_text(self) -> str:
        """Return the log as CSV: step, state, frequency_hz, conductance_s, susceptance_s, next_hz."""
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        names = [field.name for field in fields(TrackPoint)]
        table.writerow(names)
        table.writerows([getattr(point, name) for name in names] for point in self.log)
        return text.getvalue()

    def write_log(self, path: Path | str) -> Path:
        """Write the log as a CSV file: beside, then renamed."""
        path = Path(path)
        write_text(path, self.log_text())
        return path

    def _frozen_look(self) -> tuple[float, complex]:
        return 0.0, complex(self._measure(self._frequency))

    def _look(self, found: Transducer) -> tuple[float, complex]:
        """Return how far above the resonance the carrier is thought to be, Hz (times the gain), and Y there."""
        s, now = self.settings, self._frequency
        q = s.q or found.q
        half_width = now / (2 * q)
        if s.method == "motional_phase":
            value = complex(self._measure(now))
            motional = value - 2j * math.pi * now * (s.c0_farad or found.c0_farad)
            # tan of the phase is -2 Q (f - f_s) / f_s; beyond 80 degrees only the side is believed.
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

    def _kept(self, frequency: float) -> float:
        return min(max(frequency, self.settings.low_hz), self.settings.high_hz)

    def _note(self, state: State, at: float, value: complex, then: float) -> TrackPoint:
        point = TrackPoint(len(self.log), state, at, value.real, value.imag, then)
        self.log.append(point)
        return point

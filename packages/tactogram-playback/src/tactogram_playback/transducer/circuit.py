"""Equivalent circuit of a piezoelectric transducer (Butterworth-Van Dyke): admittance, envelope filter, fit, presets.

A capacitance C0 in parallel with a series resonator R1, L1, C1, whose current is proportional to the velocity of the
horn's tip. Near resonance the transducer is a narrow filter: the carrier's modulation passes a first-order low-pass at
``f_s / (2 Q)``.

The presets are simulated: catalogue figures (free) or assumptions (loaded), none measured on a display.
`fitted_transducer` fits a measured sweep.

References
----------
- Van Dyke, K. S. (1928). The piezo-electric resonator and its equivalent network. Proc. IRE 16(6), 742-764.
- APC International, catalogue entry 90-4040 (28 kHz): Q_m 800, C0 3.8 nF, impedance at most 50 ohm: the free presets.
- Hatori & Takemura (2023). IEEE Access 11. Sec. III-C: the resonance, about 28.2 kHz.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from operator import itemgetter
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import DataError, ParameterError
from tactogram.text_files import read_table

RESONANCE_HZ = 28_200.0
"""Hatori & Takemura 2023, Sec. III-C."""
C0_FARAD = 3.8e-9
"""At 1 kHz; catalogue (APC 90-4040)."""


@dataclass(frozen=True)
class Transducer:
    """A transducer's circuit, by its series resonance f_s, where the motional branch is purely resistive.

    ``q`` is the quality factor, 2 pi f_s L1 / R1, > 0.5 (below, nothing oscillates); ``r1_ohm`` the motional
    resistance; ``c0_farad`` the capacitance in parallel with the motional branch.
    """

    resonance_hz: float = RESONANCE_HZ
    q: float = 300.0
    r1_ohm: float = 100.0
    c0_farad: float = C0_FARAD

    def __post_init__(self) -> None:
        for name, least in (("resonance_hz", 0.0), ("q", 0.5), ("r1_ohm", 0.0), ("c0_farad", 0.0)):
            value = getattr(self, name)
            if not (value > least and math.isfinite(value)):
                raise ParameterError(f"a transducer's {name} must be > {least:g}, got {value}")

    @property
    def l1_henry(self) -> float:
        """Motional inductance, Q R1 / (2 pi f_s)."""
        return self.q * self.r1_ohm / (2 * math.pi * self.resonance_hz)

    @property
    def c1_farad(self) -> float:
        """Motional capacitance, 1 / (2 pi f_s R1 Q)."""
        return 1 / (2 * math.pi * self.resonance_hz * self.r1_ohm * self.q)

    @property
    def antiresonance_hz(self) -> float:
        """Parallel resonance f_p, close to the minimum of the admittance."""
        return self.resonance_hz * math.sqrt(1 + self.c1_farad / self.c0_farad)

    @property
    def coupling(self) -> float:
        """Effective coupling factor, sqrt(1 - (f_s / f_p)^2)."""
        return math.sqrt(1 - (self.resonance_hz / self.antiresonance_hz) ** 2)

    @property
    def envelope_cutoff_hz(self) -> float:
        """Cut-off (-3 dB) of the envelope with the carrier at resonance, f_s / (2 Q)."""
        return self.resonance_hz / (2 * self.q)

    @property
    def settling_s(self) -> float:
        """Time constant of the envelope, Q / (pi f_s)."""
        return self.q / (math.pi * self.resonance_hz)

    def motional_admittance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the motional branch's current per volt, S, at ``frequency`` in Hz (not 0)."""
        w = 2 * np.pi * np.asarray(frequency, np.float64)
        impedance = self.r1_ohm + 1j * w * self.l1_henry + 1 / (1j * w * self.c1_farad)
        return np.asarray(1 / impedance)

    def admittance(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the total current per volt, S, at ``frequency`` in Hz (not 0)."""
        w = 2 * np.pi * np.asarray(frequency, np.float64)
        return np.asarray(1j * w * self.c0_farad + self.motional_admittance(frequency))

    def envelope_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the transmission of an envelope's component at ``frequency`` in Hz, 1 at 0: a first-order low-pass.

        The carrier is at resonance. Agrees with the mean of the two sidebands to 3e-4 in magnitude for Q of 14 to 800
        and components up to 1 kHz.
        """
        f = np.asarray(frequency, np.float64)
        return np.asarray(1 / (1 + 1j * f / self.envelope_cutoff_hz))

    def shifted(self, by_hz: float) -> Transducer:
        """Return the circuit with its resonance shifted, as by temperature: Q, R1 and C0 stay."""
        return replace(self, resonance_hz=self.resonance_hz + by_hz)


PRESETS: dict[str, Transducer] = {
    "free": Transducer(q=800, r1_ohm=20),
    "free_high_r": Transducer(q=800, r1_ohm=50),
    "plate": Transducer(q=300, r1_ohm=100),
    "finger": Transducer(q=100, r1_ohm=300),
    "damped": Transducer(q=30, r1_ohm=800),
}
"""Simulated transducers by name. Q 800 and R1 of 20 to 50 ohm: catalogue; the loaded ones are assumptions."""


def fitted_transducer(frequency: ArrayLike, admittance: ArrayLike) -> Transducer:
    """Return the least-squares fit of a transducer to a measured sweep.

    ``frequency`` (Hz, shape (point,)) needs at least eight points on both sides of the resonance; ``admittance``
    (complex, shape (point,), S) is NaN for lost measurements, at most half of the points, which the fit ignores. With
    1 % noise and every second point of 81 missing, the resonance is still within 0.02 of its width (simulated, 40
    sweeps of each of the presets from Q 30 to 800); with all points within 0.01. Raises `ParameterError` if there are
    too few points, too many are lost, or they contain no resonance.
    """
    from scipy.optimize import least_squares

    f = np.asarray(frequency, np.float64)
    y = np.asarray(admittance, np.complex128)
    if f.ndim != 1 or f.shape != y.shape or len(np.unique(f)) < 8:
        raise ParameterError(
            f"a sweep needs 8 frequencies and as many admittances, got {f.shape} and {y.shape}"
        )
    valid = ~np.isnan(y)
    if not ((f >= 1) & (f <= 1e9)).all() or not (np.abs(y[valid]) <= 1e6).all():
        raise ParameterError(
            "a sweep's frequencies must be 1 to 1e9 Hz, and its values finite, at most 1e6 S"
        )
    if valid.sum() < max(8, len(f) / 2):
        raise ParameterError(
            f"{(~valid).sum()} of the sweep's {len(f)} measurements were lost: check the probe"
        )
    f, y = f[valid], y[valid]
    order = np.argsort(f)
    start = _first_guess(f[order], y[order])
    scale = np.abs(y).max()

    def residuals(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        difference = (Transducer(*np.exp(logs)).admittance(f) - y) / scale
        return np.concatenate([difference.real, difference.imag])

    lower = np.log([f.min(), 0.51, 1e-3, 1e-13])
    upper = np.log([f.max(), 1e6, 1e7, 1e-5])
    first = np.clip(
        np.log([start.resonance_hz, start.q, start.r1_ohm, start.c0_farad]), lower + 1e-6, upper - 1e-6
    )
    fit = least_squares(
        residuals, first, bounds=(lower, upper), x_scale=[1e-3, 1, 1, 1], xtol=1e-14, ftol=1e-14
    )
    best = Transducer(*(float(value) for value in np.exp(fit.x)))
    if not f.min() * (1 + 1e-9) < best.resonance_hz < f.max() * (1 - 1e-9):
        raise ParameterError(
            f"no resonance from {f.min():g} to {f.max():g} Hz in this sweep: sweep where the admittance has its maximum"
        )
    return best


def read_sweep(path: Path | str) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Return frequencies (Hz) and admittances (S) from a CSV's columns frequency_hz, conductance_s and susceptance_s.

    Lost measurements are ``nan`` in both. From a log of `resonance_tracking`, which also has a column ``state``, only
    the last sweep that led to a lock is read: the resonance may have moved afterwards. Raises `DataError` if the file
    cannot be read or a cell is not a number; names file and line.
    """
    path = Path(path)
    columns = ("frequency_hz", "conductance_s", "susceptance_s")
    rows: list[list[float]] = []
    states: list[str] = []
    for number, row in read_table(path, needed=columns):
        try:
            rows.append([float(row[name]) for name in columns])
        except ValueError:
            raise DataError(f"{path}, line {number}: needs three numbers, got {row}") from None
        states.append(row.get("state") or "sweep")
    sweep = _last_sweep(rows, states)
    if not sweep:
        raise DataError(f"{path}: no points")
    f, g, b = np.array(sweep).T
    return f, g + 1j * b


def _last_sweep(rows: Sequence[list[float]], states: Sequence[str]) -> list[list[float]]:
    """Return the rows of the last sweep that led to a lock, or of all sweeps if none did."""
    pieces = groupby(zip(states, rows, strict=True), itemgetter(0))
    runs = [(state, [row for _, row in piece]) for state, piece in pieces]
    locked = [points for (state, points), (then, _) in pairwise(runs) if (state, then) == ("sweep", "lock")]
    return locked[-1] if locked else [row for state, points in runs if state == "sweep" for row in points]


def _first_guess(f: NDArray[np.float64], y: NDArray[np.complex128]) -> Transducer:
    """Return a starting point: conductance peak, its half width, and C0 from the ends."""
    conductance = y.real
    top = int(conductance.argmax())
    if not conductance[top] > 0:
        raise ParameterError("no resonance in this sweep: its conductance is nowhere above 0")
    above = f[conductance > conductance[top] / 2]
    width = max(float(np.ptp(above)), float(np.ptp(f)) / len(f))
    ends = np.concatenate([y[:2].imag / f[:2], y[-2:].imag / f[-2:]]) / (2 * np.pi)
    return Transducer(
        float(f[top]),
        max(0.6, float(f[top]) / width),
        1 / max(float(conductance[top]), 1e-9),
        max(float(np.median(ends)), 1e-12),
    )

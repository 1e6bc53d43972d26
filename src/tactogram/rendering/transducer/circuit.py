"""A piezoelectric transducer as its equivalent circuit (Butterworth-Van Dyke): admittance, envelope filter, presets.

A capacitance C0 stands beside a series resonator R1, L1, C1 whose current is the velocity of the horn's tip, but for a
constant. Near resonance the transducer is a narrow filter: what modulates the carrier passes a first-order low-pass at
``f_s / (2 Q)``.

Every transducer here is simulated. The presets' figures are of a catalogue (free) or assumed (loaded); none was
measured on a display. `fitted` reads the figures off a measured sweep.

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
    """A simulated transducer.

    Parameters
    ----------
    resonance_hz : float
        Series resonance f_s, where the motional branch is a resistance. > 0.
    q : float
        Quality factor, 2 pi f_s L1 / R1. > 0.5 (below, nothing oscillates).
    r1_ohm : float
        Motional resistance. > 0.
    c0_farad : float
        Capacitance beside the motional branch. > 0.

    Raises
    ------
    ParameterError
        If a value is out of range.
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
        """Parallel resonance f_p, where the admittance is least (nearly)."""
        return self.resonance_hz * math.sqrt(1 + self.c1_farad / self.c0_farad)

    @property
    def coupling(self) -> float:
        """Effective coupling factor, sqrt(1 - (f_s / f_p)^2)."""
        return math.sqrt(1 - (self.resonance_hz / self.antiresonance_hz) ** 2)

    @property
    def envelope_cutoff_hz(self) -> float:
        """Where the envelope is at -3 dB with the carrier at resonance, f_s / (2 Q)."""
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
        """Return the whole current per volt, S, at ``frequency`` in Hz (not 0)."""
        w = 2 * np.pi * np.asarray(frequency, np.float64)
        return np.asarray(1j * w * self.c0_farad + self.motional_admittance(frequency))

    def envelope_response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return what passes of an envelope's line at ``frequency`` in Hz, 1 at 0: a first-order low-pass.

        The carrier is at resonance. Agrees with the two sidebands' mean to 3e-4 in magnitude for Q of 14 to 800 and
        lines up to 1 kHz.
        """
        f = np.asarray(frequency, np.float64)
        return np.asarray(1 / (1 + 1j * f / self.envelope_cutoff_hz))

    def shifted(self, by_hz: float) -> Transducer:
        """Return the same with its resonance moved, as by temperature: Q, R1 and C0 stay."""
        return replace(self, resonance_hz=self.resonance_hz + by_hz)


PRESETS: dict[str, Transducer] = {
    "free": Transducer(q=800, r1_ohm=20),
    "free_high_r": Transducer(q=800, r1_ohm=50),
    "plate": Transducer(q=300, r1_ohm=100),
    "finger": Transducer(q=100, r1_ohm=300),
    "damped": Transducer(q=30, r1_ohm=800),
}
"""Simulated transducers by name. Q 800 and R1 of 20 to 50 ohm: catalogue; the loaded ones are our assumptions."""


def preset(name: str) -> Transducer:
    """Return the simulated transducer of that name.

    Raises
    ------
    ParameterError
        If there is none; says which there are.
    """
    if name not in PRESETS:
        raise ParameterError(f"transducer must be one of {', '.join(PRESETS)}, got {name!r}")
    return PRESETS[name]


def fitted(frequency: ArrayLike, admittance: ArrayLike) -> Transducer:
    """Return the transducer whose admittance is nearest to a measured sweep, in the least squares.

    Parameters
    ----------
    frequency : float array, shape (point,), Hz
        At least eight, on both sides of the resonance.
    admittance : complex array, shape (point,), S
        Not a number where a measurement was lost; half of the points at most, which the fit does without. With 1 %
        noise and every second point of 81 missing, the resonance is still within 0.02 of its width (simulated, 40
        sweeps of each of the presets from Q 30 to 800); all points: 0.01.

    Raises
    ------
    ParameterError
        If there are too few points, too many are lost, or no resonance lies among them.
    """
    from scipy.optimize import least_squares

    f = np.asarray(frequency, np.float64)
    y = np.asarray(admittance, np.complex128)
    if f.ndim != 1 or f.shape != y.shape or len(f) < 8:
        raise ParameterError(
            f"a sweep needs 8 frequencies and as many admittances, got {f.shape} and {y.shape}"
        )
    if not (np.isfinite(f).all() and (f > 0).all()) or np.isinf(y).any():
        raise ParameterError("a sweep's frequencies must be > 0 Hz, and all of it finite")
    kept = ~np.isnan(y)
    if kept.sum() < max(8, len(f) / 2):
        raise ParameterError(
            f"{(~kept).sum()} of the sweep's {len(f)} measurements were lost: check the probe"
        )
    f, y = f[kept], y[kept]
    order = np.argsort(f)
    start = _first_guess(f[order], y[order])
    scale = np.abs(y).max()

    def away(logs: NDArray[np.float64]) -> NDArray[np.float64]:
        difference = (Transducer(*np.exp(logs)).admittance(f) - y) / scale
        return np.concatenate([difference.real, difference.imag])

    lower = np.log([f.min(), 0.51, 1e-3, 1e-13])
    upper = np.log([f.max(), 1e6, 1e7, 1e-5])
    first = np.clip(
        np.log([start.resonance_hz, start.q, start.r1_ohm, start.c0_farad]), lower + 1e-6, upper - 1e-6
    )
    found = least_squares(away, first, bounds=(lower, upper), x_scale=[1e-3, 1, 1, 1], xtol=1e-14, ftol=1e-14)
    best = Transducer(*(float(value) for value in np.exp(found.x)))
    if not f.min() * (1 + 1e-9) < best.resonance_hz < f.max() * (1 - 1e-9):
        raise ParameterError(
            f"no resonance from {f.min():g} to {f.max():g} Hz in this sweep: sweep where the admittance has its maximum"
        )
    return best


def read_sweep(path: Path | str) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Return frequencies in Hz and admittances in S of a CSV with columns frequency_hz, conductance_s, susceptance_s.

    A measurement that was lost is ``nan`` in both, in the table and here.

    Of a log of tracking, which has a column ``state`` too, its last whole sweep: what came after was measured of a
    resonance that may have moved.

    Raises
    ------
    DataError
        If the file cannot be read or a cell is no number; names file and line.
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
    swept = _last_sweep(rows, states)
    if not swept:
        raise DataError(f"{path}: holds no point")
    f, g, b = np.array(swept).T
    return f, g + 1j * b


def _last_sweep(rows: Sequence[list[float]], states: Sequence[str]) -> list[list[float]]:
    """Return the rows of the last sweep that led to a lock; of all sweeps where none did."""
    pieces = groupby(zip(states, rows, strict=True), itemgetter(0))
    runs = [(state, [row for _, row in held]) for state, held in pieces]
    locked = [held for (state, held), (then, _) in pairwise(runs) if (state, then) == ("sweep", "lock")]
    return locked[-1] if locked else [row for state, held in runs if state == "sweep" for row in held]


def _first_guess(f: NDArray[np.float64], y: NDArray[np.complex128]) -> Transducer:
    """Return a start: conductance peak, its half width, and C0 from the ends."""
    conductance = y.real
    top = int(conductance.argmax())
    if not conductance[top] > 0:
        raise ParameterError("no resonance in this sweep: its conductance is nowhere above 0")
    above = f[conductance > conductance[top] / 2]
    width = max(float(above.max() - above.min()), float(np.diff(f).min()))
    ends = np.concatenate([y[:2].imag / f[:2], y[-2:].imag / f[-2:]]) / (2 * np.pi)
    return Transducer(
        float(f[top]),
        max(0.6, float(f[top]) / width),
        1 / max(float(conductance[top]), 1e-9),
        max(float(np.median(ends)), 1e-12),
    )

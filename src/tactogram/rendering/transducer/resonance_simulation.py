"""Simulated transducers to track: a resonance that drifts, a finger that comes and goes, noise, and settling."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tactogram.rendering.transducer.circuit import Transducer
from tactogram.rendering.transducer.resonance_tracking import ResonanceTracker, TrackingSettings


@dataclass(frozen=True)
class SimulatedTouch:
    """A simulated finger from step ``start`` to ``stop`` (exclusive): other Q and R1, another resonance."""

    start: int
    stop: int
    q: float = 100.0
    r1_ohm: float = 300.0
    shift_hz: float = -15.0
    """Ours, not measured."""


@dataclass(frozen=True)
class DriftingTransducer:
    """A simulated transducer whose resonance moves in a straight line, and that may be touched.

    Parameters
    ----------
    transducer : Transducer
        At step 0.
    drift_hz : float
        Over ``steps``; it stays there afterwards.
    steps : int
    touches : sequence of Touch
    """

    transducer: Transducer
    drift_hz: float = 80.0
    steps: int = 300
    touches: Sequence[SimulatedTouch] = ()

    def at(self, step: int) -> Transducer:
        """Return the transducer as it is at ``step``."""
        moved = self.transducer.shifted(self.drift_hz * min(max(step, 0), self.steps) / self.steps)
        for touch in self.touches:
            if touch.start <= step < touch.stop:
                return replace(moved.shifted(touch.shift_hz), q=touch.q, r1_ohm=touch.r1_ohm)
        return moved


class SimulatedAdmittance:
    """Measures a simulated transducer: its admittance by formula, with noise.

    Parameters
    ----------
    drifting : Drifting
    noise : float
        Standard deviation of the real and of the imaginary part, as a share of the magnitude.
    rng : numpy.random.Generator
    """

    def __init__(self, drifting: DriftingTransducer, *, noise: float, rng: np.random.Generator) -> None:
        self.drifting, self.noise, self.now = drifting, noise, 0
        self._rng = rng

    @property
    def transducer(self) -> Transducer:
        """As it is now."""
        return self.drifting.at(self.now)

    def __call__(self, frequency: float) -> complex:
        """Return the measured admittance in S at ``frequency`` in Hz."""
        wrong = self._rng.standard_normal(2) * self.noise
        return complex(self.transducer.admittance(frequency)) * complex(1 + wrong[0], wrong[1])


@dataclass(frozen=True)
class TrackingResult:
    """Result of tracking a simulated drift, one value per step; errors are the carrier less the true resonance, Hz."""

    tracker: ResonanceTracker
    resonance_hz: tuple[float, ...]
    carrier_hz: tuple[float, ...]

    @property
    def errors_hz(self) -> NDArray[np.float64]:
        """Carrier less resonance after each step, float64, shape (step,)."""
        return np.asarray(np.array(self.carrier_hz) - np.array(self.resonance_hz))

    def summary(self) -> dict[str, float]:
        """Return mean, standard deviation and largest magnitude of the errors, Hz."""
        errors = self.errors_hz
        return {
            "mean_hz": float(errors.mean()),
            "sd_hz": float(errors.std(ddof=1)),
            "max_hz": float(np.abs(errors).max()),
        }


def followed(
    measured: SimulatedAdmittance,
    settings: TrackingSettings,
    *,
    steps: int,
    frozen: range | None = None,
) -> TrackingResult:
    """Lock onto a simulated transducer and follow it for ``steps`` steps.

    Parameters
    ----------
    measured : SimulatedAdmittance
    settings : TrackingSettings
    steps : int
    frozen : range, optional
        Steps during which the frequency is kept, as in a trial.
    """
    tracker = ResonanceTracker(measured, settings)
    tracker.lock()
    resonance, carrier = [], []
    for step in range(steps):
        measured.now = step
        if frozen is not None and step == frozen.start:
            tracker.freeze()
        if frozen is not None and step == frozen.stop:
            tracker.resume()
        tracker.step()
        resonance.append(measured.transducer.resonance_hz)
        carrier.append(tracker.frequency_hz)
    return TrackingResult(tracker, tuple(resonance), tuple(carrier))

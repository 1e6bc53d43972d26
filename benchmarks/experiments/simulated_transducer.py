"""Simulated transducers: a drifting and touched resonance to track, and the response to an envelope or a waveform.

Responses are motional current times R1, in V: at resonance, once settled, that equals the drive's amplitude.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import signal as dsp

from tactogram.errors import ParameterError, UnitError
from tactogram.signal.filters import butterworth
from tactogram.signal.signal import Signal
from tactogram_playback.transducer.circuit import Transducer
from tactogram_playback.transducer.resonance_tracking import ResonanceTracker, TrackingSettings
from tactogram_playback.transducer.simulation import TransducerSimulation


@dataclass(frozen=True)
class SimulatedTouch:
    """A simulated finger from step ``start`` to ``stop`` (exclusive), which changes Q, R1 and the resonance."""

    start: int
    stop: int
    q: float = 100.0
    r1_ohm: float = 300.0
    shift_hz: float = -15.0
    """Assumed, not measured."""


@dataclass(frozen=True)
class DriftingTransducer:
    """A simulated transducer, perhaps touched, whose resonance drifts linearly by ``drift_hz`` over ``steps``."""

    transducer: Transducer
    drift_hz: float = 80.0
    steps: int = 300
    touches: Sequence[SimulatedTouch] = ()

    def at(self, step: int) -> Transducer:
        """Return the transducer at ``step``."""
        moved = self.transducer.shifted(self.drift_hz * min(max(step, 0), self.steps) / self.steps)
        for touch in self.touches:
            if touch.start <= step < touch.stop:
                return replace(moved.shifted(touch.shift_hz), q=touch.q, r1_ohm=touch.r1_ohm)
        return moved


class SimulatedAdmittance:
    """Admittance of a simulated transducer, with noise.

    Parameters
    ----------
    noise : float
        Standard deviation of the real and of the imaginary part, as a share of the magnitude.
    """

    def __init__(self, drifting: DriftingTransducer, *, noise: float, rng: np.random.Generator) -> None:
        self.drifting, self.noise, self.step = drifting, noise, 0
        self._rng = rng

    @property
    def transducer(self) -> Transducer:
        """The transducer at the current step."""
        return self.drifting.at(self.step)

    def __call__(self, frequency: float) -> complex:
        """Return the measured admittance in S at ``frequency`` in Hz."""
        error = self._rng.standard_normal(2) * self.noise
        return complex(self.transducer.admittance(frequency)) * complex(1 + error[0], error[1])


@dataclass(frozen=True)
class TrackingResult:
    """Carrier and true resonance after each step of a simulated drift."""

    tracker: ResonanceTracker
    resonance_hz: tuple[float, ...]
    carrier_hz: tuple[float, ...]

    @property
    def errors_hz(self) -> NDArray[np.float64]:
        """Carrier minus resonance after each step, float64, shape (step,)."""
        return np.asarray(np.array(self.carrier_hz) - np.array(self.resonance_hz))

    def summary(self) -> dict[str, float]:
        """Return mean, standard deviation and largest magnitude of the errors, Hz."""
        errors = self.errors_hz
        return {
            "mean_hz": float(errors.mean()),
            "sd_hz": float(errors.std(ddof=1)),
            "max_hz": float(np.abs(errors).max()),
        }


def track(
    admittance: SimulatedAdmittance,
    settings: TrackingSettings,
    *,
    steps: int,
    frozen: range | None = None,
) -> TrackingResult:
    """Lock onto a simulated transducer and track it for ``steps`` steps; the carrier stays fixed during ``frozen``."""
    tracker = ResonanceTracker(admittance, settings)
    tracker.lock()
    resonance, carrier = [], []
    for step in range(steps):
        admittance.step = step
        if frozen is not None and step == frozen.start:
            tracker.freeze()
        if frozen is not None and step == frozen.stop:
            tracker.resume()
        tracker.step()
        resonance.append(admittance.transducer.resonance_hz)
        carrier.append(tracker.frequency_hz)
    return TrackingResult(tracker, tuple(resonance), tuple(carrier))


def simulate_envelope(transducer: Transducer, envelope: Signal, *, carrier_hz: float | None = None) -> Signal:
    """Return the envelope of a simulated transducer's motion, from rest; same rate and length.

    Parameters
    ----------
    envelope : Signal
        Amplitude of the carrier, one axis, V.
    carrier_hz : float, optional
        The transducer's resonance by default.
    """
    _check_drive(envelope)
    carrier = transducer.resonance_hz if carrier_hz is None else carrier_hz
    simulated = TransducerSimulation(transducer, rate=envelope.rate, carrier_hz=carrier)
    motional, _ = simulated.process(envelope.samples[0])
    return envelope.with_samples(np.abs(motional) * transducer.r1_ohm)


def simulate_waveform(transducer: Transducer, drive: Signal) -> Signal:
    """Return the motion of a simulated transducer, from rest, for a modulated carrier of one axis in V.

    The drive is linear between two samples, as after a converter's filter; at 500 kHz this costs a 28.2 kHz carrier
    1 % of its amplitude. The rate must be at least eight times the resonance.
    """
    _check_drive(drive)
    if drive.rate < 8 * transducer.resonance_hz:
        raise ParameterError(
            f"a waveform for {transducer.resonance_hz:g} Hz needs a rate of {8 * transducer.resonance_hz:g} Hz or "
            f"more, got {drive.rate:g}; simulate its envelope instead"
        )
    t = transducer
    a = np.array([[-t.r1_ohm / t.l1_henry, -1 / t.l1_henry], [1 / t.c1_farad, 0]])
    system = (a, np.array([[1 / t.l1_henry], [0]]), np.array([[t.r1_ohm, 0]]), np.zeros((1, 1)))
    *discrete, _ = dsp.cont2discrete(system, 1 / drive.rate, method="foh")
    numerator, denominator = dsp.ss2tf(*discrete)
    return drive.with_samples(dsp.lfilter(numerator[0], denominator, drive.samples[0].astype(np.float64)))


def demodulated(waveform: Signal, *, carrier_hz: float, band_hz: float) -> Signal:
    """Return the envelope of a modulated carrier up to ``band_hz``: mixed down to 0 Hz, low-passed without delay."""
    if not 0 < band_hz < carrier_hz < waveform.rate / 2:
        raise ParameterError(
            f"needs 0 < band < carrier < half the rate, got {band_hz:g}, {carrier_hz:g} and {waveform.rate / 2:g} Hz"
        )
    mixed = (
        2 * waveform.samples[0] * np.exp(-2j * np.pi * carrier_hz * np.arange(len(waveform)) / waveform.rate)
    )
    sos = butterworth(waveform.rate, 0, band_hz, passes=2)
    pad = min(len(waveform) - 1, int(3 * waveform.rate / band_hz))
    slow = [
        dsp.sosfiltfilt(sos, part, padtype="even" if pad else None, padlen=pad)
        for part in (mixed.real, mixed.imag)
    ]
    return waveform.with_samples(np.hypot(*slow))


def _check_drive(signal: Signal) -> None:
    if signal.unit != "V":
        raise UnitError(f"a transducer's drive must be in V, got {signal.unit}")
    if len(signal.axes) != 1 or signal.domain != "time":
        raise ParameterError(
            f"a drive must be one axis over time, got {len(signal.axes)} over {signal.domain}"
        )

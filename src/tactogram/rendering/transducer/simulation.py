"""Simulated transducer and measurement bench, for trying resonance tracking without a device.

`TransducerSimulation` solves the circuit in a frame that rotates with the carrier: only envelopes are sampled (at some
10 kHz), nothing is averaged over a carrier's period, and carrier and resonance may change while it runs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import BaseModel, ConfigDict, Field
from scipy import signal as dsp

from tactogram.errors import ParameterError
from tactogram.rendering.transducer.circuit import PRESETS, Transducer

Array = NDArray[np.float64]

ENVELOPE_HZ = 4000.0
"""Rate at which the bench solves the circuit; the current's amplitude is interpolated linearly in between."""


class TransducerSimulation:
    """A simulated transducer with state, driven by blocks of an envelope that is linear between two samples.

    The result does not depend on how the envelope is cut into blocks. States are the motional current i and the
    voltage u across C1, as complex amplitudes: L1 i' = V - R1 i - u, C1 u' = i, each minus j w times itself. The
    matrix is diagonalised, and each mode is a recursion that is exact for a piecewise linear drive.
    """

    def __init__(self, transducer: Transducer, *, rate: float, carrier_hz: float) -> None:
        if not (rate > 0 and np.isfinite(rate)):
            raise ParameterError(f"rate must be > 0 Hz, got {rate}")
        self.rate = float(rate)
        self._state: NDArray[np.complex128] = np.zeros(2, np.complex128)
        self._last: complex = 0j
        self.change(transducer=transducer, carrier_hz=carrier_hz)

    def change(self, *, transducer: Transducer | None = None, carrier_hz: float | None = None) -> None:
        """Continue with another transducer (drift, a touch) or carrier; currents, voltages and phase do not jump."""
        if transducer is not None:
            self.transducer = transducer
        if carrier_hz is not None:
            if not (carrier_hz > 0 and np.isfinite(carrier_hz)):
                raise ParameterError(f"carrier_hz must be > 0, got {carrier_hz}")
            self.carrier_hz = float(carrier_hz)
        t, w = self.transducer, 2 * np.pi * self.carrier_hz
        matrix = np.array(
            [[-t.r1_ohm / t.l1_henry - 1j * w, -1 / t.l1_henry], [1 / t.c1_farad, -1j * w]], np.complex128
        )
        self._modes, self._basis = np.linalg.eig(matrix)
        self._drive = np.linalg.solve(self._basis, np.array([1 / t.l1_henry, 0], np.complex128))

    def process(self, envelope: ArrayLike) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Return the amplitudes of the motional and of the total current (with C0's), complex128, shape (time,), A.

        ``envelope`` is the next block of the carrier's amplitude, real or complex, shape (time,), V, not empty.
        """
        v = np.atleast_1d(np.asarray(envelope, np.complex128))
        previous = np.concatenate([[self._last], v[:-1]])
        step = 1 / self.rate
        parts = []
        initial = np.linalg.solve(self._basis, self._state)
        for mode, gain, start in zip(self._modes, self._drive, initial, strict=True):
            a = mode * step
            growth = np.exp(a)
            second = (growth - 1 - a) / a**2
            first = (growth - 1) / a - second
            b = gain * step * np.array([second, first])
            part, _ = dsp.lfilter(b, [1, -growth], v, zi=[b[1] * self._last + growth * start - 0j])
            parts.append(part)
        states = self._basis @ np.array(parts)  # 2, time
        self._state, self._last = states[:, -1], complex(v[-1])
        w = 2 * np.pi * self.carrier_hz
        c0 = self.transducer.c0_farad
        return states[0], states[0] + c0 * ((v - previous) * self.rate + 1j * w * v)


class BenchSettings(BaseModel):
    """Settings of the simulated bench: assumptions, not any device's."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    rate: float = Field(default=250_000.0, gt=0)
    amplitude_v: float = Field(default=5.0, gt=0)
    """At the transducer, 0 to peak."""
    shunt_ohm: float = Field(default=10.0, gt=0)
    range_v: tuple[float, float] = (25.0, 2.5)
    """Ranges of the converter's two channels."""
    bits: int = Field(default=14, ge=6, le=24)
    noise: float = Field(default=0.001, ge=0)
    """Standard deviation of each sample, as a share of the channel's range."""
    skew_s: float = 0.0
    """Delay of the current's samples after the voltage's."""
    drift_hz_per_s: float = 0.0
    """Drift of the resonance on the bench's own clock, which advances with every measurement."""


class SimulatedBench:
    """A `Carrier` and a `Recorder` in one, with a simulated transducer (the preset ``plate``, Q 300, by default)."""

    simulated = True
    name = "simulated"

    def __init__(
        self, settings: BenchSettings, *, transducer: Transducer | None = None, rng: np.random.Generator
    ) -> None:
        self.settings, self.rate, self.full_scale = settings, settings.rate, settings.range_v
        self.clock_s = 0.0
        self._initial = transducer or PRESETS["plate"]
        self._rng = rng
        self._carrier_hz = self._initial.resonance_hz
        self._circuit = TransducerSimulation(self._initial, rate=ENVELOPE_HZ, carrier_hz=self._carrier_hz)

    @property
    def transducer(self) -> Transducer:
        """The transducer at the current time."""
        return self._initial.shifted(self.settings.drift_hz_per_s * self.clock_s)

    def retune(self, carrier_hz: float) -> None:
        """Change the carrier's frequency."""
        self._carrier_hz = carrier_hz

    def take(self, seconds: float, *, after_s: float) -> tuple[Array, Array]:
        """Return the voltage and the voltage across the shunt, V, as the converter measures them."""
        s = self.settings
        count, settling = round(seconds * s.rate), round(after_s * ENVELOPE_HZ)
        self._circuit.change(transducer=self.transducer, carrier_hz=self._carrier_hz)
        steps = settling + int(seconds * ENVELOPE_HZ) + 3
        _, total = self._circuit.process(np.full(steps, s.amplitude_v))
        self.clock_s += steps / ENVELOPE_HZ
        t = np.arange(count) / s.rate
        amplitude = np.interp(t, (np.arange(steps) - settling) / ENVELOPE_HZ, total)
        turn = 2j * np.pi * self._carrier_hz
        voltage = (s.amplitude_v * np.exp(turn * t)).real
        current = (amplitude * np.exp(turn * (t + s.skew_s))).real * s.shunt_ohm
        return self._converted(voltage, s.range_v[0]), self._converted(current, s.range_v[1])

    def _converted(self, volts: Array, full_scale: float) -> Array:
        step = 2 * full_scale / 2**self.settings.bits
        noisy = volts + self.settings.noise * full_scale * self._rng.standard_normal(len(volts))
        return np.asarray(np.clip(np.round(noisy / step) * step, -full_scale, full_scale))

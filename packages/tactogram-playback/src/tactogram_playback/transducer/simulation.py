"""Simulated transducer, measurement bench and generator, for trying resonance tracking without a device.

`TransducerSimulation` solves the circuit in a frame that rotates with the carrier: only envelopes are sampled (at some
10 kHz), nothing is averaged over a carrier's period, and carrier and resonance may change while it runs.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Iterator
from typing import Any, Self

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.validation import FrozenModel
from tactogram_playback.transducer.circuit import PRESETS, Transducer

Array = NDArray[np.float64]

ENVELOPE_HZ = 4000.0
"""Rate at which the bench solves the circuit; the current's amplitude is interpolated linearly in between."""
KEPT_S = 0.5
"""Part of what a simulated generator plays that its converter can still measure, s."""
STALLED_S = 2.0
"""Time after which a generator that plays nothing more is not waited for, s."""


class TransducerSimulation:
    """A simulated transducer with state, driven by blocks of an envelope that is linear between two samples.

    The result does not depend on how the envelope is cut into blocks. States are the motional current i and the
    voltage u across C1, as complex amplitudes: L1 i' = V - R1 i - u, C1 u' = i, each minus j w times itself. The
    matrix is diagonalised, and each mode is a recursion that is exact for a piecewise linear drive.
    """

    def __init__(self, transducer: Transducer, *, rate: float, carrier_hz: float) -> None:
        if not (rate > 0 and np.isfinite(rate)):
            raise ParameterError.must("rate", "be > 0 Hz", rate)
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
                raise ParameterError.must("carrier_hz", "be > 0", carrier_hz)
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
            part, _ = scipy.signal.lfilter(b, [1, -growth], v, zi=[b[1] * self._last + growth * start - 0j])
            parts.append(part)
        states = self._basis @ np.array(parts)  # 2, time
        self._state, self._last = states[:, -1], complex(v[-1])
        w = 2 * np.pi * self.carrier_hz
        c0 = self.transducer.c0_farad
        return states[0], states[0] + c0 * ((v - previous) * self.rate + 1j * w * v)


class BenchSettings(FrozenModel):
    """Settings of the simulated bench: assumptions, not any device's."""

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
        times = (np.arange(steps) - settling) / ENVELOPE_HZ
        return self._recorded(times, np.full(steps, s.amplitude_v), total, count)

    def _recorded(
        self, times: Array, volts: Array, total: NDArray[np.complex128], count: int
    ) -> tuple[Array, Array]:
        """Return ``count`` samples from time 0 on, of amplitudes (V and A) at ``times`` (s)."""
        s = self.settings
        t = np.arange(count) / s.rate
        turn = 2j * np.pi * self._carrier_hz
        voltage = (np.interp(t, times, volts) * np.exp(turn * t)).real
        current = (np.interp(t, times, total) * np.exp(turn * (t + s.skew_s))).real * s.shunt_ohm
        return self._converted(voltage, s.range_v[0]), self._converted(current, s.range_v[1])

    def _converted(self, volts: Array, full_scale: float) -> Array:
        step = 2 * full_scale / 2**self.settings.bits
        noisy = volts + self.settings.noise * full_scale * self._rng.standard_normal(len(volts))
        return np.asarray(np.clip(np.round(noisy / step) * step, -full_scale, full_scale))


class SimulatedGenerator(SimulatedBench):
    """A generator behind an amplifier that plays envelopes on a simulated transducer, and the converter beside it.

    It has the methods of `digilent.AnalogDiscovery`; its clock, on which the resonance drifts, is that of the samples
    that it was sent. ``gain`` is the amplifier's. A measurement waits for the samples it needs, unless ``waits`` is
    false: then it is made of the last ones.
    """

    def __init__(
        self,
        settings: BenchSettings,
        *,
        gain: float,
        transducer: Transducer | None = None,
        rng: np.random.Generator,
        waits: bool = True,
    ) -> None:
        super().__init__(settings, transducer=transducer, rng=rng)
        self.gain, self._waits = gain, waits
        self.sent = 0
        self._news = threading.Condition()
        self._played: deque[tuple[Array, NDArray[np.complex128]]] = deque()
        self._playing: TransducerSimulation | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def carrier_hz(self) -> float:
        """Frequency of the carrier, Hz."""
        return self._carrier_hz

    def hold(self, amplitude_v: float, *, longest_s: float) -> None:
        """Hold the carrier at an amplitude of the generator, V."""
        self.settings = self.settings.model_copy(update={"amplitude_v": self.gain * amplitude_v})

    def start(self, rate: float) -> None:
        """Begin to play envelopes at ``rate``, Hz."""
        with self._news:
            self._played.clear()
            self._playing = TransducerSimulation(self.transducer, rate=rate, carrier_hz=self._carrier_hz)

    def advance(self, envelope: NDArray[np.floating]) -> NDArray[np.complex128]:
        """Play a block (V, shape (time,)) and return the amplitude of the motional current, A, of the same shape."""
        with self._news:
            if self._playing is None:
                raise ParameterError("the simulated generator was not started")
            self._playing.change(transducer=self.transducer, carrier_hz=self._carrier_hz)
            volts = self.gain * np.asarray(envelope, np.float64)
            motional, total = self._playing.process(volts)
            self._played.append((volts, total))
            self.sent += len(volts)
            self.clock_s += len(volts) / self._playing.rate
            while sum(len(v) for v, _ in self._played) > KEPT_S * self._playing.rate + len(volts):
                self._played.popleft()
            self._news.notify_all()
        return motional

    def play(
        self, envelope: Iterator[NDArray[np.floating]], *, rate: float, longest_s: float = 600.0
    ) -> None:
        """Play blocks as they come."""
        self.start(rate)
        try:
            for block in envelope:
                self.advance(block)
        finally:
            self.stop()

    def stop(self) -> None:
        """End playing; a measurement that waits is lost."""
        with self._news:
            self._playing = None
            self._news.notify_all()

    def take(self, seconds: float, *, after_s: float) -> tuple[Array, Array]:
        """Return the voltage and the voltage across the shunt, V, of what is being played or held."""
        with self._news:
            playing = self._playing
            if playing is None:
                return super().take(seconds, after_s=after_s)
            ready_s = self.clock_s + after_s + seconds
            if self._waits:
                self._news.wait_for(
                    lambda: self._playing is not playing or self.clock_s >= ready_s, timeout=STALLED_S
                )
            count, steps = round(seconds * self.settings.rate), int(seconds * playing.rate) + 2
            volts, total = (np.concatenate(parts)[-steps:] for parts in zip(*self._played, strict=True))
            if self._playing is not playing or len(volts) < steps:
                lost = np.full(count, np.nan)
                return lost, lost
            return self._recorded(np.arange(steps) / playing.rate, volts, total, count)

    def facts(self) -> dict[str, Any]:
        """Return what was sent, and where the resonance is now, as JSON values."""
        return {
            "device": self.name,
            "simulated": True,
            "carrier_hz": self._carrier_hz,
            "resonance_hz": self.transducer.resonance_hz,
            "sent_samples": self.sent,
        }

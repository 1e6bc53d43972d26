"""A simulated bench: generator, transducer, shunt and converter, so that tracking can be tried as it will be done."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from tactogram.rendering.transducer.circuit import Transducer, preset
from tactogram.rendering.transducer.simulation import TransducerSimulation

Array = NDArray[np.float64]

ENVELOPE_HZ = 4000.0
"""Rate at which the circuit is solved; in between the current's amplitude goes straight."""


class BenchSettings(BaseModel):
    """Settings of the simulated bench. All of it is ours, no device's."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    rate: float = Field(default=250_000.0, gt=0)
    amplitude_v: float = Field(default=5.0, gt=0)
    """At the transducer, 0 to peak."""
    shunt_ohm: float = Field(default=10.0, gt=0)
    range_v: tuple[float, float] = (25.0, 2.5)
    """Of the converter's two channels."""
    bits: int = Field(default=14, ge=6, le=24)
    noise: float = Field(default=0.001, ge=0)
    """Of each sample, standard deviation, as a share of the channel's range."""
    skew_s: float = 0.0
    """By how much the current is taken later."""
    drift_hz_per_s: float = 0.0
    """Of the resonance, on the bench's own clock, which goes on with every measurement."""


class SimulatedBench:
    """A `Carrier` and a `Recorder` in one, over a simulated transducer; a context manager as a device is.

    Parameters
    ----------
    settings : BenchSettings
    transducer : Transducer, optional
        By default the preset ``plate``, Q 300.
    rng : numpy.random.Generator
    """

    simulated = True
    name = "simulated"

    def __init__(
        self, settings: BenchSettings, *, transducer: Transducer | None = None, rng: np.random.Generator
    ) -> None:
        self.settings, self.rate, self.full_scale = settings, settings.rate, settings.range_v
        self.clock_s = 0.0
        self._begun = transducer or preset("plate")
        self._rng = rng
        self._carrier_hz = self._begun.resonance_hz
        self._circuit = TransducerSimulation(self._begun, rate=ENVELOPE_HZ, carrier_hz=self._carrier_hz)

    @property
    def transducer(self) -> Transducer:
        """As it is now."""
        return self._begun.shifted(self.settings.drift_hz_per_s * self.clock_s)

    def retune(self, carrier_hz: float) -> None:
        """Move the carrier."""
        self._carrier_hz = carrier_hz

    def take(self, seconds: float, *, after_s: float) -> tuple[Array, Array]:
        """Return voltage over the divider and over the shunt, V, as the converter gives them."""
        s = self.settings
        count, settling = round(seconds * s.rate), round(after_s * ENVELOPE_HZ)
        self._circuit.change(transducer=self.transducer, carrier_hz=self._carrier_hz)
        steps = settling + int(seconds * ENVELOPE_HZ) + 3
        _, whole = self._circuit.process(np.full(steps, s.amplitude_v))
        self.clock_s += steps / ENVELOPE_HZ
        t = np.arange(count) / s.rate
        amplitude = np.interp(t, (np.arange(steps) - settling) / ENVELOPE_HZ, whole)
        turn = 2j * np.pi * self._carrier_hz
        voltage = (s.amplitude_v * np.exp(turn * t)).real
        current = (amplitude * np.exp(turn * (t + s.skew_s))).real * s.shunt_ohm
        return self._converted(voltage, s.range_v[0]), self._converted(current, s.range_v[1])

    def facts(self) -> dict[str, Any]:
        """Return what it is, as JSON values."""
        return {"device": self.name, "simulated": True, **self.settings.model_dump(mode="json")}

    def _converted(self, volts: Array, reach: float) -> Array:
        step = 2 * reach / 2**self.settings.bits
        noisy = volts + self.settings.noise * reach * self._rng.standard_normal(len(volts))
        return np.asarray(np.clip(np.round(noisy / step) * step, -reach, reach))

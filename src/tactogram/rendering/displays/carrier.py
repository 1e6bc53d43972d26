"""Settings of displays whose drive is a modulated carrier."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display


class CarrierSettings(BaseModel):
    """Carrier, amplifier and output, for rendering and for a generator that makes the carrier itself."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    resonant: ClassVar[bool] = False
    """Whether the carrier lies at a resonance to be tracked."""

    carrier_hz: float = Field(gt=0)
    amplifier_gain: float = Field(default=1.0, gt=0)
    """Between generator and transducer or electrode."""
    output: Literal["waveform", "envelope"] = "waveform"
    """The modulated carrier, or its amplitude alone for a generator that makes the carrier itself."""

    @property
    @abstractmethod
    def peak_v(self) -> float:
        """Largest voltage of the generator, 0 to peak."""

    def check_rate(self, rate: float, highest_hz: float) -> None:
        """Refuse a rate (Hz) too low for a waveform or envelope with components up to ``highest_hz``.

        Raises `ParameterError` if it is at or below 2.2 times the highest frequency of the output.
        """
        least = 2.2 * (highest_hz + (self.carrier_hz if self.output == "waveform" else 0))
        if not (math.isfinite(rate) and rate > least):
            raise ParameterError(
                f"{self.output} of this display needs a rate above {least:g} Hz, got {rate:g}"
            )

    def output_of(self, envelope: NDArray[np.float64], rate: float, *, first: int = 0) -> NDArray[np.float64]:
        """Return the modulated carrier, or the envelope itself, as ``output`` says; same unit and shape (time,).

        ``first`` is the number of the first sample in a stream.
        """
        if self.output == "envelope":
            return envelope
        # Reduced to one period, since a float loses the carrier's phase within hours.
        turns = (first + np.arange(len(envelope))) * (self.carrier_hz / rate) % 1.0
        return np.asarray(envelope * np.sin(2 * np.pi * turns))


def carrier_of(display: Display) -> CarrierSettings:
    """Return the carrier of a display whose generator makes it; raises `ParameterError` for others."""
    settings = display.settings
    if not isinstance(settings, CarrierSettings) or settings.output != "envelope":
        raise ParameterError(
            f"{display.name} has no carrier that a device could make: its drive must be a modulated carrier, with "
            "output = 'envelope'"
        )
    return settings

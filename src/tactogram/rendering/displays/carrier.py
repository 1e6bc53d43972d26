"""Settings of displays whose drive modulates a carrier."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field


class CarrierSettings(BaseModel):
    """Carrier, amplifier and output: what a generator must know that makes the carrier itself."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    resonant: ClassVar[bool] = False
    """Whether the carrier lies at a resonance that is to be tracked."""

    carrier_hz: float = Field(gt=0)
    amplifier_gain: float = Field(default=1.0, gt=0)
    """Between generator and transducer or electrode."""
    output: Literal["waveform", "envelope"] = "waveform"
    """The modulated carrier, or its amplitude alone for a generator that makes the carrier itself."""

    @property
    @abstractmethod
    def peak_v(self) -> float:
        """Largest voltage of the generator, 0 to peak."""

    @property
    def signed_envelope(self) -> bool:
        """Whether the envelope turns the carrier's sign."""
        return False

"""Modulated carriers: their settings, band limit, pre-emphasis for a first-order low-pass, and scaling to -1..1."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.report import percent
from tactogram.validation import FrozenModel


class CarrierSettings(FrozenModel):
    """Carrier, amplifier and output, for rendering and for a generator that makes the carrier itself."""

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


PAD_S = 0.1
"""Length by which the ends are extended while a filter rings: ten time constants of a transducer of Q 800."""


def pre_emphasis(frequency: ArrayLike, *, cutoff_hz: float, cap_db: float) -> NDArray[np.complex128]:
    """Return the inverse of a first-order low-pass at ``cutoff_hz``, its magnitude at most ``cap_db``.

    complex128, shape (bin,) as ``frequency`` in Hz; 1 at 0 Hz. The phase is inverted beyond the cap, too, so that the
    result keeps its shape in time.
    """
    inverse = 1 + 1j * np.asarray(frequency, np.float64) / cutoff_hz
    return np.asarray(inverse * np.minimum(1, 10 ** (cap_db / 20) / np.abs(inverse)))


def attained(cutoff_hz: float, *, cap_db: float | None, highest_hz: float) -> tuple[float, float]:
    """Return up to where a signal arrives flat, and where it has fallen by 3 dB, Hz; both at most ``highest_hz``.

    Without pre-emphasis (``cap_db`` None) nothing above 0 Hz is flat.
    """
    cap = 1.0 if cap_db is None else 10 ** (cap_db / 20)
    flat, half = cutoff_hz * math.sqrt(cap**2 - 1), cutoff_hz * math.sqrt(2 * cap**2 - 1)
    return min(flat, highest_hz), min(half, highest_hz)


def shaped(
    x: NDArray[np.float64],
    rate: float,
    *,
    band: tuple[float, float],
    cutoff_hz: float | None,
    cap_db: float | None,
    loop: bool,
) -> tuple[NDArray[np.float64], dict[str, Any]]:
    """Return ``x`` within the band and pre-emphasised, float64, shape (time,), and facts.

    The edges of ``band`` (Hz) are half a cosine, a tenth of the edge wide, and lie outside; a low edge above 0 removes
    the mean. ``cutoff_hz`` is that of the transducer's low-pass, None if unknown; ``cap_db`` caps the pre-emphasis,
    None for none. In a loop the end continues at the beginning; else both ends are held.
    """
    pad = 0 if loop else int(PAD_S * rate)
    padded = np.pad(x, pad, mode="edge")
    spectrum = np.fft.rfft(padded)
    f = np.asarray(np.fft.rfftfreq(len(padded), 1 / rate), np.float64)
    inside = _edges(f, band)
    power = spectrum.real**2 + spectrum.imag**2
    power[0] = 0.0  # a constant is amplitude, not signal
    whole = float(power.sum()) or 1.0
    kept = power * inside**2
    facts: dict[str, Any] = {
        "band": list(band),
        "removed_share": float((power - kept).sum()) / whole,
        "transducer": None,
    }
    response = inside.astype(np.complex128)
    if cutoff_hz is not None:
        if cap_db is not None:
            response *= pre_emphasis(f, cutoff_hz=cutoff_hz, cap_db=cap_db)
        flat, half = attained(cutoff_hz, cap_db=cap_db, highest_hz=band[1])
        facts["transducer"] = {
            "cutoff_hz": cutoff_hz,
            "pre_emphasis": cap_db is not None,
            "cap_db": cap_db,
            "flat_to_hz": flat,
            "minus_3_db_hz": half,
            "power_not_reached": float(kept[f > half].sum()) / whole if half < band[1] else 0.0,
        }
    filtered = np.asarray(np.fft.irfft(spectrum * response, len(padded)), np.float64)
    return filtered[pad : pad + len(x)], facts


def scaled_within(
    x: NDArray[np.float64], *, full_scale: float | None, share: float, remedy: str
) -> tuple[NDArray[np.float64], float]:
    """Return ``x``, float64, shape (time,), scaled to -1..1, and the value that became 1.

    That is ``full_scale``; without it the largest magnitude becomes ``share``. Raises `ParameterError` with the advice
    ``remedy`` if values exceed it.
    """
    peak = float(np.abs(x).max())
    scale = full_scale or (peak / share if peak > 0 else 1.0)
    inner = x / scale
    beyond = float(np.mean(np.abs(inner) > 1 + 1e-9))
    if beyond > 0:
        raise ParameterError(
            f"the signal over-modulates: it reaches {peak / scale:.3g} of full modulation, {percent(beyond)} of the "
            f"samples are beyond 1; {remedy}"
        )
    return np.clip(inner, -1, 1), scale


def limited(samples: NDArray[np.float64], peak: float) -> NDArray[np.float32]:
    """Return ``samples`` as float32 of which none exceeds ``peak``, not even by rounding."""
    most = np.float32(peak)
    if float(most) > peak:
        most = np.nextafter(most, np.float32(0))
    return np.asarray(np.clip(samples.astype(np.float32), -most, most), np.float32)


def _edges(f: NDArray[np.float64], band: tuple[float, float]) -> NDArray[np.float64]:
    """Return 1 within the band, 0 from a tenth of an edge outside, half a cosine in between."""
    low, high = band
    inside = 0.5 + 0.5 * np.cos(np.pi * np.clip((f - high) / (0.1 * high), 0, 1))
    if low > 0:
        inside = inside * (0.5 + 0.5 * np.cos(np.pi * np.clip((low - f) / (0.1 * low), 0, 1)))
    return np.asarray(inside)

"""Drives of a display: phases for a low crest factor (peak / rms) of a periodic signal; sensor signals at full scale.

The voltage of a drive is limited by its peak, while perception depends on the amplitudes of the lines. A low crest
factor therefore transmits more of a spectrum to the skin than random phases.

References
----------
- Van der Ouderaa, E., Schoukens, J. & Renneboog, J. (1988). Peak factor minimization using a time-frequency domain
  swapping algorithm. IEEE Trans. Instrum. Meas. 37(1), 145-147.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal

SWAPS = 200
"""Clippings. More gain little: for 1,000 equal lines from random phases (3.50), 200 reach 1.51 and 1,000 1.44."""
CLIPPED = (0.75, 0.95)
"""Level of the first and the last clipping, as a share of the peak, rising as in Van der Ouderaa et al."""


def crest_factor(x: NDArray[np.floating]) -> float:
    """Return peak over rms of ``x``, shape (time,); sqrt(2) for a sinusoid, a `ParameterError` for silence."""
    rms = float(np.sqrt(np.mean(np.square(x, dtype=np.float64))))
    if rms == 0:
        raise ParameterError("a crest factor needs a sample that is not 0, got none")
    return float(np.abs(x).max()) / rms


def periodic_signal(
    amplitudes: NDArray[np.floating], phases: NDArray[np.floating], *, length: int
) -> NDArray[np.float64]:
    """Return one period of the sum of ``a_k cos(2 pi k n / length + phase_k)``, k from 1, float64, shape (length,).

    Amplitudes and phases (radians) have shape (bin,), those of the harmonics 1, 2, …, which must lie below half the
    rate. Repeated, the signal has no seam.
    """
    spectrum = _spectrum(amplitudes, length)
    spectrum[1 : len(amplitudes) + 1] *= np.exp(1j * np.asarray(phases, np.float64))
    return _time(spectrum, length)


def random_phases(count: int, *, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return uniform phases from 0 to 2 pi, radians, shape (count,)."""
    return rng.uniform(0, 2 * np.pi, count)


def low_crest_phases(
    amplitudes: NDArray[np.floating],
    *,
    length: int,
    rng: np.random.Generator,
    swaps: int = SWAPS,
) -> NDArray[np.float64]:
    """Return phases of a low crest factor, radians, shape (bin,).

    Van der Ouderaa et al. 1988, from random phases: clip, keep the new phases, restore the amplitudes, repeat; the best
    round is returned. The amplitudes, shape (bin,), are those of the harmonics 1, 2, … of a period of ``length``
    samples.
    """
    count = len(amplitudes)
    phases = random_phases(count, rng=rng)
    level = _spectrum(amplitudes, length)
    if not level.any():
        return phases
    inside = slice(1, count + 1)
    best, least = phases, np.inf
    for clipped in np.linspace(*CLIPPED, swaps + 1):
        spectrum = level.copy()
        spectrum[inside] *= np.exp(1j * phases)
        x = _time(spectrum, length)
        peak = np.abs(x).max()
        if peak < least:
            best, least = phases, peak
        limit = clipped * peak
        phases = np.angle(np.fft.rfft(np.clip(x, -limit, limit))[inside])
    return best


def _spectrum(amplitudes: NDArray[np.floating], length: int) -> NDArray[np.complex128]:
    """Return the ``rfft`` of one period of cosines of ``amplitudes``."""
    if 2 * len(amplitudes) >= length:
        raise ParameterError.must(
            "harmonics",
            f"lie below half the rate: at most {(length - 1) // 2} of {length} samples",
            len(amplitudes),
        )
    spectrum = np.zeros(length // 2 + 1, np.complex128)
    spectrum[1 : len(amplitudes) + 1] = np.asarray(amplitudes, np.float64) * (length / 2)
    return spectrum


def _time(spectrum: NDArray[np.complex128], length: int) -> NDArray[np.float64]:
    x: NDArray[np.float64] = np.fft.irfft(spectrum, length)
    return x


def straight_to_display(
    signal: Signal, *, rate: float, axes: tuple[str, ...], seconds: float = 1.0
) -> Signal:
    """Return the middle of a sensor's signal, standardised and scaled to a display's full scale.

    The rule: the first axis alone; its middle ``seconds``; mean 0 and variance 1 (Hatori & Takemura 2023, Sec. III-B);
    the display's rate (Hz); then divided by its largest magnitude, which becomes 1; the same samples on each of
    ``axes``. This loses the strength, which in volts of a strain gauge means nothing to a display. The publication does
    not state its scale (Sec. V-A). A constant signal becomes 0 throughout.
    """
    length = round(seconds * signal.rate)
    if length > len(signal):
        raise ParameterError(
            f"a display's signal of {seconds:g} s needs as much of a sensor's, got {signal.seconds:g} s"
        )
    start = (len(signal) - length) // 2
    x = signal.samples[0, start : start + length].astype(np.float64)
    spread = x.std()
    standard = (x - x.mean()) / spread if spread > 0 else np.zeros_like(x)
    mono = Signal(standard.astype(np.float32), signal.rate, "1", axes[:1])
    if mono.rate != rate:
        mono = resample(mono, rate)
    peak = float(np.abs(mono.samples).max())
    scaled = mono.samples / peak if peak > 0 else mono.samples
    return Signal(np.repeat(scaled, len(axes), axis=0), rate, "1", axes)

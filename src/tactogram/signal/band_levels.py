"""Band matching: generated signals get the band levels of recordings, and their spread.

After the training, the envelopes of a signal's bands are mapped so that their distribution is that of the recordings,
as Heeger & Bergen (1995) do with the subbands of pictures. Long-term spectrum and level are then correct, a tone is as
steady as in recordings, and a rattle as uneven. When it is strong or weak remains the networks' choice.

References
----------
- Heeger, D. J. & Bergen, J. R. (1995). Pyramid-based texture analysis/synthesis. Proc. SIGGRAPH, 229-238. doi
  10.1145/218380.218446
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import oaconvolve

Array = NDArray[np.float64]
LOWEST_HZ = 16.0
"""Centre of the lowest band; slower content is unchanged."""
PER_OCTAVE = 2
REACH_S = 0.25
"""Length of the bands' filters to either side."""
LEVELS = np.array([0.5, 1, 2, 5, 10, 20, 30, 40, 50, 60, 70, 80, 90, 95, 98, 99, 99.5]) / 100
"""Quantiles that represent a distribution."""
FAINTEST = 1e-6
"""Lowest envelope, as a share of the band's rms."""
PORTION = 1 << 16
"""Samples that are filtered at once, which bounds the memory."""


class BandLevels:
    """Distributions of band envelopes, recorded and generated, by material.

    Attributes
    ----------
    recorded, generated : float64 arrays, shape (material, axis, band, quantile)
        Natural logarithms of amplitudes, ascending along the last; no materials before they are measured.
    """

    def __init__(self, rate: float) -> None:
        self.reach = round(REACH_S * rate)
        self.filters = band_filters(rate, self.reach)
        self.recorded = self.generated = np.zeros((0, 0, len(self.filters), len(LEVELS)))

    @property
    def measured(self) -> bool:
        """Whether there is something to match."""
        return len(self.recorded) > 0

    def correction_db(self) -> float:
        """Return the shift of the medians, rms over materials, axes and bands, dB."""
        moved = (self.recorded - self.generated)[..., len(LEVELS) // 2]
        return float(20 / math.log(10) * np.sqrt(np.mean(moved**2))) if moved.size else 0.0

    def measure(self, materials: Iterable[tuple[Sequence[NDArray[Any]], Sequence[NDArray[Any]]]]) -> None:
        """Measure the distributions of each material's recorded and generated signals, arrays of shape (axis, time).

        The pairs are consumed one material at a time.
        """
        tables = [(self.quantiles(recorded), self.quantiles(generated)) for recorded, generated in materials]
        self.recorded, self.generated = (np.array(table) for table in zip(*tables, strict=True))

    def quantiles(self, signals: Sequence[NDArray[Any]]) -> Array:
        """Return quantiles of the logarithm of band envelopes: float64, (axis, band, quantile).

        Spread is within a signal, level of all: each band of each signal counts relative to its own rms, and the
        distribution is centred on the geometric mean of the rms. ``signals``, at least one, have shape (axis, time) and
        are longer than the filters.
        """
        envelopes = [np.abs(self._split(x)) for x in signals]
        power = np.array([np.square(each).mean(2) for each in envelopes])  # signal, A, B
        own = np.sqrt(np.maximum(power, np.finfo(np.float32).tiny))
        every = np.concatenate([e / rms[..., None] for e, rms in zip(envelopes, own, strict=True)], 2)
        relative = np.quantile(np.log(np.maximum(every, FAINTEST)), LEVELS, axis=2)  # Q, A, B
        level = np.log(own).mean(0)
        return np.moveaxis(relative + level, 0, 2)

    def apply(self, x: NDArray[Any], weights: Array) -> Array:
        """Return samples with the envelopes of their bands mapped: (axis, time) -> (axis, time - 2 reach).

        Between materials both distributions are mixed, in dB.
        """
        share = weights / weights.sum()
        generated, recorded = (np.tensordot(share, table, 1) for table in (self.generated, self.recorded))
        result = x[:, self.reach : x.shape[1] - self.reach].astype(np.float64)
        for start in range(0, result.shape[1], PORTION):
            part = result[:, start : start + PORTION]
            bands = self._split(x[:, start : start + part.shape[1] + 2 * self.reach])
            strength = np.log(np.maximum(np.abs(bands), np.finfo(np.float64).tiny))
            for axis, band in np.ndindex(strength.shape[:2]):
                have, want = generated[axis, band], recorded[axis, band]
                gain = np.interp(strength[axis, band], have, want - have)
                part[axis] += np.expm1(gain) * bands[axis, band].real
        return result

    def _split(self, x: NDArray[Any]) -> NDArray[np.complex128]:
        """Return the analytic bands of (axis, time) samples: (axis, band, time - 2 reach)."""
        split: NDArray[np.complex128] = oaconvolve(
            x[:, None].astype(np.float64), self.filters[None], "valid", axes=2
        )
        return split

    def state(self) -> dict[str, Any]:
        """Return the distributions."""
        return {"recorded": self.recorded, "generated": self.generated}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore the distributions of `state`."""
        self.recorded, self.generated = (
            np.asarray(state[name], np.float64) for name in ("recorded", "generated")
        )


def band_filters(rate: float, reach: int) -> NDArray[np.complex128]:
    """Return half-octave filters from `LOWEST_HZ` to half the rate, (band, 2 reach + 1), of analytic responses.

    Neighbours cross over as the squares of sine and cosine. A constant passes none.
    """
    count = max(0, math.floor(PER_OCTAVE * math.log2(rate / 2 / LOWEST_HZ)) + 1)
    size = 4 * reach
    frequency = np.fft.fftfreq(size, 1 / rate)
    position = PER_OCTAVE * np.log2(np.maximum(frequency, LOWEST_HZ / 1e3) / LOWEST_HZ)
    window = np.hanning(2 * reach + 3)[1:-1]
    filters = np.zeros((count, 2 * reach + 1), np.complex128)
    for band in range(count):
        off = position - band
        gain = np.where(np.abs(off) < 1, np.cos(np.pi / 2 * off) ** 2, 0.0)
        if band == count - 1:
            gain = np.where(off > 0, 1.0, gain)
        taps = np.fft.fftshift(np.fft.ifft(np.where(frequency > 0, 2 * gain, 0.0)))
        taps = taps[size // 2 - reach : size // 2 + reach + 1] * window
        filters[band] = taps - window * (taps.sum() / window.sum())
    return filters

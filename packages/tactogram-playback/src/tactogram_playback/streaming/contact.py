"""Contact transients of a landing finger, without delay.

A delay is noticed at 40 to 60 ms while stroking but at 5.5 ms while tapping, so a tap is neither smoothed nor ramped
and starts with the first sample of the next block: a decaying sine whose amplitude depends on the force of the landing
and whose frequency and decay are the material's (Okamura, Dennerlein & Howe 1998; Okamura et al. 2001).

References
----------
- Okamura, A. M., Dennerlein, J. T. & Howe, R. D. (1998). Vibration feedback models for virtual environments. Proc.
  IEEE ICRA, 674-679. doi 10.1109/ROBOT.1998.677050
- Okamura, A. M., Cutkosky, M. R. & Dennerlein, J. T. (2001). Reality-based models for vibration feedback in virtual
  environments. IEEE/ASME Trans. Mechatronics 6(3), 245-252. doi 10.1109/3516.951362
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

AT_ONCE = 8
"""Most simultaneous transients; a further one replaces the quietest."""
OVER = 1e-4
"""Share of its initial amplitude at which a transient ends: -80 dB."""


@dataclass(frozen=True)
class ContactSettings:
    """Transient of a landing. The defaults are our choice.

    The frequency lies between the published ones of rubber and of metal; ``decay_s`` is the time constant; ``gain``
    the first peak at a landing of 1 N, as a multiple of the texture's root mean square; forces above ``hardest_n``
    count as that.
    """

    frequency_hz: float = 160.0
    decay_s: float = 0.012
    gain: float = 4.0
    hardest_n: float = 3.0


class ActiveTransients:
    """The transients that are playing."""

    def __init__(self, settings: ContactSettings, rate: float) -> None:
        self.settings = settings
        self.started = 0
        self._turn = 2 * math.pi * settings.frequency_hz / rate
        self._keep = math.exp(-1 / (settings.decay_s * rate))
        # Decay until the sine's first peak, after a quarter of a period.
        self._peak = math.exp(-0.25 / (settings.frequency_hz * settings.decay_s))
        self._amplitude = np.zeros(AT_ONCE)
        self._phase = np.zeros(AT_ONCE)
        self._end = np.zeros(AT_ONCE)

    def start(self, strength_n: float, level: float) -> None:
        """Start a transient with the next sample: a landing of ``strength_n`` N on a texture of rms ``level``."""
        amplitude = self.settings.gain * level * min(max(strength_n, 0.0), self.settings.hardest_n)
        if amplitude == 0:
            return
        quietest = int(np.argmin(self._amplitude))
        self._amplitude[quietest] = amplitude / self._peak
        self._end[quietest] = OVER * amplitude
        self._phase[quietest] = 0.0
        self.started += 1

    def add(self, out: NDArray[np.float32], count: int) -> None:
        """Add the next ``count`` samples to every axis of ``out``, shape (axis, most)."""
        if self._amplitude.any():
            _add(self._amplitude, self._phase, self._end, self._turn, self._keep, count, out)


@numba.njit(cache=True, nogil=True)
def _add(
    amplitude: NDArray[np.float64],
    phase: NDArray[np.float64],
    end: NDArray[np.float64],
    turn: float,
    decay: float,
    count: int,
    out: NDArray[np.float32],
) -> None:
    for k in range(len(amplitude)):
        if amplitude[k] == 0:
            continue
        for i in range(count):
            value = amplitude[k] * math.sin(phase[k])
            for a in range(len(out)):
                out[a, i] += value
            phase[k] += turn
            amplitude[k] *= decay
        if amplitude[k] < end[k]:
            amplitude[k] = 0.0

"""Guard between a stream of drive blocks and a device: limits, fades and rest, block by block."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering import Display, bounds

HIGHPASS_HZ = 5.0


class DriveGuard:
    """Guard between a stream of drive blocks and a device: the guarantees of `tactogram.rendering.safe`.

    A block with NaN or infinity is a fault: it and everything after it is replaced by a fade to rest, until `reset`.
    ``missing`` returns blocks for a lost connection: a fade to rest, then rest; the next block fades in. No block
    leaves the limits, and none begins with a jump from the last sample beyond what the fade allows. If DC is forbidden,
    a first-order high-pass at `HIGHPASS_HZ` removes it.
    """

    def __init__(self, display: Display) -> None:
        self.display = display
        self.fault: str | None = None
        self._low, self._high = bounds(display)
        self._step = 1 / max(1.0, display.fade_ms / 1e3 * display.rate)
        self._pole = 0.0 if display.dc else float(np.exp(-2 * np.pi * HIGHPASS_HZ / display.rate))
        self._filter = scipy.signal.lfilter  # imported here, not in the first block of a device's callback
        self.reset()

    def reset(self) -> None:
        """Start again at rest: the next block fades in."""
        count = len(self.display.channels)
        self.fault = None
        self._gain = 0.0
        self._held = np.full((count, 1), self.display.rest)
        self._state = np.zeros((count, 1))

    def process(self, block: NDArray[np.floating]) -> NDArray[np.float32]:
        """Return the block to send, float32, shape (channel, time) as ``block``, in the display's unit.

        Raises `ParameterError` if ``block`` has another shape. NaN and infinity are no errors but fade to rest, see
        ``fault``.
        """
        if block.ndim != 2 or len(block) != len(self.display.channels):
            raise ParameterError.must("block", f"be ({len(self.display.channels)}, time)", block.shape)
        if self.fault is None and not np.isfinite(block).all():
            self.fault = "a block contains NaN or infinity"
        if self.fault is not None:
            return self.missing(block.shape[1])
        return self._sent(np.clip(block.astype(np.float64), self._low, self._high), to=1.0)

    def missing(self, length: int) -> NDArray[np.float32]:
        """Return a fade from the last sample to rest, for the time without blocks, shape (channel, time)."""
        return self._sent(np.repeat(self._held, length, axis=1), to=0.0)

    def leaving(self, block: NDArray[np.floating]) -> NDArray[np.float32]:
        """Return a block, shape (channel, time), faded to rest: for a drive that continues without motion."""
        if self.fault is not None or block.ndim != 2 or not np.isfinite(block).all():
            return self.missing(block.shape[-1])
        return self._sent(np.clip(block.astype(np.float64), self._low, self._high), to=0.0)

    def _sent(self, x: NDArray[np.float64], *, to: float) -> NDArray[np.float32]:
        count = x.shape[1]
        if count == 0:
            return np.zeros(x.shape, np.float32)
        steps = self._step * np.arange(1, count + 1)
        gain = np.clip(self._gain + np.sign(to - self._gain) * steps, 0.0, 1.0)
        self._gain = float(gain[-1])
        self._held = x[:, -1:]
        if self._pole:
            x, self._state = self._filter([1.0, -1.0], [1.0, -self._pole], x, axis=1, zi=self._state)
        rest = self.display.rest
        y = rest + (x - rest) * np.sin(np.pi / 2 * gain) ** 2
        sent: NDArray[np.float32] = np.clip(y.astype(np.float32), self._low, self._high)
        return sent

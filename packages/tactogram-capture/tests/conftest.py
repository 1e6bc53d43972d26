"""A simulated source that delivers as fast as it is read."""

import numpy as np
import pytest

from tactogram_capture.source import Block, SourceEnded, SourceLost


class Played:
    """Noise with gravity at 330 Hz in blocks of ten; packets in ``lost`` are NaN."""

    name, axes, unit = "played:test", ("x", "y", "z"), "m/s^2"

    def __init__(self, *, seed=0, rate=330.0, measured=None, lost=(), scale=1.0, packets=10**9, end="ended"):
        self.rate, self._measured, self._lost, self._scale = rate, measured, frozenset(lost), scale
        self._rng, self._packets, self._end = np.random.default_rng(seed), packets, end
        self.packet = self.missing = 0
        self.played = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def read(self, timeout_s=0.1):
        if self.packet >= self._packets:
            raise (SourceEnded if self._end == "ended" else SourceLost)(f"{self.name}: {self._end}")
        samples = (self._scale * self._rng.standard_normal((3, 10)) + [[0], [0], [9.81]]).astype(np.float32)
        if self.packet in self._lost:
            samples[:] = np.nan
            self.missing += 10
        self.played.append(samples)
        block = Block(samples, 10 * self.packet, 0.03 * self.packet)
        self.packet += 1
        return block

    def facts(self):
        rate = self._measured and {"hz": self._measured, "low": self._measured, "high": self._measured}
        came = 10 * self.packet - self.missing
        return {"samples": came, "lost": self.missing, "rejected": {}, "rate": rate, "simulated": True}


@pytest.fixture(scope="session")
def played():
    return Played

"""Engine: motion in, blocks of samples out.

One call of `Engine.render` makes one block: it reads the motion that has arrived, follows the finger sample by sample
(`finger_path`), lets every texture write its samples, adds them by their weights and adds the transients of landings.
All arrays are allocated at the start. The result depends on how time is cut into blocks only through when motion is
read.

Textures are uncorrelated, so vibrations are added by the square roots of their weights: the power of a mix is the
weighted mean of their powers. Friction coefficients, felt by their means, are added by the weights themselves. Changes
of weights are gradual.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numba
import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering import (
    FINGER_STATES,
    FingerState,
    FingerTracker,
    MixWeights,
    MotionSample,
    MotionSettings,
    MotionSource,
    Tap,
)
from tactogram_playback.streaming.contact import ActiveTransients, ContactSettings
from tactogram_playback.streaming.textures import StreamingTexture
from tactogram_playback.streaming.timing import BlockClock, Latency

Block = NDArray[np.float32]

LONGEST_BLOCK_S = 0.005
LEAST_RATE = 1000.0
"""Rate of the slowest display that streams, the string tablet, Hz: ramps of landings still have three samples."""
GLIDE_S = 0.05
"""Duration of a change of weights, s."""


class Engine:
    """Textures of one unit and number of axes under a finger, in blocks of at most ``most`` samples at ``rate`` (Hz).

    The textures must be made for the same rate and block. ``weights`` are by texture name, 0 for those omitted; equal
    weights of sum 1 by default. ``settings`` smooth the motion, ``contact`` describes the transients of landings.
    Raises `ParameterError` if textures differ in kind or share a name, or rate, block or a weight is out of range.
    """

    def __init__(
        self,
        textures: Sequence[StreamingTexture],
        motion: MotionSource,
        *,
        rate: float,
        most: int,
        weights: Mapping[str, float] | None = None,
        settings: MotionSettings | None = None,
        contact: ContactSettings | None = None,
    ) -> None:
        if not textures:
            raise ParameterError("a stream needs at least one texture, got none")
        if rate < LEAST_RATE:
            raise ParameterError.must("rate", f"be at least {LEAST_RATE:g} Hz", rate)
        if not 1 <= most <= LONGEST_BLOCK_S * rate + 1e-9:
            raise ParameterError(
                f"a block must have 1 to {int(LONGEST_BLOCK_S * rate)} samples at {rate:g} Hz, got {most}"
            )
        self.textures = tuple(textures)
        self.rate, self.most = float(rate), most
        self.unit, self.axes = _kind(self.textures)
        self.names = tuple(texture.name for texture in self.textures)
        self.motion = motion
        self.finger = FingerState(settings or MotionSettings())
        self.tracker = FingerTracker(rate, most)
        self._clock = BlockClock()
        self.transients = ActiveTransients(contact or ContactSettings(), rate)
        self.latency = Latency(most / rate)
        self.blocks = dict.fromkeys(FINGER_STATES, 0)
        """Number of blocks that began in each state."""
        count = len(self.textures)
        self._target = np.full(count, 1 / count) if weights is None else np.zeros(count)
        if weights is not None:
            self.set_weights(weights)
        self._weights = self._target.copy()
        self._gains = np.array([self._gain(i) for i in range(count)])
        self._out: Block = np.zeros((len(self.axes), most), np.float32)
        self._one: Block = np.zeros((len(self.axes), most), np.float32)

    @property
    def weights(self) -> dict[str, float]:
        """The current weights by texture name."""
        return dict(zip(self.names, self._weights.tolist(), strict=True))

    @property
    def delay_s(self) -> float:
        """Delay of the slowest texture in use, s."""
        return max(
            (t.delay_s for t, w in zip(self.textures, self._target, strict=True) if w > 0), default=0.0
        )

    def set_weights(self, weights: Mapping[str, float]) -> None:
        """Change weights gradually from the next block on; those omitted stay.

        Raises `ParameterError` if a name is unknown or a weight is negative or not finite.
        """
        for name, weight in weights.items():
            if name not in self.names:
                raise ParameterError.one_of("mix", self.names, name)
            if not (weight >= 0 and math.isfinite(weight)):
                raise ParameterError.must("mix", f"give {name} a weight >= 0 and finite", weight)
        for name, weight in weights.items():
            self._target[self.names.index(name)] = weight

    def render(self, now_s: float, count: int | None = None, *, ahead_s: float = 0.0) -> Block:
        """Return the next ``count`` (by default ``most``) samples, float32, shape (axis, count), in ``unit``.

        The array is a view that the next call overwrites. Motion that has arrived by ``now_s`` (on the engine's clock)
        is read. ``ahead_s`` is the delay of the first sample after now, for a backend that requests several blocks at
        once. Irregular start times are made regular by `timing.BlockClock`.
        """
        count = self.most if count is None else count
        for message in self.motion.poll(now_s):
            if isinstance(message, MotionSample):
                self.finger.update(message, now_s)
            elif isinstance(message, Tap):
                self._land(message.strength, now_s - message.arrival_s)
            else:
                self._change(message)
        start = self._clock.start_of(now_s + ahead_s, count / self.rate)
        motion = self.tracker.follow(self.finger, now_s, count, ahead_s=start - now_s)
        self.blocks[self.tracker.state] += 1
        if self.finger.landing_n > 0:
            self._land(self.finger.landing_n, now_s - self.finger.force_s)
            self.finger.landing_n = 0.0
        out, block = self._out, self._one
        out[:, :count] = 0.0
        step = min(1.0, count / (GLIDE_S * self.rate))
        for i, texture in enumerate(self.textures):
            before = self._gains[i]
            self._weights[i] += max(-step, min(step, self._target[i] - self._weights[i]))
            self._gains[i] = self._gain(i)
            if before == 0.0 and self._gains[i] == 0.0:
                continue
            texture.render(motion, block)
            _add(
                block,
                before,
                self._gains[i],
                motion.contact,
                motion.movement,
                texture.holds_at_rest,
                count,
                out,
            )
        self.transients.add(out, count)
        return out[:, :count]

    def warm_up(self) -> None:
        """Compile everything a block needs, so that the first block is as fast as the others."""
        block = self.tracker.follow(FingerState(), 0.0, 1)
        for texture in self.textures:
            texture.render(block, self._one)
        _add(self._one, 0.0, 0.0, block.contact, block.movement, True, 1, self._out)
        probe = ActiveTransients(self.transients.settings, self.rate)
        probe.start(1.0, 1.0)
        probe.add(self._one, 1)

    def facts(self) -> dict[str, Any]:
        """Return statistics of the stream so far, as JSON values."""
        blocks = sum(self.blocks.values())
        return {
            "rate_hz": self.rate,
            "block_samples": self.most,
            "unit": self.unit,
            "textures": list(self.names),
            "weights": self.weights,
            "texture_delay_ms": 1e3 * self.delay_s,
            "motion": {
                "from": self.motion.name,
                "simulated": self.motion.simulated,
                **asdict(self.finger.counts),
            },
            "states": {name: self.blocks[name] / blocks if blocks else 0.0 for name in FINGER_STATES},
            "landings": self.transients.started,
            "latency": self.latency.facts(),
        }

    def _gain(self, index: int) -> float:
        weight = float(self._weights[index])
        return weight if self.textures[index].holds_at_rest else math.sqrt(weight)

    def _land(self, strength: float, age_s: float) -> None:
        if strength >= 0:  # not NaN
            levels = [t.level * t.level for t in self.textures]
            self.transients.start(strength, math.sqrt(float(np.dot(self._weights, levels))))
            self.latency.tap.add(max(age_s, 0.0) + self.most / self.rate)

    def _change(self, message: MixWeights) -> None:
        """Apply weights that arrived with the motion; invalid ones are counted."""
        try:
            self.set_weights(message.weights)
        except ParameterError:
            self.finger.counts.invalid += 1


def _kind(textures: Sequence[StreamingTexture]) -> tuple[str, tuple[str, ...]]:
    first = textures[0]
    names = [texture.name for texture in textures]
    if len(set(names)) < len(names):
        raise ParameterError.must("textures", "have different names", ", ".join(names))
    for texture in textures:
        if texture.unit != first.unit or len(texture.axes) != len(first.axes):
            raise ParameterError(
                f"textures of a mix must have one unit and number of axes: {first.name} has {first.unit} and "
                f"{len(first.axes)}, {texture.name} has {texture.unit} and {len(texture.axes)}"
            )
    return first.unit, first.axes


@numba.njit(cache=True, nogil=True)
def _add(
    block: Block,
    before: float,
    after: float,
    contact: Block,
    movement: Block,
    holds: bool,
    count: int,
    out: Block,
) -> None:
    for i in range(count):
        gain = (before + (after - before) * (i + 1) / count) * contact[i]
        if not holds:
            gain *= movement[i]
        for a in range(len(out)):
            out[a, i] += gain * block[a, i]

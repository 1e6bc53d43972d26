"""Finger motion from samples that come late, at any rate, and with losses.

Position, speed and force each come at their own rate. What is used is the newest of each; what comes too late is
dropped and counted, never queued: an old position rendered now is felt as a delay from then on.

The sender's clock is not ours. Its offset is taken as the least difference between arrival and time stamp seen so far
(the quickest way a sample took), let rise by `DRIFT` so that a slow clock is followed. A game's clock may stand still
while it loads, and be late for good: where everything has been late for `RESTART_S`, the offset is taken anew.

Velocity comes from positions through the fading-memory filter of first order (Brookner 1998, Sec. 3.2): the straight
line that fits all past positions best, their weight halving with age. It is causal, needs no even rate, and has no
lag at a constant speed.

References
----------
- Brookner, E. (1998). Tracking and Kalman Filtering Made Easy. Wiley. Sec. 1.2.6 and 3.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Protocol

from tactogram.errors import ParameterError

DRIFT = 2e-4
"""By how much the sender's clock may run slow against ours, s/s."""
RESTART_S = 1.0
"""A time stamp so much before the last one is a sender that began anew, s; so long nothing but late samples is a
clock that stood still."""
FASTEST_MM_S, FARTHEST_MM = 1e4, 1e6
"""No finger is faster or farther away; one damaged number would otherwise take the way gone beyond what a float counts
in."""
NAN = math.nan


@dataclass(frozen=True, slots=True)
class MotionSample:
    """One message about the finger; what it does not say is NaN.

    Parameters
    ----------
    time_s : float
        When it was so, s on the sender's clock.
    arrival_s : float
        When it came, s on the engine's clock.
    x_mm, y_mm : float
        Position on the surface, mm. Both or none.
    speed_mm_s : float
        Magnitude of the velocity, >= 0, mm/s.
    force_n : float
        Normal force, >= 0, N. 0 is a lifted finger.
    """

    time_s: float
    arrival_s: float
    x_mm: float = NAN
    y_mm: float = NAN
    speed_mm_s: float = NAN
    force_n: float = NAN


class MotionSource(Protocol):
    """Source of motion: a file, a network port, a mouse, a simulated hand."""

    name: str
    simulated: bool

    def poll(self, now_s: float) -> Iterable[MotionSample | Tap | MixWeights]:
        """Return what has come until ``now_s`` on the engine's clock since the last call; never waits."""
        ...

    def close(self) -> None:
        """Let go of ports and threads; never raises."""
        ...


@dataclass(frozen=True, slots=True)
class Tap:
    """A touch-down that starts a transient at once, on a path of its own.

    Parameters
    ----------
    arrival_s : float
        When it came, s on the engine's clock.
    strength : float
        1 is a touch of 1 N.
    """

    arrival_s: float
    strength: float


@dataclass(frozen=True, slots=True)
class MixWeights:
    """A mix that is asked for while playing: weights by the name of a texture; the others stay."""

    weights: dict[str, float]


@dataclass(frozen=True)
class MotionSettings:
    """Smoothing and expiry of motion.

    Parameters
    ----------
    smoothing_s : float
        Time constant of the velocity from positions, s; at least 1.5 intervals between positions are used.
    late_s : float
        A sample that is older than this when it could be used is dropped, s.
    lost_s : float
        Without motion for so long the connection counts as lost and the output goes to rest, s.
    contact_on_n, contact_off_n : float
        The finger touches above the first force and is lifted below the second, N.
    rest_mm_s, moving_mm_s : float
        Below the first speed it rests, above the second it slides; in between both fade, mm/s.
    jump_mm : float
        A position so far from where it was expected is another place, not a stroke, mm.
    """

    smoothing_s: float = 0.01
    late_s: float = 0.03
    lost_s: float = 0.1
    contact_on_n: float = 0.05
    contact_off_n: float = 0.02
    rest_mm_s: float = 1.0
    moving_mm_s: float = 6.0
    jump_mm: float = 20.0

    def __post_init__(self) -> None:
        for name in ("smoothing_s", "late_s", "lost_s", "jump_mm"):
            if not (getattr(self, name) > 0 and math.isfinite(getattr(self, name))):
                raise ParameterError(f"{name} must be > 0 and finite, got {getattr(self, name)}")
        if not 0 <= self.contact_off_n <= self.contact_on_n:
            raise ParameterError(
                f"contact_off_n must be within 0 to contact_on_n, got {self.contact_off_n} and {self.contact_on_n}"
            )
        if not 0 <= self.rest_mm_s < self.moving_mm_s:
            raise ParameterError(
                f"rest_mm_s must be >= 0 and below moving_mm_s, got {self.rest_mm_s} and {self.moving_mm_s}"
            )


@dataclass
class MotionCounts:
    """Counts of received, late and rejected samples."""

    used: int = 0
    late: int = 0
    out_of_order: int = 0
    invalid: int = 0
    clocks_set: int = 0
    """How often the sender's clock was found anew after the first time."""
    lost_connections: int = 0

    @property
    def dropped(self) -> int:
        """How many were not used."""
        return self.late + self.out_of_order + self.invalid


@dataclass
class FingerState:
    """State of the finger. Positions in mm, velocities in mm/s, times in s on the engine's clock.

    Follow it with `update` for each sample and `at` at the beginning of each block.
    """

    settings: MotionSettings = field(default_factory=MotionSettings)
    counts: MotionCounts = field(default_factory=MotionCounts)
    x: float = 0.0
    y: float = 0.0
    vx: float = 0.0
    vy: float = 0.0
    position_s: float = -math.inf
    """When the newest position was so; -inf while there is none."""
    speed: float = NAN
    speed_s: float = -math.inf
    force: float = NAN
    force_s: float = -math.inf
    heard_s: float = -math.inf
    """When the newest used sample was so."""
    touching: bool = False
    landed_n: float = 0.0
    """Force at a landing that no block has taken up yet, N; 0 is none."""
    jumped: bool = False
    """Whether the newest position is another place; a block that has gone there resets it."""
    interval_s: float = 0.0
    """Mean time between positions, s."""
    _positions: int = 0
    _offset: float = math.inf
    _offset_s: float = 0.0
    _last: float = -math.inf
    _late_from: float = math.inf
    """When the first of the samples came that were all late until now; inf while they are not."""
    _late_least: float = math.inf
    """The least difference between arrival and time stamp among them, s."""
    _connected: bool = False

    def update(self, sample: MotionSample, now_s: float) -> bool:
        """Take up a sample; return whether it was used."""
        if not _is_valid(sample):
            self.counts.invalid += 1
            return False
        if sample.time_s <= self._last:
            if sample.time_s > self._last - RESTART_S:
                self.counts.out_of_order += 1
                return False
            self._set_clock(math.inf)
        self._last = sample.time_s
        seen = sample.arrival_s - sample.time_s
        allowed = self._offset + DRIFT * max(0.0, sample.arrival_s - self._offset_s)
        if seen < allowed:
            self._offset = seen
        elif self._offset < math.inf:
            self._offset = allowed
        self._offset_s = sample.arrival_s
        at = sample.time_s + self._offset
        if now_s - at > self.settings.late_s and self._is_late(sample, now_s):
            self.counts.late += 1
            return False
        at = sample.time_s + self._offset
        self._late_from = self._late_least = math.inf
        self.counts.used += 1
        self.heard_s = max(self.heard_s, at)
        self._connected = True
        if sample.x_mm == sample.x_mm:
            self._hear_position(sample.x_mm, sample.y_mm, at)
        if sample.speed_mm_s == sample.speed_mm_s:
            self.speed, self.speed_s = sample.speed_mm_s, at
        if sample.force_n == sample.force_n:
            self.force, self.force_s = sample.force_n, at
        self._touch()
        return True

    def _is_late(self, sample: MotionSample, now_s: float) -> bool:
        """Tell whether a late sample is that, or the sender's clock has stood still before those that came last."""
        self._late_from = min(self._late_from, sample.arrival_s)
        self._late_least = min(self._late_least, sample.arrival_s - sample.time_s)
        if sample.arrival_s - self._late_from < RESTART_S or self._late_least <= self._offset:
            return True
        self._set_clock(self._late_least)
        return now_s - (sample.time_s + self._offset) > self.settings.late_s

    def _set_clock(self, offset: float) -> None:
        self._offset = offset
        self._late_from = self._late_least = math.inf
        self.counts.clocks_set += 1

    def age(self, now_s: float) -> float:
        """Return how old the newest sample is, s."""
        return now_s - self.heard_s

    def lost(self, now_s: float) -> bool:
        """Tell whether nothing has come for too long; counts each time that it begins."""
        if self.age(now_s) <= self.settings.lost_s:
            return False
        if self._connected:
            self._connected = False
            self.counts.lost_connections += 1
            self.touching = False
            self.vx = self.vy = 0.0
            self.speed = NAN
            self.jumped = True
        return True

    def velocity(self, now_s: float) -> tuple[float, float]:
        """Return the velocity, mm/s: of the asked speed where one comes, in the direction of the positions."""
        lost_s = self.settings.lost_s
        vx, vy = (self.vx, self.vy) if now_s - self.position_s <= lost_s else (0.0, 0.0)
        if self.speed == self.speed and now_s - self.speed_s <= lost_s:
            size = math.hypot(vx, vy)
            if size > 1e-3:
                return vx / size * self.speed, vy / size * self.speed
            return self.speed, 0.0
        return vx, vy

    def place(self, now_s: float, ahead_s: float = 0.0) -> tuple[float, float] | None:
        """Return where the finger is ``ahead_s`` after now if it goes on as it went, mm; None if no position comes."""
        age = now_s - self.position_s
        if age > self.settings.lost_s:
            return None
        vx, vy = self.velocity(now_s)
        ahead = min(max(age, 0.0), self.settings.late_s + self.interval_s) + ahead_s
        return self.x + vx * ahead, self.y + vy * ahead

    def _hear_position(self, x: float, y: float, at: float) -> None:
        step = at - self.position_s
        if step <= 0:
            return
        self.position_s = at
        if not step < self.settings.lost_s:
            far = math.hypot(x - self.x, y - self.y) > self.settings.jump_mm
            self.jumped = self.jumped or far or math.isinf(step)
            self._begin_at(x, y)
            return
        self.interval_s = step if self.interval_s == 0 else 0.9 * self.interval_s + 0.1 * step
        keep = math.exp(-step / max(self.settings.smoothing_s, 1.5 * self.interval_s))
        missed_x, missed_y = x - self.x - self.vx * step, y - self.y - self.vy * step
        if math.hypot(missed_x, missed_y) > self.settings.jump_mm:
            self.jumped = True
            self._begin_at(x, y)
            return
        # A line through the few positions there are, until the fading memory is shorter than they last.
        n = self._positions
        self._positions += 1
        gain = max(1 - keep * keep, 2 * (2 * n + 1) / ((n + 1) * (n + 2)))
        slope = max((1 - keep) * (1 - keep), 6 / ((n + 1) * (n + 2))) / step
        self.x += self.vx * step + gain * missed_x
        self.y += self.vy * step + gain * missed_y
        self.vx += slope * missed_x
        self.vy += slope * missed_y

    def _begin_at(self, x: float, y: float) -> None:
        self.x, self.y, self.vx, self.vy = x, y, 0.0, 0.0
        self._positions = 1

    def _touch(self) -> None:
        """Decide on contact, by force where one comes, else by motion coming at all."""
        if self.force != self.force:
            self.touching = True
        elif self.touching:
            self.touching = self.force >= self.settings.contact_off_n
        elif self.force > self.settings.contact_on_n:
            self.touching = True
            self.landed_n = self.force


def _is_valid(sample: MotionSample) -> bool:
    """Tell whether a sample can be: finite or NaN, of a hand, no negative speed or force, x with y, something said."""
    if not (math.isfinite(sample.time_s) and math.isfinite(sample.arrival_s)):
        return False
    values = (sample.x_mm, sample.y_mm, sample.speed_mm_s, sample.force_n)
    if any(math.isinf(v) for v in values) or all(v != v for v in values):
        return False
    if (sample.x_mm != sample.x_mm) != (sample.y_mm != sample.y_mm):
        return False
    if sample.speed_mm_s > FASTEST_MM_S or abs(sample.x_mm) > FARTHEST_MM or abs(sample.y_mm) > FARTHEST_MM:
        return False
    return not (sample.speed_mm_s < 0 or sample.force_n < 0)

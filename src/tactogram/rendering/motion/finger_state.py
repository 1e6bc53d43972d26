"""Finger motion from samples that arrive late, at any rate, and with losses.

Position, speed and force each have their own rate. The newest value of each is used; late samples are dropped and
counted, never queued: rendering an old position now would be felt as a delay from then on.

The sender's clock is independent. Its offset is the least difference between arrival and time stamp so far (the
fastest sample), which may rise by `DRIFT` so that a slow clock is followed. A game's clock may stop while it loads, and
be late for good: if everything is late for `RESTART_S`, the offset is determined anew.

Velocity comes from positions through the fading-memory filter of first order (Brookner 1998, Sec. 3.2): the straight
line that fits all past positions best, with weights that decay with age. It is causal, works at uneven rates, and has
no lag at a constant speed.

References
----------
- Brookner, E. (1998). Tracking and Kalman Filtering Made Easy. Wiley. Sec. 1.2.6 and 3.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from math import isnan
from typing import Protocol

DRIFT = 2e-4
"""How much slower than ours the sender's clock may run, s/s."""
RESTART_S = 1.0
"""A time stamp this much before the last one means a restarted sender, s; only late samples for this long, a clock
that stopped."""
FASTEST_MM_S, FARTHEST_MM = 1e4, 1e6
"""No finger is faster or farther away; a corrupt number would make the path length overflow."""
NAN = math.nan


@dataclass(frozen=True, slots=True)
class MotionSample:
    """A motion message; NaN marks missing values.

    ``time_s`` is on the sender's clock, ``arrival_s`` on the engine's. The position on the surface has both
    coordinates or neither; the speed is the velocity's magnitude, >= 0; a normal force of 0 is a lifted finger.
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
        """Return what arrived since the last call, up to ``now_s`` on the engine's clock; never waits."""
        ...

    def close(self) -> None:
        """Release ports and threads; never raises."""
        ...


@dataclass(frozen=True, slots=True)
class Tap:
    """A touch-down that starts a transient immediately; a strength of 1 is a touch of 1 N."""

    arrival_s: float
    strength: float


@dataclass(frozen=True, slots=True)
class MixWeights:
    """New weights of a mix by texture name; the other weights stay."""

    weights: dict[str, float]


@dataclass(frozen=True)
class MotionSettings:
    """Smoothing and expiry of motion.

    ``smoothing_s`` is the time constant of the velocity from positions; at least 1.5 intervals between positions are
    used. Samples older than ``late_s`` when they could be used are dropped; after ``lost_s`` without motion the
    connection counts as lost and the output goes to rest. The finger touches above ``contact_on_n`` and lifts below
    ``contact_off_n``. It rests below ``rest_mm_s`` and slides above ``moving_mm_s``; in between the output fades. A
    position ``jump_mm`` from the expected one is a jump to another place, not a stroke.
    """

    smoothing_s: float = 0.01
    late_s: float = 0.03
    lost_s: float = 0.1
    contact_on_n: float = 0.05
    contact_off_n: float = 0.02
    rest_mm_s: float = 1.0
    moving_mm_s: float = 6.0
    jump_mm: float = 20.0


@dataclass
class MotionCounts:
    """Counts of used and dropped samples, of clock changes after the first, and of lost connections."""

    used: int = 0
    late: int = 0
    out_of_order: int = 0
    invalid: int = 0
    clocks_set: int = 0
    lost_connections: int = 0

    @property
    def dropped(self) -> int:
        """Number of dropped samples."""
        return self.late + self.out_of_order + self.invalid


@dataclass
class FingerState:
    """State of the finger. Positions in mm, velocities in mm/s, times in s on the engine's clock.

    Call `update` for each sample. Times of values that have not arrived yet are -inf.
    """

    settings: MotionSettings = field(default_factory=MotionSettings)
    counts: MotionCounts = field(default_factory=MotionCounts)
    x: float = 0.0
    y: float = 0.0
    vx: float = 0.0
    vy: float = 0.0
    position_s: float = -math.inf
    speed: float = NAN
    speed_s: float = -math.inf
    force: float = NAN
    force_s: float = -math.inf
    newest_s: float = -math.inf
    """Time of the newest used sample."""
    touching: bool = False
    landing_n: float = 0.0
    """Force of a landing that no block has rendered yet, N; 0 if there is none."""
    jumped: bool = False
    """Whether the newest position is another place; reset by the block that goes there."""
    interval_s: float = 0.0
    """Mean time between positions, s."""
    _positions: int = 0
    _offset: float = math.inf
    _offset_s: float = 0.0
    _last: float = -math.inf
    _late_since: float = math.inf
    """Arrival of the first of an unbroken series of late samples; inf without one."""
    _least_late: float = math.inf
    """The least difference between arrival and time stamp in that series, s."""
    _connected: bool = False

    def update(self, sample: MotionSample, now_s: float) -> bool:
        """Process a sample; return whether it was used."""
        if not _is_valid(sample):
            self.counts.invalid += 1
            return False
        if sample.time_s <= self._last:
            if sample.time_s > self._last - RESTART_S:
                self.counts.out_of_order += 1
                return False
            self._set_clock(math.inf)
        self._last = sample.time_s
        difference = sample.arrival_s - sample.time_s
        allowed = self._offset + DRIFT * max(0.0, sample.arrival_s - self._offset_s)
        if difference < allowed:
            self._offset = difference
        elif self._offset < math.inf:
            self._offset = allowed
        self._offset_s = sample.arrival_s
        if now_s - (sample.time_s + self._offset) > self.settings.late_s and self._is_late(sample, now_s):
            self.counts.late += 1
            return False
        time_s = sample.time_s + self._offset
        self._late_since = self._least_late = math.inf
        self.counts.used += 1
        self.newest_s = max(self.newest_s, time_s)
        self._connected = True
        if not isnan(sample.x_mm):
            self._update_position(sample.x_mm, sample.y_mm, time_s)
        if not isnan(sample.speed_mm_s):
            self.speed, self.speed_s = sample.speed_mm_s, time_s
        if not isnan(sample.force_n):
            self.force, self.force_s = sample.force_n, time_s
        self._update_contact()
        return True

    def _is_late(self, sample: MotionSample, now_s: float) -> bool:
        """Tell a late sample from one after a stop of the sender's clock, which sets the clock."""
        self._late_since = min(self._late_since, sample.arrival_s)
        self._least_late = min(self._least_late, sample.arrival_s - sample.time_s)
        if sample.arrival_s - self._late_since < RESTART_S or self._least_late <= self._offset:
            return True
        self._set_clock(self._least_late)
        return now_s - (sample.time_s + self._offset) > self.settings.late_s

    def _set_clock(self, offset: float) -> None:
        self._offset = offset
        self._late_since = self._least_late = math.inf
        self.counts.clocks_set += 1

    def age(self, now_s: float) -> float:
        """Return the age of the newest sample, s."""
        return now_s - self.newest_s

    def is_lost(self, now_s: float) -> bool:
        """Return whether nothing has arrived for too long; counts each beginning."""
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
        """Return the velocity, mm/s: a measured speed, if there is one, in the direction of the positions."""
        lost_s = self.settings.lost_s
        vx, vy = (self.vx, self.vy) if now_s - self.position_s <= lost_s else (0.0, 0.0)
        if isnan(self.speed) or now_s - self.speed_s > lost_s:
            return vx, vy
        size = math.hypot(vx, vy)
        if size > 1e-3:
            return vx / size * self.speed, vy / size * self.speed
        return self.speed, 0.0

    def position(self, now_s: float, ahead_s: float = 0.0) -> tuple[float, float] | None:
        """Return the position extrapolated to ``ahead_s`` after now, mm; None if no positions arrive."""
        age = now_s - self.position_s
        if age > self.settings.lost_s:
            return None
        vx, vy = self.velocity(now_s)
        ahead = min(max(age, 0.0), self.settings.late_s + self.interval_s) + ahead_s
        return self.x + vx * ahead, self.y + vy * ahead

    def _update_position(self, x: float, y: float, time_s: float) -> None:
        step = time_s - self.position_s
        if step <= 0:
            return
        self.position_s = time_s
        if not step < self.settings.lost_s:
            far = math.hypot(x - self.x, y - self.y) > self.settings.jump_mm
            self.jumped = self.jumped or far or math.isinf(step)
            self._restart_at(x, y)
            return
        self.interval_s = step if self.interval_s == 0 else 0.9 * self.interval_s + 0.1 * step
        decay = math.exp(-step / max(self.settings.smoothing_s, 1.5 * self.interval_s))
        error_x, error_y = x - self.x - self.vx * step, y - self.y - self.vy * step
        if math.hypot(error_x, error_y) > self.settings.jump_mm:
            self.jumped = True
            self._restart_at(x, y)
            return
        # A line through the first few positions, until the fading memory is shorter than they are.
        n = self._positions
        self._positions += 1
        gain = max(1 - decay * decay, 2 * (2 * n + 1) / ((n + 1) * (n + 2)))
        slope = max((1 - decay) * (1 - decay), 6 / ((n + 1) * (n + 2))) / step
        self.x += self.vx * step + gain * error_x
        self.y += self.vy * step + gain * error_y
        self.vx += slope * error_x
        self.vy += slope * error_y

    def _restart_at(self, x: float, y: float) -> None:
        self.x, self.y, self.vx, self.vy = x, y, 0.0, 0.0
        self._positions = 1

    def _update_contact(self) -> None:
        """Determine contact from the force, or without one from the presence of motion."""
        if isnan(self.force):
            self.touching = True
        elif self.touching:
            self.touching = self.force >= self.settings.contact_off_n
        elif self.force > self.settings.contact_on_n:
            self.touching = True
            self.landing_n = self.force


def _is_valid(sample: MotionSample) -> bool:
    """Check a sample: finite or missing, within a hand's reach and speed, nothing negative, x with y, not empty."""
    if not (math.isfinite(sample.time_s) and math.isfinite(sample.arrival_s)):
        return False
    values = (sample.x_mm, sample.y_mm, sample.speed_mm_s, sample.force_n)
    if any(math.isinf(v) for v in values) or all(isnan(v) for v in values):
        return False
    if isnan(sample.x_mm) != isnan(sample.y_mm):
        return False
    if sample.speed_mm_s > FASTEST_MM_S or abs(sample.x_mm) > FARTHEST_MM or abs(sample.y_mm) > FARTHEST_MM:
        return False
    return not (sample.speed_mm_s < 0 or sample.force_n < 0)

"""The finger at each sample of a block: a smooth path from motion that arrives in steps.

A critically damped follower of second order tracks the measured position and velocity: it has no lag at a constant
speed, and its position and velocity stay continuous at every correction, so that pitch glides where measurements jump.
Contact and movement are gains with ramps of their own: rest, landing and lift are states of the same endless signal.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.rendering.displays.catalogue import MotionBlock, MotionSamples
from tactogram.rendering.motion.finger_state import (
    FARTHEST_MM,
    FASTEST_MM_S,
    FingerState,
    MotionSample,
    MotionSource,
)
from tactogram.signal.motion import Motion

State = Literal["lost", "air", "rest", "slide"]
FINGER_STATES: tuple[State, ...] = ("lost", "air", "rest", "slide")

FOLLOWING_S = 0.005
"""Least time constant of the follower, s; at least one interval between positions is used."""
FORCE_S = 0.005
"""Time constant of the force, s."""
LANDING_S = 0.003
"""Length of the ramp when the finger lands, and the shortest when it starts to move, s."""
LIFTING_S = 0.012
"""Length of the ramp when it lifts or is lost, and the shortest when it comes to rest, s."""

TRACED_HZ, TRACED = 1000.0, 5
"""Rate of a motion that is followed without a stream, and samples in a block of it."""

_X, _Y, _VX, _VY, _FORCE, _CONTACT, _PATH, _MOVEMENT = range(8)


class _Target(NamedTuple):
    """The finger at the beginning of a block, and the ranges and time constants of the follower."""

    has_position: bool
    x: float
    y: float
    vx: float
    vy: float
    force: float
    touching: bool
    following_s: float
    rest_mm_s: float
    moving_mm_s: float


class FingerTracker:
    """Follower of a `FingerState`, in blocks of at most ``most`` samples at ``rate`` Hz."""

    def __init__(self, rate: float, most: int) -> None:
        self.block = MotionBlock(most)
        self.state: State = "lost"
        self._step_s = 1 / rate
        self._values = np.zeros(8)

    def follow(self, finger: FingerState, now_s: float, count: int, *, ahead_s: float = 0.0) -> MotionBlock:
        """Return the finger over the next ``count`` samples, the first of them ``ahead_s`` after ``now_s``."""
        settings, values, block = finger.settings, self._values, self.block
        lost = finger.is_lost(now_s)
        position = None if lost else finger.position(now_s, ahead_s)
        vx, vy = (0.0, 0.0) if lost else finger.velocity(now_s)
        silent = values[_CONTACT] == 0.0
        if finger.jumped and position is not None and silent:
            values[_X], values[_Y], values[_VX], values[_VY] = *position, vx, vy
            finger.jumped = False
        jumping = finger.jumped and position is not None
        if jumping:  # fade out here, then go there silently
            position, vx, vy = None, 0.0, 0.0
        touching = finger.touching and not lost and not jumping
        force = 0.0 if math.isnan(finger.force) else finger.force
        if silent and touching:
            values[_FORCE] = force
        target = _Target(
            position is not None,
            *(position or (0.0, 0.0)),
            vx,
            vy,
            force,
            touching,
            max(FOLLOWING_S, finger.interval_s),
            settings.rest_mm_s,
            settings.moving_mm_s,
        )
        _follow(values, target, self._step_s, count, block.samples)
        block.count = count
        moving = block.speed_mm_s[count - 1] > (settings.rest_mm_s + settings.moving_mm_s) / 2
        self.state = "lost" if lost else "air" if not finger.touching else "slide" if moving else "rest"
        return block


def followed(source: MotionSource, seconds: float) -> Motion:
    """Return the first ``seconds`` of a source's motion, as a stream follows it: from rest.

    The force is None if the source has none. Raises `DataError` if the source has neither speeds nor positions, or some
    that no finger has.
    """
    finger, tracker = FingerState(), FingerTracker(TRACED_HZ, TRACED)
    count = 1 + math.ceil(seconds * TRACED_HZ - 1e-6)
    blocks = math.ceil(count / TRACED)
    speed, force, gain, contact = np.empty((4, blocks, TRACED))
    for number in range(blocks):
        now_s = number * TRACED / TRACED_HZ
        for message in source.poll(now_s):
            if isinstance(message, MotionSample):
                finger.update(message, now_s)
        block = tracker.follow(finger, now_s, TRACED)
        finger.landing_n = 0.0
        speed[number], force[number] = block.speed_mm_s, block.force_n
        gain[number], contact[number] = block.contact * block.movement, block.contact
    if finger.counts.invalid:
        raise DataError(
            f"{source.name}: speeds must be at most {FASTEST_MM_S:g} mm/s, positions have x_mm and y_mm within "
            f"{FARTHEST_MM:g} mm; correct them"
        )
    if math.isinf(finger.speed_s) and math.isinf(finger.position_s):
        raise DataError(f"{source.name}: has neither speed_mm_s nor x_mm; add one of them")
    known = None if math.isnan(finger.force) else force.ravel()[:count]
    speeds, gains, contacts = (values.ravel()[:count] for values in (speed, gain, contact))
    return Motion(np.arange(count) / TRACED_HZ, speeds, known, gains, contacts)


@numba.njit(cache=True, nogil=True)
def _follow(
    values: NDArray[np.float64], target: _Target, step: float, count: int, out: MotionSamples
) -> None:
    pull = 1 / (target.following_s * target.following_s)
    damping = 2 / target.following_s
    decay = math.exp(-step / FORCE_S)
    rise, fall = step / LANDING_S, step / LIFTING_S
    x, y, vx, vy = values[_X], values[_Y], values[_VX], values[_VY]
    force, contact, path, movement = values[_FORCE], values[_CONTACT], values[_PATH], values[_MOVEMENT]
    for i in range(count):
        t = i * step
        ax, ay = damping * (target.vx - vx), damping * (target.vy - vy)
        if target.has_position:
            ax += pull * (target.x + target.vx * t - x)
            ay += pull * (target.y + target.vy * t - y)
        vx += ax * step
        vy += ay * step
        x += vx * step
        y += vy * step
        speed = math.sqrt(vx * vx + vy * vy)
        path += speed * step
        force = target.force + decay * (force - target.force)
        contact = min(1.0, contact + rise) if target.touching else max(0.0, contact - fall)
        goal = min(1.0, max(0.0, (speed - target.rest_mm_s) / (target.moving_mm_s - target.rest_mm_s)))
        movement += min(rise, max(-fall, goal - movement))
        out.x_mm[i], out.y_mm[i], out.path_mm[i] = x, y, path
        out.speed_mm_s[i], out.force_n[i] = speed, force
        out.contact[i] = contact * contact * (3 - 2 * contact)
        out.movement[i] = movement * movement * (3 - 2 * movement)
    values[_X], values[_Y], values[_VX], values[_VY] = x, y, vx, vy
    values[_FORCE], values[_CONTACT], values[_PATH], values[_MOVEMENT] = force, contact, path, movement

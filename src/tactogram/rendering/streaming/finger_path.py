"""The finger at each sample of a block: what comes in steps from `motion` goes out without a jump.

A critically damped follower of second order goes after the place and velocity that are known: it has no lag at a
constant speed, and whatever a new measurement corrects, its place and its velocity stay continuous. So pitch glides
where measurements jump. Contact and movement are gains with ramps of their own: rest, landing and lift are states of
the same endless signal, not gaps in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numba
import numpy as np
from numpy.typing import NDArray

from tactogram.rendering.streaming.motion import FingerState

State = Literal["lost", "air", "rest", "slide"]
STATES: tuple[State, ...] = ("lost", "air", "rest", "slide")

FOLLOWING_S = 0.005
"""Least time constant of the follower, s; at least one interval between positions is used."""
FORCE_S = 0.005
"""Time constant of the force, s."""
LANDING_S = 0.003
"""Length of the ramp when the finger lands, and the shortest when it begins to move, s."""
LIFTING_S = 0.012
"""Length of the ramp when it lifts or is lost, and the shortest when it comes to rest, s."""

_X, _Y, _VX, _VY, _FORCE, _CONTACT, _PATH, _MOVEMENT = range(8)


@dataclass(eq=False)
class MotionBlock:
    """The finger over one block; every array has room for ``most`` samples, of which ``count`` hold.

    Parameters
    ----------
    most : int
    x_mm, y_mm, path_mm : float64 array, shape (most,)
        Place, and the length of the way so far, mm.
    speed_mm_s, force_n : float64 array, shape (most,)
    contact, movement : float32 array, shape (most,)
        Gains from 0 (lifted, at rest) to 1 (touching, sliding).
    count : int
    """

    most: int
    count: int = 0
    x_mm: NDArray[np.float64] = field(init=False)
    y_mm: NDArray[np.float64] = field(init=False)
    path_mm: NDArray[np.float64] = field(init=False)
    speed_mm_s: NDArray[np.float64] = field(init=False)
    force_n: NDArray[np.float64] = field(init=False)
    contact: NDArray[np.float32] = field(init=False)
    movement: NDArray[np.float32] = field(init=False)

    def __post_init__(self) -> None:
        for name in ("x_mm", "y_mm", "path_mm", "speed_mm_s", "force_n"):
            setattr(self, name, np.zeros(self.most))
        for name in ("contact", "movement"):
            setattr(self, name, np.zeros(self.most, np.float32))


class FingerTracker:
    """Goes after a `FingerState`, block by block.

    Parameters
    ----------
    rate : float, Hz
    most : int
        Most samples in a block.
    """

    def __init__(self, rate: float, most: int) -> None:
        self.block = MotionBlock(most)
        self.state: State = "lost"
        self._rate = rate
        self._values = np.zeros(8)

    def follow(self, finger: FingerState, now_s: float, count: int, *, ahead_s: float = 0.0) -> MotionBlock:
        """Return the finger over the next ``count`` samples, the first of them ``ahead_s`` after ``now_s``."""
        settings, values, block = finger.settings, self._values, self.block
        lost = finger.lost(now_s)
        place = None if lost else finger.place(now_s, ahead_s)
        vx, vy = (0.0, 0.0) if lost else finger.velocity(now_s)
        silent = values[_CONTACT] == 0.0
        if finger.jumped and place is not None and silent:
            values[_X], values[_Y], values[_VX], values[_VY] = *place, vx, vy
            finger.jumped = False
        elsewhere = finger.jumped and place is not None
        if elsewhere:  # fade where it is, and go there unheard
            place, vx, vy = None, 0.0, 0.0
        touching = finger.touching and not lost and not elsewhere
        force = finger.force if finger.force == finger.force else 0.0
        if silent and touching:
            values[_FORCE] = force
        _follow(
            values,
            place is not None,
            place[0] if place else 0.0,
            place[1] if place else 0.0,
            vx,
            vy,
            force,
            touching,
            max(FOLLOWING_S, finger.interval_s),
            settings.rest_mm_s,
            settings.moving_mm_s,
            1 / self._rate,
            count,
            block.x_mm,
            block.y_mm,
            block.path_mm,
            block.speed_mm_s,
            block.force_n,
            block.contact,
            block.movement,
        )
        block.count = count
        moving = block.speed_mm_s[count - 1] > (settings.rest_mm_s + settings.moving_mm_s) / 2
        self.state = "lost" if lost else "air" if not finger.touching else "slide" if moving else "rest"
        return block


@numba.njit(cache=True, nogil=True)
def _follow(
    values: NDArray[np.float64],
    placed: bool,
    x: float,
    y: float,
    vx: float,
    vy: float,
    force: float,
    touching: bool,
    following_s: float,
    rest: float,
    moving: float,
    step: float,
    count: int,
    out_x: NDArray[np.float64],
    out_y: NDArray[np.float64],
    out_path: NDArray[np.float64],
    out_speed: NDArray[np.float64],
    out_force: NDArray[np.float64],
    out_contact: NDArray[np.float32],
    out_movement: NDArray[np.float32],
) -> None:
    pull = 1 / (following_s * following_s)
    damp = 2 / following_s
    keep = math.exp(-step / FORCE_S)
    rise, fall = step / LANDING_S, step / LIFTING_S
    px, py, ux, uy = values[_X], values[_Y], values[_VX], values[_VY]
    held, contact, path, share = values[_FORCE], values[_CONTACT], values[_PATH], values[_MOVEMENT]
    for i in range(count):
        t = i * step
        ax, ay = damp * (vx - ux), damp * (vy - uy)
        if placed:
            ax += pull * (x + vx * t - px)
            ay += pull * (y + vy * t - py)
        ux += ax * step
        uy += ay * step
        px += ux * step
        py += uy * step
        speed = math.sqrt(ux * ux + uy * uy)
        path += speed * step
        held = force + keep * (held - force)
        contact = min(1.0, contact + rise) if touching else max(0.0, contact - fall)
        wanted = min(1.0, max(0.0, (speed - rest) / (moving - rest)))
        share += min(rise, max(-fall, wanted - share))
        out_x[i], out_y[i], out_path[i] = px, py, path
        out_speed[i], out_force[i] = speed, held
        out_contact[i] = contact * contact * (3 - 2 * contact)
        out_movement[i] = share * share * (3 - 2 * share)
    values[_X], values[_Y], values[_VX], values[_VY] = px, py, ux, uy
    values[_FORCE], values[_CONTACT], values[_PATH], values[_MOVEMENT] = held, contact, path, share

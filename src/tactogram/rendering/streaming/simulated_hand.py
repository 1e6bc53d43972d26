"""Simulated hand: seeded strokes back and forth, with rests and lifts, and a varying force. Not a person's data."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.streaming.motion import MotionSample

Array = NDArray[np.float64]

UP_S = 0.08
"""Time in which a finger lifts before it moves on, or comes down, s."""


@dataclass(frozen=True)
class HandSettings:
    """Settings of a simulated hand: rates in Hz, and ranges of the strokes, rests and lifts.

    A stroke follows the path of least jerk (Flash & Hogan 1985): from rest to rest, its peak speed 1.875 times its
    mean. Every few strokes the finger lifts and lands elsewhere. ``force_n`` is the mean normal force while touching,
    which varies by about a third; ``noise_mm`` the standard deviation of a position.
    """

    position_rate: float = 250.0
    force_rate: float = 500.0
    length_mm: tuple[float, float] = (40.0, 120.0)
    duration_s: tuple[float, float] = (0.4, 1.2)
    rest_s: tuple[float, float] = (0.02, 0.25)
    lift_s: tuple[float, float] = (0.15, 0.5)
    strokes_between_lifts: int = 3
    force_n: float = 0.6
    noise_mm: float = 0.01


class SimulatedHand:
    """Motion of a simulated hand for ``seconds``; the same seed gives the same motion."""

    name = "simulated hand"
    simulated = True

    def __init__(self, seconds: float, *, seed: int, settings: HandSettings | None = None) -> None:
        if not (seconds > 0 and math.isfinite(seconds)):
            raise ParameterError(f"seconds must be > 0, got {seconds}")
        self.settings = s = settings or HandSettings()
        random = np.random.default_rng(seed)
        knots = _journey(seconds, s, random)
        at = np.arange(math.ceil(seconds * s.position_rate)) / s.position_rate
        x, y, _ = _along(knots, at)
        x += s.noise_mm * random.standard_normal(len(x))
        y += s.noise_mm * random.standard_normal(len(y))
        # Half an interval apart, like two independent sensors.
        at_force = np.asarray((np.arange(math.ceil(seconds * s.force_rate)) + 0.5) / s.force_rate, np.float64)
        force = _force(knots, at_force, s, random)
        times = np.concatenate((at, at_force))
        order = np.argsort(times, kind="stable")
        nothing = np.full(len(at_force), math.nan)
        self._times = times[order]
        self._x = np.concatenate((x, nothing))[order]
        self._y = np.concatenate((y, nothing))[order]
        self._force = np.concatenate((np.full(len(at), math.nan), force))[order]
        self._next = 0

    def poll(self, now_s: float) -> list[MotionSample]:
        """Return the motion since the last call up to ``now_s``, without delay."""
        end = int(np.searchsorted(self._times, now_s, side="right"))
        begin, self._next = self._next, max(self._next, end)
        return [
            MotionSample(t, t, x, y, math.nan, force)
            for t, x, y, force in zip(
                self._times[begin:end].tolist(),
                self._x[begin:end].tolist(),
                self._y[begin:end].tolist(),
                self._force[begin:end].tolist(),
                strict=True,
            )
        ]

    def close(self) -> None:
        """Do nothing."""


@dataclass(frozen=True)
class _HandMove:
    begin_s: float
    end_s: float
    start: tuple[float, float]
    stop: tuple[float, float]
    touching: bool


def _journey(seconds: float, s: HandSettings, random: np.random.Generator) -> list[_HandMove]:
    """Return consecutive moves that last at least ``seconds``."""
    moves: list[_HandMove] = []
    now, place, direction = 0.0, (0.0, 0.0), 1.0

    def go(lasting: float, to: tuple[float, float], *, touching: bool) -> None:
        nonlocal now, place
        moves.append(_HandMove(now, now + lasting, place, to, touching))
        now, place = now + lasting, to

    go(0.2, place, touching=False)
    while now < seconds:
        strokes = 1 + random.poisson(s.strokes_between_lifts - 1)
        go(random.uniform(*s.rest_s), place, touching=True)
        for _ in range(strokes):
            length = random.uniform(*s.length_mm)
            to = (place[0] + direction * length, place[1] + random.normal(0, 0.05 * length))
            go(random.uniform(*s.duration_s), to, touching=True)
            go(random.uniform(*s.rest_s), place, touching=True)
            direction = -direction
        landing = (place[0] + random.uniform(-30, 30), place[1] + random.uniform(-30, 30))
        go(UP_S, place, touching=False)
        go(random.uniform(*s.lift_s), landing, touching=False)
        go(UP_S, landing, touching=False)
    return moves


def _along(moves: list[_HandMove], at: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return x, y (mm) and whether the finger touches, at times ``at`` (s)."""
    place = np.searchsorted([move.end_s for move in moves], at, side="right")
    begin, end = (np.array([getattr(m, name) for m in moves])[place] for name in ("begin_s", "end_s"))
    start, stop = (np.array([getattr(m, name) for m in moves])[place] for name in ("start", "stop"))
    share = np.clip((at - begin) / (end - begin), 0, 1)
    progress = share**3 * (10 - 15 * share + 6 * share**2)
    position = start + progress[:, None] * (stop - start)
    touching = np.array([m.touching for m in moves])[place]
    return position[:, 0], position[:, 1], touching


def _force(moves: list[_HandMove], at: Array, s: HandSettings, random: np.random.Generator) -> Array:
    """Return the force at times ``at``, N: 0 in the air, slowly varying on the surface, rising and falling fast."""
    _, _, touching = _along(moves, at)
    slow = np.zeros(len(at))
    for hz in (0.3, 0.7, 1.9):
        slow += np.sin(2 * np.pi * (hz * at + random.uniform())) / 3
    wanted = np.where(touching, s.force_n * (1 + 0.6 * slow), 0.0)
    smooth = np.empty(len(at))
    force, decay = 0.0, math.exp(-1 / (0.012 * s.force_rate))
    for i, value in enumerate(wanted):
        force = value + decay * (force - value)
        smooth[i] = force
    return np.where(smooth < 0.01, 0.0, smooth)

"""Simulated fabrics: friction over displacement, registered to a photograph.

The layout is that of HapTex (Jiao et al. 2019), as FrictGAN uses it: a finger moves along the middle of the
photographed area, and every place of the friction is a place in the picture. The fabrics are formulas with names of
fabrics, not measurements.
"""

from __future__ import annotations

import zlib
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft2

from tactogram.datasets import Recording
from tactogram.errors import ParameterError
from tactogram.signal import Signal, over_displacement, resample
from tactogram_simulate.contact import FINGER, ContactSignals, feel, transmission
from tactogram_simulate.materials import surfaces_of
from tactogram_simulate.photo import render
from tactogram_simulate.stroke import RecordingTask, Stroke, stroke
from tactogram_simulate.surfaces import (
    MM_PER_PIXEL,
    PATCH_MM,
    SIZE,
    Surface,
    frequencies,
    height_field,
    inverse,
)

ROWS = SIZE // 2
"""Rows of a photograph, half as high as it is wide, 51.2 mm; a pixel is a cell of the height field."""
LEAD_MM = 6.0
"""Distance before and after the photographed area, in which the finger speeds up and slows down."""
INTERNAL_RATE = 8000.0

FABRICS = surfaces_of("fabrics")


def fabric(surface: Surface, task: RecordingTask) -> Recording:
    """Return a simulated stroke over one piece of a fabric, and its photograph.

    Pieces have the same weave and material, but different irregularities. The length on the photograph, speed times
    seconds, is at most `PATCH_MM`; friction has ``rate / speed_mm_s`` samples per mm.
    """
    piece, speed_mm_s = task.take, task.speed_mm_s
    length = speed_mm_s * task.seconds
    if not 1 <= length <= PATCH_MM + 1e-6:
        raise ParameterError(
            f"a simulated fabric is {PATCH_MM:g} mm long, {task.seconds:g} s at {speed_mm_s:g} mm/s are {length:g} mm; "
            f"give at most {PATCH_MM / speed_mm_s:g} seconds"
        )
    source = f"{task.set_name}/{surface.name}/{piece}"
    rng = np.random.default_rng(np.random.SeedSequence([task.seed, zlib.crc32(source.encode())]))
    cut = replace(surface, name=f"{surface.name} piece {piece} of {task.seed}")
    force = FINGER.force_n * float(np.exp(0.1 * rng.standard_normal()))
    moved = _guided(rng, speed_mm_s, length, force)
    start = (-LEAD_MM, ROWS / 2 * MM_PER_PIXEL)
    felt = feel(cut, FINGER, moved, start_mm=start, direction_deg=0)
    # As measured by a force plate under the fabric: the slopes that the finger climbs pull like friction.
    ratio = felt.friction_n / np.maximum(felt.force_n, 0.1 * felt.force_n.mean()) + _slope(cut, start, felt)
    over_time = Signal(np.maximum(ratio, 0), moved.rate, "1", ("along",))
    position = resample(Signal(felt.place_m.astype(np.float32), moved.rate, "m", ("along",)), 200.0)
    # The finger's position, not the hand's: skin deforms before it slides.
    speed = position.with_samples(np.gradient(position.samples[0].astype(float)) * position.rate, unit="m/s")
    per_mm = task.rate / speed_mm_s
    travelled = over_displacement(over_time, speed, rate=per_mm, standstill=0.05)
    first = round((LEAD_MM - 1e3 * float(felt.place_m[_first_moving(speed, moved.rate)])) * per_mm)
    friction = travelled.cut(first, first + round(length * per_mm))
    columns = min(SIZE, round(length / MM_PER_PIXEL))
    return Recording(
        streams={"friction": friction.with_samples(np.maximum(friction.samples, 0))},
        image=render(cut, rows=ROWS, columns=columns, pool=1),
        material=surface.name,
        speed_mm_s=speed_mm_s,
        force_n=round(force, 3),
        direction_deg=0.0,
        contactor=FINGER.name,
        session=f"piece-{piece}",
        subject="simulated",
        labels={"recording": str(piece)},
        source=source,
        history=(
            f"simulated set {task.set_name}, seed {task.seed}",
            f"contact at {moved.rate:g} Hz: height field, resonant contact, LuGre friction",
            f"friction over displacement, {per_mm:g} samples per mm; registered to the photograph: displacement 0 "
            "is its left edge, the finger moved to the right along its middle row",
        ),
        simulated=True,
    )


def _guided(rng: np.random.Generator, speed_mm_s: float, length_mm: float, force_n: float) -> Stroke:
    """Return a straight stroke from rest to rest, over ``length_mm`` and `LEAD_MM` on both sides."""
    turn = 0.15
    seconds = (length_mm + 2 * LEAD_MM) / speed_mm_s + turn
    moved = stroke(
        rng,
        seconds=seconds,
        rate=INTERNAL_RATE,
        speed_mm_s=speed_mm_s,
        force_n=force_n,
        back_and_forth=False,
        unsteadiness=0.03,
    )
    return replace(moved, sideways_mm=np.zeros_like(moved.sideways_mm))


def _slope(surface: Surface, start_mm: tuple[float, float], touch: ContactSignals) -> NDArray[np.float64]:
    """Return the slope of the heights under the finger, float64, shape (time,)."""
    ky, kx = frequencies()
    passed = rfft2(height_field(surface)) * transmission(FINGER, np.hypot(ky, kx))
    row = inverse(passed * 2j * np.pi * kx)[round(start_mm[1] / MM_PER_PIXEL) % SIZE]
    given_way = surface.stiffness_n_m / (surface.stiffness_n_m + FINGER.stiffness_n_m)
    position_mm = start_mm[0] + 1e3 * touch.place_m
    grid_mm = np.arange(SIZE) * MM_PER_PIXEL
    return np.asarray(given_way * np.interp(position_mm, grid_mm, row, period=PATCH_MM))


def _first_moving(speed: Signal, rate: float) -> int:
    """Return the sample, at ``rate``, where `over_displacement` begins."""
    v = np.abs(speed.samples[0].astype(float))
    median = float(np.median(v[v > 0.01 * v.max()]))
    speeds = np.interp(np.arange(round(len(v) * rate / speed.rate)) / rate, np.arange(len(v)) / speed.rate, v)
    return int(np.argmax(speeds >= 0.05 * median))

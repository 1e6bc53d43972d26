"""A finger-like sensor of two silicone layers with two strain gauges in each, traced over a metal plate, simulated.

The layout of the ultrasonic study, Sec. III-B: a pad of two layers of different hardness, two gauges in each, 20 mm/s,
0.98 N, 50 mm, 10 kHz, 2.5 s of which 2 s are stable. Stiffnesses, resonances, gains and noise are our assumptions.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal as dsp

from tactogram.datasets.recording import Recording
from tactogram.datasets.simulate.contact import Contactor, feel
from tactogram.datasets.simulate.metal_plates import Plate, fine_heights
from tactogram.datasets.simulate.stroke import stroke
from tactogram.datasets.simulate.surfaces import PATCH_MM
from tactogram.signal import Signal
from tactogram.signal.filters import resample

GAUGES = ("g1", "g2", "g3", "g4")
"""Front and back of the outer layer, front and back of the inner one."""
STABLE_S = (0.25, 2.25)
"""Part of 2.5 s in which the sensor moves at its speed; before it starts, after it stops."""
SENSOR = Contactor("tactile sensor", 1.2, 1.0, 0.0, 0.010, 3000.0, 3.0, 0.020, 4000.0, 8.0, 0.98, 0.0)
UNSTEADINESS = 0.001
"""Of a friction tester, as `stroke` has it: a machine moves, a weight presses."""
INTERNAL_RATE = 20_000.0


@dataclass(frozen=True)
class Layer:
    """A silicone layer: a second-order resonance between the contact and the two gauges in it.

    Parameters
    ----------
    resonance_hz, damping : float
    shear_v_n, normal_v_n : float
        What its gauges say per newton along the stroke, which bends them opposite ways, and normal to it, which
        presses both.
    """

    resonance_hz: float
    damping: float
    shear_v_n: float
    normal_v_n: float


LAYERS = (Layer(420.0, 0.35, 1.0, 0.45), Layer(170.0, 0.22, 0.55, 0.30))
"""The outer, softer one follows the contact up to some 400 Hz; the inner one, behind it, hears less and deeper."""
LOCAL = 0.6
"""Share of the finest roughness that a gauge feels alone: it lies over other asperities than the other one."""
NOISE_V, STEP_V = 2e-4, 10 / 2**16


def traced(plate: Plate, *, measurement: int, seed: int, seconds: float, rate: float, speed_mm_s: float,
           set_name: str) -> Recording:  # fmt: skip
    """Return one simulated measurement of a plate.

    Parameters
    ----------
    plate : Plate
    measurement : int
        Number, from 1: each begins at another place, a little turned, and the sensor is mounted anew.
    seed : int
    seconds, rate, speed_mm_s : float
    set_name : str

    Returns
    -------
    Recording
        Stream ``strain``: axes `GAUGES`, V. ``session`` is the measurement's own.
    """
    source = f"{set_name}/{plate.name}/{measurement}"
    rng = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(source.encode())]))
    fast = rate * max(2.0, np.ceil(INTERNAL_RATE / rate))
    moved = stroke(
        rng,
        seconds=seconds,
        rate=fast,
        speed_mm_s=speed_mm_s,
        force_n=SENSOR.force_n * float(np.exp(0.01 * rng.standard_normal())),
        back_and_forth=False,
        unsteadiness=UNSTEADINESS,
    )
    direction = float(1.5 * rng.standard_normal())
    felt = feel(
        plate.surface,
        SENSOR,
        moved,
        start_mm=(PATCH_MM * rng.random(), PATCH_MM * rng.random()),
        direction_deg=direction,
    )
    shear = felt.friction_n + SENSOR.grip_mass_kg * felt.along
    local = [_fine_force(plate, felt.place_m, fast, rng) for _ in range(len(GAUGES) + 1)]
    rows = []
    for layer_number, layer in enumerate(LAYERS):
        for side, sign in enumerate((1.0, -1.0)):
            gauge = 2 * layer_number + side
            fine = np.sqrt(1 - LOCAL**2) * local[0] + LOCAL * local[1 + gauge]
            gain = 1 + 0.05 * rng.standard_normal()
            pressed = layer.normal_v_n * (1 + 0.1 * rng.standard_normal()) * (felt.force_n + fine)
            bent = sign * layer.shear_v_n * (shear + fine)
            rows.append(gain * _through(layer, bent + pressed, fast))
    volts = resample(Signal(np.stack(rows).astype(np.float32), fast, "V", GAUGES), rate)
    noisy = volts.samples + NOISE_V * rng.standard_normal(volts.samples.shape)
    return Recording(
        streams={"strain": volts.with_samples(np.round(noisy / STEP_V) * STEP_V)},
        material=plate.name,
        speed_mm_s=speed_mm_s,
        force_n=SENSOR.force_n,
        direction_deg=round(direction, 2),
        contactor=SENSOR.name,
        session=f"{plate.name}-m{measurement:02d}",
        subject="simulated",
        labels={"recording": str(measurement), "made": plate.made},
        source=source,
        history=(
            f"simulated set {set_name}, seed {seed}",
            f"contact at {fast:g} Hz: height field, resonant contact, LuGre friction",
            f"four strain gauges in two layers; stable from {STABLE_S[0]:g} to {seconds - STABLE_S[0]:g} s",
        ),
        simulated=True,
    )


def _fine_force(
    plate: Plate, place_m: NDArray[np.float64], rate: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the force by which the finest roughness shakes the pad, N: its mass stays, spring and damper give way."""
    heights = fine_heights(plate, SENSOR, place_m + rng.random(), rng)
    return np.asarray(SENSOR.stiffness_n_m * heights + SENSOR.damping_n_s_m * np.gradient(heights) * rate)


def _through(layer: Layer, force: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """Return a force as the gauges of a layer meet it, of gain 1 at rest."""
    w = 2 * np.pi * layer.resonance_hz
    b, a = dsp.bilinear([w**2], [1, 2 * layer.damping * w, w**2], rate)
    return np.asarray(dsp.lfilter(b, a, force, zi=force[0] * dsp.lfilter_zi(b, a))[0])

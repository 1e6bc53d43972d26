"""Simulated sensors: an accelerometer with gravity, noise and losses, and a finger of two layers with strain gauges.

The layout of the ultrasonic study, Sec. III-B: a pad of two layers of different hardness, 20 mm/s, 0.98 N, 50 mm, 10
kHz, 2.5 s of which 2 s are stable. Stiffnesses, resonances, gains and noise are our assumptions.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.datasets import Recording
from tactogram.signal import Signal, resample, to_uniform
from tactogram_simulate.contact import Contactor, feel
from tactogram_simulate.materials import Plate, fine_heights
from tactogram_simulate.stroke import RecordingTask, stroke
from tactogram_simulate.surfaces import PATCH_MM

GRAVITY = 9.80665
AXES = ("x", "y", "z")
GAUGES = ("g1", "g2", "g3", "g4")
"""Front and back of the outer layer, then of the inner one."""
STABLE_S = (0.25, 2.25)
"""Interval of 2.5 s at constant speed."""
SENSOR = Contactor("tactile sensor", 1.2, 1.0, 0.0, 0.010, 3000.0, 3.0, 0.020, 4000.0, 8.0, 0.98, 0.0)
UNSTEADINESS = 0.001
"""Of a friction tester: a machine moves, a weight presses."""
INTERNAL_RATE = 20_000.0
LOCAL = 0.6
"""Share of the finest roughness that only one gauge senses, since each lies over different asperities."""
NOISE_V, STEP_V = 2e-4, 10 / 2**16


@dataclass(frozen=True)
class Sensor:
    """An accelerometer."""

    rate: float  # Hz
    noise: float  # density, m/s^2 per root Hz
    step: float  # quantisation, m/s^2
    range: float  # largest magnitude, m/s^2
    noise_z: float = 1.0  # noise of z over that of x and y
    clock: float = (
        0.0  # relative error of a recording's clock, rms, which the receiver sees in the arrival times
    )
    jitter: float = 0.0  # error of the sampling instants over the period, rms, which nobody sees
    packet: int = 1  # samples per radio packet; 1 is a wire
    lost: float = 0.0  # share of lost packets


def wireless(rate: float = 330.0) -> Sensor:
    """Return the ADXL345 of Saga et al.: 4 mg steps, ten samples a packet, 33 packets a second, some of them lost.

    Noise densities of 290 (x, y) and 430 ug per root Hz (z) are its data sheet's. Clock, jitter and losses are our
    assumptions.
    """
    return Sensor(
        rate, 290e-6 * GRAVITY, 4e-3 * GRAVITY, 16 * GRAVITY,
        noise_z=430 / 290, clock=0.003, jitter=0.01, packet=10, lost=0.004,
    )  # fmt: skip


def wired(rate: float = 1000.0) -> Sensor:
    """Return a wired analogue accelerometer: 100 ug per root Hz, 16 bits over +-16 g, no losses. Our assumption."""
    return Sensor(rate, 100e-6 * GRAVITY, 32 * GRAVITY / 2**16, 16 * GRAVITY)


def sense(
    acceleration: NDArray[np.float64],
    rate: float,
    angles: NDArray[np.float64],
    sensor: Sensor,
    rng: np.random.Generator,
) -> tuple[Signal, int]:
    """Return the signal of ``sensor`` and the number of lost packets.

    Parameters
    ----------
    acceleration : float64 array, shape (3, time), m/s^2
        Along the stroke, across it, out of the surface.
    rate : float, Hz
        Of ``acceleration``, well above the sensor's.
    angles : float64 array, shape (3, time) or (3, 1), radians
        Rotation of the sensor about x, then y, then z.
    sensor : Sensor
    rng : numpy Generator

    Returns
    -------
    signal : Signal
        Axes x, y, z, m/s^2, at the sensor's nominal rate, with gravity. Lost packets are bridged by straight lines, and
        a clock error is corrected by `tactogram.signal.timing.to_uniform`, as by a receiver.
    lost : int
    """
    with_gravity = acceleration.copy()
    with_gravity[2] += GRAVITY
    clock = sensor.rate * (1 + sensor.clock * rng.standard_normal())
    # The resampler is the sensor's anti-aliasing filter: its pass band ends below half the rate.
    turned = Signal(turn(with_gravity, angles).astype(np.float32), rate, "m/s^2", AXES)
    x = resample(turned, clock).samples.astype(np.float64)
    n = x.shape[1]
    # The error of a late sample is slope times delay, which is small against the period.
    late = sensor.jitter * np.clip(rng.standard_normal(n), -3, 3)
    x += np.gradient(x, axis=1) * late
    density = sensor.noise * np.array([1.0, 1.0, sensor.noise_z])[:, None]
    x += density * np.sqrt(clock / 2) * rng.standard_normal((3, n))
    x = np.clip(np.round(x / sensor.step) * sensor.step, -sensor.range, sensor.range)
    if sensor.packet == 1:
        return Signal(x.astype(np.float32), sensor.rate, "m/s^2", AXES), 0
    arrived = rng.random(-(-n // sensor.packet)) >= sensor.lost
    arrived[[0, -1]] = True
    kept = np.repeat(arrived, sensor.packet)[:n]
    times = np.arange(n) / clock
    # Bridged by straight lines: ten samples say nothing band-limited about the ten between them.
    x = np.stack([np.interp(times, times[kept], row[kept]) for row in x])
    signal = to_uniform(times, x, "m/s^2", axes=AXES, rate=sensor.rate)
    return signal, int(np.count_nonzero(~arrived))


def turn(v: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors in a frame that is rotated about x, then y, then z by ``angles`` (radians), shape (3, time)."""
    x, y, z = v
    for axis, (sine, cosine) in enumerate(zip(np.sin(angles), np.cos(angles), strict=True)):
        if axis == 0:
            y, z = cosine * y + sine * z, cosine * z - sine * y
        elif axis == 1:
            z, x = cosine * z + sine * x, cosine * x - sine * z
        else:
            x, y = cosine * x + sine * y, cosine * y - sine * x
    return np.stack([x, y, z])


@dataclass(frozen=True)
class Layer:
    """A silicone layer: a second-order resonance between the contact and its two gauges.

    The gauges measure V per N along the stroke, which bends them opposite ways, and normal to it, which presses both.
    """

    resonance_hz: float
    damping: float
    shear_v_n: float
    normal_v_n: float


LAYERS = (Layer(420.0, 0.35, 1.0, 0.45), Layer(170.0, 0.22, 0.55, 0.30))
"""The outer, softer one follows the contact up to some 400 Hz; the inner one responds less, at lower frequencies."""


def trace_plate(plate: Plate, task: RecordingTask) -> Recording:
    """Return one simulated measurement of a plate: stream ``strain``, axes `GAUGES`, V; ``session`` is its own.

    Each begins at another place, slightly turned, with the sensor mounted anew.
    """
    rate = task.rate
    source = f"{task.set_name}/{plate.name}/{task.take}"
    rng = np.random.default_rng(np.random.SeedSequence([task.seed, zlib.crc32(source.encode())]))
    fast = rate * max(2.0, np.ceil(INTERNAL_RATE / rate))
    moved = stroke(
        rng,
        seconds=task.seconds,
        rate=fast,
        speed_mm_s=task.speed_mm_s,
        force_n=SENSOR.force_n * float(np.exp(0.01 * rng.standard_normal())),
        back_and_forth=False,
        unsteadiness=UNSTEADINESS,
    )
    direction = float(1.5 * rng.standard_normal())
    touch = feel(
        plate.surface,
        SENSOR,
        moved,
        start_mm=(PATCH_MM * rng.random(), PATCH_MM * rng.random()),
        direction_deg=direction,
    )
    shear = touch.friction_n + SENSOR.grip_mass_kg * touch.along
    local = [_fine_force(plate, touch.place_m, fast, rng) for _ in range(len(GAUGES) + 1)]
    rows = []
    for layer_number, layer in enumerate(LAYERS):
        for side, sign in enumerate((1.0, -1.0)):
            gauge = 2 * layer_number + side
            fine = np.sqrt(1 - LOCAL**2) * local[0] + LOCAL * local[1 + gauge]
            gain = 1 + 0.05 * rng.standard_normal()
            pressed = layer.normal_v_n * (1 + 0.1 * rng.standard_normal()) * (touch.force_n + fine)
            bent = sign * layer.shear_v_n * (shear + fine)
            rows.append(gain * _through(layer, bent + pressed, fast))
    volts = resample(Signal(np.stack(rows).astype(np.float32), fast, "V", GAUGES), rate)
    noisy = volts.samples + NOISE_V * rng.standard_normal(volts.samples.shape)
    return Recording(
        streams={"strain": volts.with_samples(np.round(noisy / STEP_V) * STEP_V)},
        material=plate.name,
        speed_mm_s=task.speed_mm_s,
        force_n=SENSOR.force_n,
        direction_deg=round(direction, 2),
        contactor=SENSOR.name,
        session=f"{plate.name}-m{task.take:02d}",
        subject="simulated",
        labels={"recording": str(task.take), "made": plate.made},
        source=source,
        history=(
            f"simulated set {task.set_name}, seed {task.seed}",
            f"contact at {fast:g} Hz: height field, resonant contact, LuGre friction",
            f"four strain gauges in two layers; stable from {STABLE_S[0]:g} to {task.seconds - STABLE_S[0]:g} s",
        ),
        simulated=True,
    )


def _fine_force(
    plate: Plate, place_m: NDArray[np.float64], rate: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the force of the finest roughness on the pad, N: its mass stays, spring and damper give way."""
    heights = fine_heights(plate, SENSOR, place_m + rng.random(), rng)
    return np.asarray(SENSOR.stiffness_n_m * heights + SENSOR.damping_n_s_m * np.gradient(heights) * rate)


def _through(layer: Layer, force: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """Return a force as the gauges of a layer sense it, of gain 1 at rest."""
    w = 2 * np.pi * layer.resonance_hz
    b, a = scipy.signal.bilinear([w**2], [1, 2 * layer.damping * w, w**2], rate)
    return np.asarray(scipy.signal.lfilter(b, a, force, zi=force[0] * scipy.signal.lfilter_zi(b, a))[0])

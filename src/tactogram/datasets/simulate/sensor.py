"""Simulated accelerometer: orientation, gravity, band, noise, quantisation, losses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.signal import Signal
from tactogram.signal.resampling import resample
from tactogram.signal.timing import to_uniform

GRAVITY = 9.80665
AXES = ("x", "y", "z")


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
    felt = acceleration.copy()
    felt[2] += GRAVITY
    clock = sensor.rate * (1 + sensor.clock * rng.standard_normal())
    # The resampler is the sensor's anti-aliasing filter: its pass band ends below half the rate.
    turned = Signal(turn(felt, angles).astype(np.float32), rate, "m/s^2", AXES)
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

"""From accelerations at the contact to what an accelerometer says: orientation, gravity, band, noise, steps, losses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.signal import Signal
from tactogram.signal.filters import resample
from tactogram.signal.timing import to_uniform

GRAVITY = 9.80665
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Sensor:
    """An accelerometer.

    Parameters
    ----------
    rate : float, Hz
    noise : float
        Density, m/s^2 per root Hz.
    step : float
        Quantisation, m/s^2.
    range : float
        Largest magnitude, m/s^2.
    jitter : float
        Of the sampling instants, as a share of the period, rms.
    packet : int
        Samples per radio packet; 1 is a wire.
    lost : float
        Share of packets that do not arrive.
    """

    rate: float
    noise: float
    step: float
    range: float
    jitter: float = 0.0
    packet: int = 1
    lost: float = 0.0


def wireless(rate: float = 330.0) -> Sensor:
    """Return the ADXL345 of Saga et al.: 4 mg steps, ten samples a packet, 33 packets a second, some of them lost.

    Noise 290 ug per root Hz (x, y; the data sheet gives 430 for z).
    """
    return Sensor(rate, 290e-6 * GRAVITY, 4e-3 * GRAVITY, 16 * GRAVITY, jitter=0.02, packet=10, lost=0.004)


def wired(rate: float = 1000.0) -> Sensor:
    """Return a wired analogue accelerometer: 100 ug per root Hz, 16 bits over 16 g, no losses."""
    return Sensor(rate, 100e-6 * GRAVITY, 32 * GRAVITY / 2**16, 16 * GRAVITY)


def sense(
    acceleration: NDArray[np.float64],
    rate: float,
    angles: NDArray[np.float64],
    sensor: Sensor,
    rng: np.random.Generator,
) -> Signal:
    """Return what ``sensor`` says.

    Parameters
    ----------
    acceleration : float64 array, shape (3, time), m/s^2
        Along the stroke, across it, out of the surface.
    rate : float, Hz
        Of ``acceleration``, well above the sensor's.
    angles : float64 array, shape (3, time), radians
        How the sensor is turned about x, y and z; small rotations after each other.
    rng : numpy Generator

    Returns
    -------
    Signal
        Axes x, y, z, m/s^2, at the sensor's rate. Lost packets were bridged by straight lines and the jittered
        instants made even (`tactogram.signal.timing.to_uniform`), as a receiver would.
    """
    felt = acceleration.copy()
    felt[2] += GRAVITY
    turned = _turn(felt, angles)
    # The anti-aliasing filter of the sensor is the resampler's: pass band to half the output rate.
    sampled = resample(Signal(turned.astype(np.float32), rate, "m/s^2", AXES), sensor.rate).samples.astype(
        np.float64
    )
    n = sampled.shape[1]
    times = np.arange(n) / sensor.rate
    if sensor.jitter:
        # What is read a little late differs by slope times lateness: small against the period.
        late = sensor.jitter / sensor.rate * np.clip(rng.standard_normal(n), -3, 3)
        sampled = sampled + np.gradient(sampled, 1 / sensor.rate, axis=1) * late
        times = times + late
    density = np.array([1.0, 1.0, 1.5])[:, None] * sensor.noise
    sampled = sampled + density * np.sqrt(sensor.rate / 2) * rng.standard_normal((3, n))
    sampled = np.clip(np.round(sampled / sensor.step) * sensor.step, -sensor.range, sensor.range)
    if sensor.packet > 1:
        packets = -(-n // sensor.packet)
        arrived = rng.random(packets) >= sensor.lost
        arrived[[0, -1]] = True
        kept = np.repeat(arrived, sensor.packet)[:n]
        bridged = np.stack([np.interp(times, times[kept], row[kept]) for row in sampled])
        return to_uniform(times, bridged, "m/s^2", axes=AXES, rate=sensor.rate)
    return Signal(sampled.astype(np.float32), sensor.rate, "m/s^2", AXES)


def _turn(v: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return vectors turned about x, then y, then z."""
    for axis, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        c, s = np.cos(angles[axis]), np.sin(angles[axis])
        v = v.copy()
        v[i], v[j] = c * v[i] - s * v[j], s * v[i] + c * v[j]
    return v

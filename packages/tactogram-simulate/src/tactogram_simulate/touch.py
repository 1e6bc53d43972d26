"""Simulated bare finger on a metal plate and on an ultrasonic display: skin vibration, friction, relief.

Simulated raters score by these quantities alone, which are the same for plates and display; only relief is missing on a
display.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.fft import rfft2

from tactogram.errors import ParameterError
from tactogram.signal import Signal, resample
from tactogram_simulate.contact import FINGER, feel
from tactogram_simulate.materials import Plate, fine_heights
from tactogram_simulate.stroke import stroke
from tactogram_simulate.surfaces import Surface, frequencies, height_field

RATE = 8000.0
SPEED_MM_S = 60.0
"""Speed of a freely exploring finger. Our assumption, the same on plates and display."""
FORCE_N = 0.6
SKIN = (2e-4, 1.5, 1000.0)
"""Mass kg, damping N s/m, stiffness N/m of the skin under a finger: elastic below and viscous above about 100 Hz
(Wiertlewski & Hayward 2012, J. Biomech. 45:1869)."""
BARE_FINGER = replace(FINGER, name="bare finger", radius_mm=0.6)
"""Heights are averaged over the resolution of a receptor near the surface, about 1 mm (Johnson & Phillips 1981,
J. Neurophysiol. 46:1177), not over the whole contact."""
CARRIER_HZ, QUALITY = 28_200.0, 100.0
"""Resonance of the Langevin transducer, and its quality with a finger on it, our assumption: the envelope passes a
first-order low-pass at carrier / (2 quality) = 141 Hz."""
HORN_FRICTION, LUBRICATED, HALF = 0.8, 0.7, 0.2
"""Friction of the horn at rest, the share by which full vibration reduces it, and the envelope of half that reduction:
friction falls with amplitude and saturates (Wiertlewski, Friesen, Colgate 2016, PNAS 113:9210)."""
COARSE_MM, FELT_EDGE_MM = 1.0, 0.2

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class FingerSlide:
    """Contact quantities of a sliding finger."""

    skin: Signal  # displacement of the skin, m, axes along and normal, 1 s at 8 kHz
    friction: float  # mean coefficient of friction
    drag: Array  # coefficient of friction over time, at the rate of skin
    relief_mm: float  # rms height of structures coarser than `COARSE_MM`; 0 on a display
    steepness: float  # rms slope of structures coarser than `FELT_EDGE_MM`; 0 on a display


@lru_cache(maxsize=32)
def plate_touched(plate: Plate) -> FingerSlide:
    """Return the quantities of a bare finger on a plate at `SPEED_MM_S` and `FORCE_N`."""
    return _touched(plate.surface, plate, np.random.default_rng(int(plate.name[-2:])))


def surface_touched(surface: Surface) -> FingerSlide:
    """Return the quantities of a bare finger on a surface at `SPEED_MM_S` and `FORCE_N`."""
    return _touched(surface, None, np.random.default_rng(zlib.crc32(f"{surface.name} touched".encode())))


def _touched(surface: Surface, plate: Plate | None, rng: np.random.Generator) -> FingerSlide:
    """Return the quantities of a bare finger on a surface, and on the finest roughness if it is that of a plate."""
    fast = 2 * RATE
    moved = stroke(
        rng,
        seconds=1.5,
        rate=fast,
        speed_mm_s=SPEED_MM_S,
        force_n=FORCE_N,
        back_and_forth=False,
        unsteadiness=0.0,
    )
    touch = feel(surface, BARE_FINGER, moved, start_mm=(5.0, 5.0), direction_deg=4.0)
    both = np.stack([touch.friction_n, touch.force_n])
    if plate is not None:
        heights = fine_heights(plate, BARE_FINGER, touch.place_m, rng)
        both += BARE_FINGER.stiffness_n_m * heights + BARE_FINGER.damping_n_s_m * np.gradient(heights) * fast
    forces = resample(Signal(both.astype(np.float32), fast, "N", ("along", "normal")), RATE).samples.astype(
        np.float64
    )
    middle = slice(round(0.25 * RATE), round(1.25 * RATE))
    drag = (forces[0] / np.maximum(forces[1], 0.1 * forces[1].mean()))[middle]
    relief_mm, steepness = _relief(surface)
    skin = _skin(forces)[:, middle]
    return FingerSlide(_moved(skin), float(drag.mean()), drag, relief_mm, steepness)


def display_touched(drive: Signal) -> FingerSlide:
    """Return the quantities of a bare finger on the simulated ultrasonic display that plays ``drive`` as a loop.

    The carrier is amplitude-modulated with depth 1, so its envelope is (1 + x) / 2 of the largest vibration; the
    transducer's resonance passes the envelope as a first-order low-pass, friction falls with it, and the skin follows
    the drag. ``drive`` has one axis and unit 1, full scale -1 to 1, beyond which it is clipped as by an amplifier, and
    lasts at least 0.1 s.
    """
    if drive.unit != "1" or len(drive.axes) != 1 or drive.domain != "time":
        raise ParameterError(
            f"a display is driven by one axis of unit 1 over time, got {len(drive.axes)} of {drive.unit} over "
            f"{drive.domain}"
        )
    if drive.seconds < 0.1:
        raise ParameterError(f"a drive signal must last at least 0.1 s, got {drive.seconds:g} s")
    count = round(RATE)
    loop = np.clip(drive.samples, -1, 1)
    thrice = drive.with_samples(np.tile(loop, -(-3 * round(drive.rate) // len(drive))))
    # The ends of the resampled signal are not part of the loop, and the skin settles in its first second.
    x = resample(thrice, RATE).samples[0, count // 2 :][: 2 * count].astype(np.float64)
    corner = 2 * np.pi * CARRIER_HZ / (2 * QUALITY)
    b, a = scipy.signal.bilinear([corner], [1, corner], RATE)
    envelope = np.clip(scipy.signal.lfilter(b, a, (1 + x) / 2, zi=[(1 + x[0]) / 2 * (1 - b[0])])[0], 0, 1)
    gone = LUBRICATED * envelope**2 / (envelope**2 + HALF**2)
    drag = HORN_FRICTION * (1 - gone)
    forces = np.stack([FORCE_N * drag, np.full(len(drag), FORCE_N)])
    skin = _skin(forces)[:, count:]
    return FingerSlide(_moved(skin), float(drag[count:].mean()), drag[count:], 0.0, 0.0)


def _skin(forces: Array) -> Array:
    """Return the displacement of the skin, m, by forces (axis, time), N: m x'' + b x' + k x = F."""
    mass, damping, stiffness = SKIN
    b, a = scipy.signal.bilinear([1.0], [mass, damping, stiffness], RATE)
    rest = scipy.signal.lfilter_zi(b, a)
    return np.stack([scipy.signal.lfilter(b, a, row, zi=row[0] * rest)[0] for row in forces])


def _moved(skin: Array) -> Signal:
    return Signal((skin - skin.mean(1, keepdims=True)).astype(np.float32), RATE, "m", ("along", "normal"))


def _relief(surface: Surface) -> tuple[float, float]:
    """Return rms height of the coarse and rms slope of all but the finest structures, by Parseval's theorem."""
    ky, kx = frequencies()
    k = np.hypot(ky, kx)
    heights = height_field(surface)
    power = np.abs(rfft2(heights)) ** 2 / heights.size**2
    # Half of the plane is stored; its inner columns count twice.
    power[:, 1:-1] *= 2
    coarse = power[k <= 1 / COARSE_MM].sum()
    slope = (power * (2 * np.pi * k) ** 2)[k <= 1 / FELT_EDGE_MM].sum()
    return float(np.sqrt(coarse)), float(np.sqrt(slope))

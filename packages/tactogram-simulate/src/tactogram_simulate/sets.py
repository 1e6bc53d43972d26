"""Simulated sets by name, and the simulation of one recording; `studies` simulates the ratings."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tactogram.datasets import Recording
from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal, resample
from tactogram_simulate.contact import (
    FINGER,
    FINGERTIP,
    PEN,
    STYLUS,
    Contactor,
    ContactSignals,
    feel,
    responded,
)
from tactogram_simulate.fabrics import FABRICS, fabric
from tactogram_simulate.materials import EVERYDAY, PLATES, STROKING_9, STROKING_30
from tactogram_simulate.photo import photograph, photographs
from tactogram_simulate.random_surfaces import random_contactor, random_stroke, random_surface
from tactogram_simulate.sensor import AXES, SENSOR, Sensor, sense, trace_plate, wired, wireless
from tactogram_simulate.stroke import RecordingTask, Stroke, slow_noise, stroke
from tactogram_simulate.surfaces import PATCH_MM, Surface

INTERNAL_RATE = 8000.0
"""Lowest rate of the contact simulation, Hz, which runs at a multiple of the sensor's rate."""
SLOW_RATE = 100.0
"""Rate of force and position, Hz, as in real collections. Friction has the rate of a wired accelerometer."""
RANDOM = "surfaces"
"""The set of surfaces drawn at random."""
RANDOM_SURFACES = 100
"""Surfaces of it, unless stated."""
RAMP_S = 0.25
MOUNT_DEG, TREMOR_DEG = 6.0, 1.0
"""Variation of the sensor's orientation between takes and within one, about each axis, rms."""


@dataclass(frozen=True)
class SimulatedSet:
    """Layout of a set: surfaces, contactors, speeds, lengths, repetitions, and the sensor."""

    title: str
    surfaces: tuple[Surface, ...]
    contactors: tuple[Contactor, ...]
    speeds_mm_s: tuple[float, ...]
    """() if each stroke has a speed and a force of its own."""
    seconds: float
    per_class: int
    sensor: Sensor
    back_and_forth: bool
    gives: Literal["vibration", "friction", "strain"] = "vibration"
    """Vibration of a contactor; friction over displacement, registered to a photograph (`fabrics`); or strain of a
    sensor's gauges on metal plates (`tactogram_simulate.sensor`)."""
    steady: bool = False
    """Whether a recording lacks the `RAMP_S` in which the hand sets off and stops."""


SETS: Mapping[str, SimulatedSet] = {
    "stroking30": SimulatedSet(
        "simulated: 15 surfaces x finger and pen at 100, 200, 400 mm/s, three 3-minute back-and-forth takes each, "
        "3 axes at 330 Hz by radio (layout of Saga et al., Sec. II)",
        STROKING_30, (FINGER, PEN), (100.0, 200.0, 400.0), 180.0, 3, wireless(), True,
    ),
    "stroking9": SimulatedSet(
        "simulated: nine surfaces rubbed by a finger in one direction, 4,000 samples of 3 axes at 1 kHz by wire "
        "(layout of Saga et al., Sec. III-B)",
        STROKING_9, (FINGER,), (100.0,), 4.0, 20, wired(), False,
    ),
    "fabrics": SimulatedSet(
        "simulated: six fabrics, four pieces each, friction of a finger over 102.4 mm, 40 samples per mm, registered "
        "to a photograph of 2048 x 1024 pixels (layout of HapTex as Cai et al. 2020 use it)",
        FABRICS, (FINGER,), (25.0,), PATCH_MM / 25.0, 4, wired(), False, "friction",
    ),
    "ultrasonic": SimulatedSet(
        "simulated: twelve metal plates, ten measurements each by four strain gauges at 20 mm/s, 0.98 N, 10 kHz; 39 "
        "signals for an ultrasonic display; ten words scored 1-7 by 32 simulated raters (layout of the study of "
        "ultrasonic_cgan)",
        tuple(plate.surface for plate in PLATES), (SENSOR,), (20.0,), 2.5, 10, wired(10_000.0), False, "strain",
    ),
    "everyday": SimulatedSet(
        f"simulated: {len(EVERYDAY)} everyday surfaces, each stroked in one direction by a finger and a stylus at "
        "random speeds (30-400 mm/s) and forces (0.2-3 N), 3 axes at 2.5 kHz by wire",
        EVERYDAY, (FINGERTIP, STYLUS), (), 2.0, 8, wired(2500.0), False, steady=True,
    ),
    RANDOM: SimulatedSet(
        "simulated: surfaces drawn at random from a population that is fitted to aggregates of recordings, each "
        "stroked in one direction by a finger and a stylus in turn at random speeds (30-400 mm/s) and forces "
        "(0.2-3 N), 3 axes at 2.5 kHz by wire; ten words scored 1-7 by simulated raters",
        (), (FINGERTIP, STYLUS), (), 2.0, 8, wired(2500.0), False, steady=True,
    ),
    "tactile_images": SimulatedSet(
        "simulated: 320 pictures of made-up materials, ten words each called evoked or not by 30 of 37 simulated "
        "raters (layout of the study of tactile_image_cgan)",
        (), (), (), 1.0, 20, wired(), False,
    ),
}  # fmt: skip


def simulated_sets() -> dict[str, str]:
    """Return the title of each set by name."""
    return {name: facts.title for name, facts in SETS.items()}


def tasks(
    set_name: str,
    *,
    seed: int,
    per_class: int | None = None,
    seconds: float | None = None,
    rate: float | None = None,
    speeds_mm_s: Sequence[float] | None = None,
    own_images: bool = True,
    random: int | None = None,
) -> list[RecordingTask]:
    """Return the recordings of surfaces of a named set, to be simulated by `make`; errors are `ParameterError`.

    Parameters
    ----------
    set_name : str
        One of `simulated_sets`.
    seed : int
        The same seed gives the same bits, whatever the order or process.
    per_class : int, optional
        Recordings per surface, contactor and speed; by default as in the paper.
    seconds : float, optional
        Length of each.
    rate : float, optional
        Rate of the accelerometer, Hz: 330, 1000, 6000 or 10000 are usual.
    speeds_mm_s : sequence of float, optional
        1 to 2000 mm/s; by default as in the paper.
    own_images : bool
        Whether each has the photograph of its surface.
    random : int, optional
        Number of surfaces of `RANDOM`, by default `RANDOM_SURFACES`. Speeds and forces of their strokes are drawn,
        speeds unless given.
    """
    facts = _set(set_name)
    surfaces = range(surface_count(set_name, random))
    takes = facts.per_class if per_class is None else per_class
    length = facts.seconds if seconds is None else seconds
    hertz = facts.sensor.rate if rate is None else rate
    if not surfaces and not (seconds is None and rate is None and speeds_mm_s is None):
        raise ParameterError(f"{set_name} holds images alone; omit seconds, rate and speeds")
    speeds = facts.speeds_mm_s if speeds_mm_s is None else tuple(speeds_mm_s)
    if takes < 1:
        raise ParameterError.must("per_class", "be at least 1", takes)
    if not 0.1 <= length <= 3600:
        raise ParameterError.must("seconds", "be 0.1 to 3600", length)
    if not 50 <= hertz <= 20_000:
        raise ParameterError.must("rate", "be 50 to 20000 Hz", hertz)
    if speeds_mm_s is not None and (not speeds or not all(1 <= speed <= 2000 for speed in speeds)):
        raise ParameterError.must("speeds", "be 1 to 2000 mm/s each", ", ".join(map("{:g}".format, speeds)))
    if len(set(speeds)) < len(speeds):
        raise ParameterError.must("speeds", "differ", ", ".join(map("{:g}".format, speeds)))
    if seed < 0:
        raise ParameterError.must("seed", "be >= 0", seed)
    if not facts.speeds_mm_s:
        strokes = []  # at any speed, unless some are given, and at any force
        for surface in surfaces:
            for index in range(takes * max(1, len(speeds))):
                drawn, force = random_stroke(seed, surface, index)
                speed = speeds[index // takes] if speeds else drawn
                by = facts.contactors[index % len(facts.contactors)].name
                own = {"own_image": own_images}
                strokes.append(
                    RecordingTask(set_name, seed, surface, by, speed, index + 1, length, hertz, force, **own)
                )
        return strokes
    return [
        RecordingTask(set_name, seed, surface, by.name, speed, take, length, hertz, own_image=own_images)
        for surface in surfaces
        for by in facts.contactors
        for speed in speeds
        for take in range(1, takes + 1)
    ]


def surface_count(set_name: str, random: int | None = None) -> int:
    """Return the number of surfaces of a set, of which `RANDOM` has ``random``."""
    if random is not None and (set_name != RANDOM or random < 1):
        raise ParameterError.must("random", f"be at least 1, of {RANDOM}; got {random} of {set_name}")
    return (random or RANDOM_SURFACES) if set_name == RANDOM else len(_set(set_name).surfaces)


def surface_photographs(
    set_name: str, count: int, *, seed: int = 0, random: int | None = None
) -> Iterator[tuple[str, Image]]:
    """Return ``count`` photographs of each surface of a set (at most 9), of places that do not overlap, with its name.

    They go into a store whose recordings have no images of their own (``own_images=False``). ``seed`` and ``random``
    say which surfaces `RANDOM` has, as in `tasks`.
    """
    facts = _set(set_name)
    numbers = range(surface_count(set_name, random))
    surfaces = (_surface(set_name, seed, number) for number in numbers)
    if count and facts.gives == "friction":
        raise ParameterError(
            f"each recording of {set_name} has its own photograph; photographs must be 0, got {count}"
        )
    return ((surface.name, image) for surface in surfaces for image in photographs(surface, count))


def _surface(set_name: str, seed: int, number: int) -> Surface:
    return random_surface(seed, number) if set_name == RANDOM else SETS[set_name].surfaces[number]


def _set(set_name: str) -> SimulatedSet:
    if set_name not in SETS:
        raise ParameterError.one_of("simulated set", SETS, set_name)
    return SETS[set_name]


def make(task: RecordingTask) -> Recording:
    """Return one simulated recording, which depends on ``task`` alone."""
    facts = SETS[task.set_name]
    if facts.gives == "strain":
        return trace_plate(PLATES[task.surface], task)
    if facts.gives == "friction":
        return fabric(facts.surfaces[task.surface], task)
    return _stroked(task, facts)


def _stroked(task: RecordingTask, facts: SimulatedSet) -> Recording:
    """Return the acceleration of a contactor, with force, position and friction."""
    surface = _surface(task.set_name, task.seed, task.surface)
    contactor = next(each for each in facts.contactors if each.name == task.contactor)
    if task.set_name == RANDOM:
        contactor = random_contactor(task.seed, task.surface, contactor)
    source = f"{task.set_name}/{surface.name}-{contactor.name}-{task.speed_mm_s:g}/{task.take}"
    rng = np.random.default_rng(np.random.SeedSequence([task.seed, zlib.crc32(source.encode())]))
    rate = task.rate * max(2.0, np.ceil(INTERNAL_RATE / task.rate))
    # Takes differ in force, direction and wear, and the sensor is mounted anew for each.
    force = task.force_n or contactor.force_n * np.exp(0.15 * rng.standard_normal())
    direction = 3 + 8 * rng.standard_normal()
    moved = stroke(
        rng,
        seconds=task.seconds + 2 * RAMP_S * facts.steady,
        rate=rate,
        speed_mm_s=task.speed_mm_s * (1 + 0.05 * np.clip(rng.standard_normal(), -3, 3)),
        force_n=force,
        back_and_forth=facts.back_and_forth,
    )
    touch = feel(
        surface,
        contactor,
        moved,
        start_mm=(PATCH_MM * rng.random(), PATCH_MM * rng.random()),
        direction_deg=direction,
        wear=np.exp(0.1 * rng.standard_normal()),
    )
    mount = np.deg2rad([0, contactor.pitch_deg, 0] + MOUNT_DEG * rng.standard_normal(3))[:, None]
    angles = mount + np.deg2rad(TREMOR_DEG) * np.stack(
        [slow_noise(rng, len(moved.path_mm), rate, 1.5) for _ in AXES]
    )
    sensor = replace(facts.sensor, rate=task.rate)
    moved_by = responded(np.stack([touch.along, touch.across, touch.normal]), rate, contactor)
    acceleration, lost = sense(moved_by, rate, angles, sensor, rng)
    streams = {"acceleration": acceleration} | _others(touch, moved, direction, sensor)
    if facts.steady:
        streams = {name: _steady(signal, task.seconds) for name, signal in streams.items()}
    return Recording(
        streams=streams,
        image=photograph(surface) if task.own_image else None,
        material=surface.name,
        speed_mm_s=task.speed_mm_s,
        force_n=round(float(force), 3),
        direction_deg=round(float(direction), 2),
        contactor=contactor.name,
        session=f"take-{task.take}",
        subject="simulated",
        labels={"recording": str(task.take)},
        source=source,
        history=(
            f"simulated set {task.set_name}, seed {task.seed}",
            f"contact at {rate:g} Hz: height field, resonant contact, LuGre friction",
            f"accelerometer of {task.rate:g} Hz with gravity, noise and steps of {sensor.step:.2g} m/s^2",
            *(
                [f"{lost} radio packets of {sensor.packet} samples lost and bridged"]
                if sensor.packet > 1
                else []
            ),
        ),
        simulated=True,
    )


def _steady(signal: Signal, seconds: float) -> Signal:
    begin = round(RAMP_S * signal.rate)
    return signal.with_samples(signal.samples[:, begin : begin + round(seconds * signal.rate)])


def _others(touch: ContactSignals, moved: Stroke, direction_deg: float, sensor: Sensor) -> dict[str, Signal]:
    rate = moved.rate
    slow = min(SLOW_RATE, sensor.rate)
    fast = slow if sensor.packet > 1 else sensor.rate
    force = Signal(touch.force_n.astype(np.float32), rate, "N")
    drag, load = (resample(s, fast).samples for s in (force.with_samples(touch.friction_n), force))
    angle = np.deg2rad(direction_deg)
    along, across = touch.place_m, 1e-3 * moved.sideways_mm
    cos, sin = np.cos(angle), np.sin(angle)
    position = [along * cos - across * sin, along * sin + across * cos]
    pressed = resample(force, slow)
    return {
        "force": pressed.with_samples(np.maximum(pressed.samples, 0)),
        "position": resample(Signal(np.stack(position).astype(np.float32), rate, "m", ("x", "y")), slow),
        # The ratio is undefined where the contactor hops: the divisor is at least a tenth of the mean force.
        "friction": Signal(drag / np.maximum(load, 0.1 * load.mean()), fast, "1", ("along",)),
    }

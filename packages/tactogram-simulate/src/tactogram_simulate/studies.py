"""Simulated rating studies, of plates and display signals that are touched and of images; the display signals.

The study's own 39 are not at hand ("arbitrary signals", Sec. III-C). These are sines, squares, bursts,
amplitude-modulated tones, bands of noise, trains of pulses, sweeps and sums, some of them at several levels. They loop
without a seam: every frequency is a whole number of cycles per second, noise is periodic.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Ratings, Recording, join_ratings
from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal
from tactogram_simulate.materials import PLATES
from tactogram_simulate.random_surfaces import random_surface
from tactogram_simulate.raters import (
    TouchCues,
    draw_people,
    score_images,
    score_plates,
    score_surfaces,
    score_vibrations,
    surface_cues,
)
from tactogram_simulate.sets import RANDOM, surface_count
from tactogram_simulate.surfaces import Surface
from tactogram_simulate.tactile_images import FAMILIES, tactile_image

PER_FAMILY = 20
"""16 families of 20 images are the 320 of the cross-modal study, Sec. II-B."""
IMAGE_SETS = 4
"""Sets into which the images are dealt; 30 of the 37 raters rate each."""
RATERS: Mapping[str, int] = {"ultrasonic": 32, "tactile_images": 37, RANDOM: 20}
"""Number of raters by set."""
COUNT = 39
"""The study's own number: 1,248 answers by 32 people. Sec. III-C."""
RATE, SAMPLES = 10_000.0, 10_000
"""Hz, and one second."""
_T = np.arange(SAMPLES) / RATE


@dataclass(frozen=True, eq=False)
class SimulatedStudyData:
    """Data of a simulated study besides recordings of surfaces.

    Recordings are display signals, photographs pairs of item and image.
    """

    recordings: tuple[Recording, ...]
    photographs: tuple[tuple[str, Image], ...]
    ratings: Ratings


def study(
    set_name: str,
    *,
    seed: int,
    per_class: int | None = None,
    raters: int | None = None,
    signals: int | None = None,
    random: int | None = None,
    each: Callable[[Callable[[Surface], TouchCues], list[Surface]], Iterable[TouchCues]] = map,
) -> SimulatedStudyData | None:
    """Return the content of a named set besides its recordings of surfaces; None for a set without ratings.

    ``seed`` determines people and images; plates and display signals are always the same. ``per_class`` is the number
    of images per family for ``tactile_images``, by default `PER_FAMILY`; ``raters`` is by default that of `RATERS`;
    ``signals`` is the number of display signals of ``ultrasonic``, by default the study's 39. ``random`` is the number
    of surfaces drawn at random, and ``each`` maps a function over them, in several processes perhaps.
    """
    if signals is not None and (set_name != "ultrasonic" or signals < 1):
        raise ParameterError.must("signals", f"be at least 1, of ultrasonic; got {signals} of {set_name}")
    if set_name not in RATERS:
        if raters is not None:
            raise ParameterError(f"{set_name} has no ratings; raters must be of {', '.join(RATERS)}")
        return None
    people = draw_people(RATERS[set_name] if raters is None else raters, seed=seed)
    if set_name == "ultrasonic":
        shown = drives(signals or COUNT)
        plate_ratings = score_plates(PLATES, people, seed=seed)
        played = score_vibrations({drive.name: drive.signal for drive in shown}, people, seed=seed)
        return SimulatedStudyData(
            tuple(drive.recording(set_name) for drive in shown), (), join_ratings([plate_ratings, played])
        )
    if set_name == RANDOM:
        surfaces = [random_surface(seed, number) for number in range(surface_count(set_name, random))]
        cues = dict(zip((surface.name for surface in surfaces), each(surface_cues, surfaces), strict=True))
        return SimulatedStudyData((), (), score_surfaces(cues, people, seed=seed))
    count = PER_FAMILY if per_class is None else per_class
    if count < 1:
        raise ParameterError.must("per_class", "be at least 1", count)
    drawn = [tactile_image(family, number, seed=seed) for number in range(count) for family in FAMILIES]
    # Shuffled, so that neither an item's name nor its set reveals its family.
    order = np.random.default_rng([seed, len(drawn)]).permutation(len(drawn))
    images = {f"image{position:03d}": drawn[number] for position, number in enumerate(order, start=1)}
    names, away = list(images), round(len(people) * 7 / 37)
    parts = []
    for number in range(IMAGE_SETS):
        # Seven of the 37 are absent from each set, others each time.
        left_out = {people[(number * away + n) % len(people)].name for n in range(away)}
        present = [person for person in people if person.name not in left_out]
        dealt = {name: images[name] for name in names[number::IMAGE_SETS]}
        parts.append(score_images(dealt, present, seed=seed, session=f"set{number + 1}"))
    return SimulatedStudyData((), tuple(images.items()), join_ratings(parts))


Array = NDArray[np.float64]


@dataclass(frozen=True)
class DisplaySignal:
    """An arbitrary signal, ``signal01``, ``signal02``, ….

    ``level`` is its peak relative to full scale; ``shape``, float64, shape (10000,), has any scale and mean.
    """

    name: str
    is_a: str
    level: float
    shape: Array

    @property
    def signal(self) -> Signal:
        """The modulating signal: axis ``drive``, unit 1, full scale -1 to 1, mean 0."""
        x = self.shape - self.shape.mean()
        return Signal((self.level * x / np.abs(x).max()).astype(np.float32), RATE, "1", ("drive",))

    def recording(self, set_name: str) -> Recording:
        """Return it as a recording without material."""
        return Recording(
            streams={"drive": self.signal},
            labels={"item": self.name, "signal": self.is_a},
            source=f"{set_name}/{self.name}",
            history=(f"simulated set {set_name}", f"modulating signal, 1 s loop: {self.is_a}"),
            simulated=True,
        )


def drives(count: int = COUNT) -> tuple[DisplaySignal, ...]:
    """Return the first ``count`` signals, which are always the same: the study's 39, then others of their kinds."""
    listed = [*_listed()[:count], *(_drawn(n) for n in range(COUNT + 1, count + 1))]
    return tuple(DisplaySignal(f"signal{n:02d}", *facts) for n, facts in enumerate(listed, start=1))


def _drawn(number: int) -> tuple[str, float, Array]:
    """Return kind, level and shape of a signal beyond the study's, drawn by its number."""
    rng = np.random.default_rng([COUNT, number])
    f, low, slow, count = (int(rng.integers(*limits)) for limits in ((4, 900), (4, 400), (4, 30), (4, 80)))
    high = low + int(rng.integers(20, 500))
    level, weight = rng.uniform(0.05, 1, 2).tolist()
    kinds: tuple[tuple[str, Callable[[], Array]], ...] = (
        (f"sine of {f} Hz", lambda: _sine(f)),
        (f"square of {slow} Hz", lambda: np.sign(_sine(slow) + 1e-9)),
        (f"bursts of {f} Hz, {slow} a second", lambda: _sine(f) * _gate(slow, 0.4)),
        (f"{f} Hz modulated at {slow} Hz", lambda: _sine(f) * (1 + _sine(slow))),
        (f"noise of {low} to {high} Hz", lambda: _noise(low, high)),
        (
            f"noise of {low} to {high} Hz, {slow} swells a second",
            lambda: _noise(low, high) * (1 + _sine(slow)),
        ),
        (f"{count} pulses of 2 ms a second", lambda: _pulses(np.arange(count) / count)),
        (f"{count} pulses of 2 ms a second, irregular", lambda: _pulses(_irregular(count))),
        (f"sweep of {low} to {high} Hz and back", lambda: _sweep(low, high)),
        (f"sum of sines of {slow} and {f} Hz", lambda: _sine(slow) + weight * _sine(f)),
    )
    is_a, shape = kinds[rng.integers(len(kinds))]
    return f"{is_a}, at {level:.3g}", level, shape()


def _listed() -> list[tuple[str, float, Array]]:
    """Return kind, level and shape of the study's 39."""
    signals = [
        (f"sine of {f} Hz", 1.0, _sine(f)) for f in (5, 10, 20, 40, 80, 120, 160, 200, 250, 320, 400, 600)
    ]
    signals += [(f"sine of 200 Hz, at {level:g}", level, _sine(200)) for level in (0.05, 0.25)]
    signals += [(f"square of {f} Hz", 1.0, np.sign(_sine(f) + 1e-9)) for f in (4, 12, 30)]
    signals += [(f"bursts of 200 Hz, {n} a second", 1.0, _sine(200) * _gate(n, 0.4)) for n in (4, 10)]
    signals += [
        (f"{carrier} Hz modulated at {f} Hz", 1.0, _sine(carrier) * (1 + _sine(f)))
        for carrier, f in ((250, 5), (160, 12), (320, 25))
    ]
    signals += [
        (f"noise of {low} to {high} Hz{'' if level == 1 else f', at {level:g}'}", level, _noise(low, high))
        for low, high, level in (
            (5, 30, 1.0), (30, 90, 1.0), (60, 200, 1.0), (100, 400, 1.0), (200, 600, 1.0), (400, 1000, 1.0),
            (20, 1000, 0.35), (250, 1000, 0.1),
        )
    ]  # fmt: skip
    signals += [(f"{n} pulses of 2 ms a second", 1.0, _pulses(np.arange(n) / n)) for n in (5, 20, 60)]
    signals += [(f"{n} pulses of 2 ms a second, irregular", 1.0, _pulses(_irregular(n))) for n in (12, 45)]
    signals += [
        (f"sweep of {low} to {high} Hz and back", 1.0, _sweep(low, high))
        for low, high in ((20, 120), (100, 500))
    ]
    signals += [
        ("sum of sines of 8 and 200 Hz", 1.0, _sine(8) + 0.6 * _sine(200)),
        ("noise of 150 to 500 Hz, swelling 6 times a second", 1.0, _noise(150, 500) * (1 + _sine(6))),
    ]
    return signals


def _sine(hz: float) -> Array:
    return np.asarray(np.sin(2 * np.pi * hz * _T))


def _gate(per_second: int, open_share: float) -> Array:
    """Return 1 while open and 0 otherwise, with cosine flanks of 5 ms."""
    time_s = (_T * per_second) % 1 / per_second
    length, flank = open_share / per_second, 0.005
    rise, fall = np.clip(time_s / flank, 0, 1), np.clip((length - time_s) / flank, 0, 1)
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.minimum(rise, fall)))


def _noise(low: int, high: int) -> Array:
    """Return periodic noise of equal amplitudes and random phases between ``low`` and ``high`` Hz."""
    rng = np.random.default_rng(zlib.crc32(f"noise {low} {high}".encode()))
    spectrum = np.zeros(SAMPLES // 2 + 1, complex)
    spectrum[low : high + 1] = np.exp(2j * np.pi * rng.random(high + 1 - low))
    return np.asarray(np.fft.irfft(spectrum, SAMPLES))


def _irregular(count: int) -> Array:
    """Return ``count`` random times within a second, at least 4 ms apart."""
    rng = np.random.default_rng(zlib.crc32(f"pulses {count}".encode()))
    slots = rng.choice(250, count, replace=False)
    return np.asarray(np.sort(slots) / 250)


def _pulses(moments: Sequence[float] | Array) -> Array:
    """Return raised-cosine pulses of 2 ms at ``moments``, s."""
    pulse = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(20) / 20)
    x = np.zeros(SAMPLES)
    for moment in moments:
        x[(round(moment * RATE) + np.arange(20)) % SAMPLES] += pulse
    return x


def _sweep(low: float, high: float) -> Array:
    """Return a sine whose frequency goes from ``low`` to ``high`` and back, in whole periods."""
    hz = low + (high - low) * (0.5 - 0.5 * np.cos(2 * np.pi * _T))
    turns = np.cumsum(hz) / RATE
    return np.asarray(np.sin(2 * np.pi * turns * round(turns[-1]) / turns[-1]))

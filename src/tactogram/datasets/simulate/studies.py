"""Simulated rating studies: plates and display signals that are touched, and images that are seen."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from tactogram.datasets.ratings.ratings import Ratings, join_ratings
from tactogram.datasets.recording import Recording
from tactogram.datasets.simulate.display_signals import COUNT, drives
from tactogram.datasets.simulate.metal_plates import PLATES
from tactogram.datasets.simulate.random_surfaces import random_surface
from tactogram.datasets.simulate.raters import (
    TouchCues,
    draw_people,
    score_images,
    score_plates,
    score_surfaces,
    score_vibrations,
    surface_cues,
)
from tactogram.datasets.simulate.sets import RANDOM, surface_count
from tactogram.datasets.simulate.surfaces import Surface
from tactogram.datasets.simulate.tactile_images import FAMILIES, tactile_image
from tactogram.errors import ParameterError
from tactogram.signal import Image

PER_FAMILY = 20
"""16 families of 20 images are the 320 of the cross-modal study, Sec. II-B."""
IMAGE_SETS = 4
"""Sets into which the images are dealt; 30 of the 37 raters rate each."""


@dataclass(frozen=True, eq=False)
class SimulatedStudyData:
    """Data of a simulated study besides recordings of surfaces.

    Recordings are display signals, photographs pairs of item and image.
    """

    recordings: tuple[Recording, ...]
    photographs: tuple[tuple[str, Image], ...]
    ratings: Ratings


RATERS: Mapping[str, int] = {"ultrasonic": 32, "tactile_images": 37, RANDOM: 20}
"""Number of raters by set."""


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
        raise ParameterError(f"signals must be at least 1, of ultrasonic; got {signals} of {set_name}")
    if set_name not in RATERS:
        if raters is not None:
            raise ParameterError(f"{set_name} has no ratings; raters must be of {', '.join(RATERS)}")
        return None
    people = draw_people(RATERS[set_name] if raters is None else raters, seed=seed)
    if set_name == "ultrasonic":
        shown = drives(signals or COUNT)
        felt = score_plates(PLATES, people, seed=seed)
        played = score_vibrations({drive.name: drive.signal for drive in shown}, people, seed=seed)
        return SimulatedStudyData(
            tuple(drive.recording(set_name) for drive in shown), (), join_ratings([felt, played])
        )
    if set_name == RANDOM:
        surfaces = [random_surface(seed, number) for number in range(surface_count(set_name, random))]
        cues = dict(zip((surface.name for surface in surfaces), each(surface_cues, surfaces), strict=True))
        return SimulatedStudyData((), (), score_surfaces(cues, people, seed=seed))
    count = PER_FAMILY if per_class is None else per_class
    if count < 1:
        raise ParameterError(f"per_class must be at least 1, got {count}")
    made = [tactile_image(family, number, seed=seed) for number in range(count) for family in FAMILIES]
    # Shuffled, so that neither an item's name nor its set reveals its family.
    order = np.random.default_rng([seed, len(made)]).permutation(len(made))
    images = {f"image{place:03d}": made[number] for place, number in enumerate(order, start=1)}
    names, away = list(images), round(len(people) * 7 / 37)
    parts = []
    for number in range(IMAGE_SETS):
        # Seven of the 37 are absent from each set, others each time.
        left_out = {people[(number * away + n) % len(people)].name for n in range(away)}
        present = [person for person in people if person.name not in left_out]
        dealt = {name: images[name] for name in names[number::IMAGE_SETS]}
        parts.append(score_images(dealt, present, seed=seed, session=f"set{number + 1}"))
    return SimulatedStudyData((), tuple(images.items()), join_ratings(parts))

"""Simulated raters, and their scores of plates and vibrations, of images, and of both together."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import EVOKED, SEVEN_POINT, WORDS, Ratings, Scale
from tactogram.errors import ParameterError
from tactogram.signal import Image, Signal
from tactogram_simulate.materials import Plate
from tactogram_simulate.raters.rules import (
    TouchCues,
    sight_cues,
    sight_words,
    touch_cues,
    touch_words,
)
from tactogram_simulate.surfaces import Surface
from tactogram_simulate.touch import display_touched, plate_touched, surface_touched

LEAN, LEAN_WORD, SPREAD, SENSITIVITY_DB, OWN_TASTE = 0.45, 0.35, 0.20, 4.0, 0.55
"""Standard deviations over people: of the bias on all words and on single ones (points of 7), of the logarithm of the
used share of the scale, of the sensitivity to vibration (dB), and of personal taste per item and word (points of 7).
Our assumptions, so that raters agree as moderately as untrained people: docs/simulated-raters.md has the figures."""
SIGHT_LEAN, SIGHT_WORD, SIGHT_TASTE = 0.5, 0.5, 0.8
"""The same for yes or no to an image, in logits."""


@dataclass(frozen=True, eq=False)
class SimulatedRater:
    """A simulated rater."""

    name: str
    seed: int  # of everything else that is random about this person
    lean: NDArray[np.float64]  # shape (word,), points of 7
    spread: float  # factor of distances from the middle of the scale
    sensitivity_db: float  # added to the level of every vibration
    yes: NDArray[np.float64]  # shape (word,), logits: readiness to call a word evoked by an image

    def rng(self, *about: str) -> np.random.Generator:
        """Return this person's random generator for some purpose, always in the same state."""
        keys = [zlib.crc32(text.encode()) for text in (self.name, *about)]
        return np.random.default_rng(np.random.SeedSequence([self.seed, *keys]))


def draw_people(count: int, *, seed: int, prefix: str = "rater") -> tuple[SimulatedRater, ...]:
    """Return ``count`` simulated people, ``rater01`` and so on; another prefix or seed gives other people."""
    if count < 1:
        raise ParameterError(f"at least one simulated rater is needed, got {count}")
    if seed < 0:
        raise ParameterError.must("seed", "be >= 0", seed)
    return tuple(_person(f"{prefix}{number:02d}", seed) for number in range(1, count + 1))


def _person(name: str, seed: int) -> SimulatedRater:
    rng = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(name.encode())]))
    draw = rng.standard_normal
    return SimulatedRater(
        name,
        seed,
        LEAN * draw() + LEAN_WORD * draw(len(WORDS)),
        float(np.exp(SPREAD * draw())),
        float(SENSITIVITY_DB * draw()),
        SIGHT_LEAN * draw() + SIGHT_WORD * draw(len(WORDS)),
    )


NOISE = 0.75
"""Standard deviation of one person's repeated scores, points of 7."""
WARMING, WARMING_ITEMS = 0.25, 5.0
"""Contraction of the first score towards the middle of the scale, and the items over which it decays. Judgments are
contracted (Poulton 1979, Psychol. Bull. 86:777); that it is most at first, and how much, is our assumption."""
CONTRAST = 0.06
"""Share of the last item's distance from the middle that is subtracted from the next: transfer (Poulton 1979). Our
figure."""
MISSING = 0.004
"""Share of missing scores."""
SIGHT_SD: Mapping[str, float] = {
    "dry": 1.0, "sleek": 0.9, "slippery": 0.9, "rugged": 0.7, "uneven": 0.7,
    "rough": 1.0, "squishy": 0.8, "prickle": 1.0, "sticky": 1.1, "rustle": 1.2,
}  # fmt: skip
TOUCH_SD: Mapping[str, float] = {
    "dry": 1.0, "sleek": 0.9, "slippery": 0.8, "rugged": 1.2, "uneven": 1.2,
    "rough": 1.0, "squishy": 1.0, "prickle": 0.9, "sticky": 0.8, "rustle": 1.0,
}  # fmt: skip
"""Standard deviation of each sense per word, points of 7: the smaller, the higher its weight. Equal for roughness, for
which vision and touch weigh about equal (Lederman, Thorne & Jones 1986); smaller in vision for shape (rugged, uneven)
and in touch for friction and prickle. The figures are our assumptions."""

Array = NDArray[np.float64]
Met = TypeVar("Met")


def score_plates(plates: Sequence[Plate], people: Sequence[SimulatedRater], *, seed: int) -> Ratings:
    """Return the simulated scores of metal plates that are touched unseen, 1 to 7; order random for each person."""
    cues = {plate.name: touch_cues(plate_touched(plate)) for plate in plates}
    return _scored(cues, _by_touch, people, seed, "plates")


def score_surfaces(cues: Mapping[str, TouchCues], people: Sequence[SimulatedRater], *, seed: int) -> Ratings:
    """Return the simulated scores of surfaces that are touched unseen, 1 to 7, by the `surface_cues` of each."""
    return _scored(cues, _by_touch, people, seed, "surfaces")


def surface_cues(surface: Surface) -> TouchCues:
    """Return the tactile cues of a surface."""
    return touch_cues(surface_touched(surface))


def score_vibrations(
    signals: Mapping[str, Signal], people: Sequence[SimulatedRater], *, seed: int
) -> Ratings:
    """Return the simulated scores of drive signals on the simulated ultrasonic display, 1 to 7.

    ``signals`` are as `tactogram_simulate.touch.display_touched` takes them; ``seed`` determines the order and
    the variation of repeated scores.
    """
    cues = {item: touch_cues(display_touched(x)) for item, x in signals.items()}
    return _scored(cues, _by_touch, people, seed, "signals")


def score_images(
    images: Mapping[str, Image], people: Sequence[SimulatedRater], *, seed: int, session: str = "images"
) -> Ratings:
    """Return whether simulated people call each word evoked by each image, 0 or 1."""
    seen = {item: sight_words(sight_cues(image)) for item, image in images.items()}
    return _scored(seen, _by_sight, people, seed, session, EVOKED)


def score_together(
    pairs: Mapping[str, tuple[Signal, Image]], people: Sequence[SimulatedRater], *, seed: int
) -> Ratings:
    """Return the simulated scores, 1 to 7, of vibrations touched while an image is seen.

    Each word is estimated by touch (as `score_vibrations`) and by sight (1 + 6 times the probability that the image
    evokes it), and the two are weighted by their reliability 1 / sd^2, the maximum-likelihood rule of Ernst & Banks
    (2002, Nature 415:429): `SIGHT_SD` and `TOUCH_SD`.
    """
    met = {
        item: (touch_cues(display_touched(signal)), sight_words(sight_cues(image)))
        for item, (signal, image) in pairs.items()
    }
    return _scored(met, _by_both, people, seed, "together")


def sight_weight() -> Array:
    """Return the weight of sight against touch for each word, 0 to 1, float64, shape (word,)."""
    sight, touch = (np.array([sd[word] for word in WORDS]) ** -2 for sd in (SIGHT_SD, TOUCH_SD))
    return np.asarray(sight / (sight + touch))


def _by_touch(person: SimulatedRater, item: str, cues: TouchCues) -> Array:
    """Return a person's scores before rounding and clipping to the scale, points of 7."""
    words = touch_words(cues, sensitivity_db=person.sensitivity_db)
    own = OWN_TASTE * person.rng("touch", item).standard_normal(len(WORDS))
    return 1 + 6 * words + own


def _by_sight(person: SimulatedRater, item: str, logits: Array) -> Array:
    """Return a person's readiness to call each word evoked, logits."""
    return logits + person.yes + SIGHT_TASTE * person.rng("sight", item).standard_normal(len(WORDS))


def _by_both(person: SimulatedRater, item: str, met: tuple[TouchCues, Array]) -> Array:
    seen = 1 + 6 / (1 + np.exp(-_by_sight(person, item, met[1])))
    weight = sight_weight()
    return weight * seen + (1 - weight) * _by_touch(person, item, met[0])


def _scored(
    items: Mapping[str, Met],
    judge: Callable[[SimulatedRater, str, Met], Array],
    people: Sequence[SimulatedRater],
    seed: int,
    session: str,
    scale: Scale = SEVEN_POINT,
) -> Ratings:
    """Return each person's scores of all items, in an order of their own."""
    if not items:
        raise ParameterError("items to score must be at least one, got none")
    names = sorted(items)
    rows: list[tuple[str, str, str, float, int]] = []
    for person in people:
        rng = person.rng(session, str(seed))
        before = np.zeros(len(WORDS))
        for position, number in enumerate(rng.permutation(len(names)), start=1):
            item = names[number]
            opinion = judge(person, item, items[item])
            noise = rng.standard_normal(len(WORDS))
            missing = rng.random(len(WORDS)) < MISSING
            if scale is EVOKED:
                # The noise of a yes or no is logistic, so that the share of yes is the logistic of the opinion.
                scores = (opinion + np.log(1 / rng.random(len(WORDS)) - 1) > 0).astype(float)
            else:
                away = (opinion - 4) * person.spread * (1 - WARMING * np.exp(-(position - 1) / WARMING_ITEMS))
                score = 4 + person.lean + away - CONTRAST * before + NOISE * noise
                scores, before = np.clip(np.round(score), 1, 7), away
            rows += [
                (person.name, item, word, float(score), position)
                for word, score, absent in zip(WORDS, scores, missing, strict=True)
                if not absent
            ]
    raters, rated, words, values, order = zip(*rows, strict=True)
    sessions = (session,) * len(rows)
    return Ratings(raters, rated, words, np.array(values), scale, np.array(order), sessions, WORDS)

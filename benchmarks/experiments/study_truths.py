"""True values of simulated studies, in the unit of their analysis.

They are computed from the rules of the simulated participants alone, never from their answers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.special import expit, ndtr, ndtri

from tactogram_study.simulated_observer import UNIT, SimulatedEffect, typical
from tactogram_study.statistics import abx_share
from tactogram_study.study_file import Study

Truth = Callable[[SimulatedEffect, Study, int], float]
"""Function of an effect, the study as taken, and the seed of the answers."""


def expected_steps(mean: float, sd: float, low: float, high: float) -> float:
    """Return the mean of normal answers, rounded to steps and limited to the scale."""
    steps = np.arange(low, high + 1)
    edges = np.concatenate(([-np.inf], steps[:-1] + 0.5, [np.inf]))
    shares = np.diff(ndtr((edges - mean) / sd))
    return float(shares @ steps)


def two_alternatives(d: float) -> float:
    """Return the share correct with two alternatives."""
    return float(ndtr(d / math.sqrt(2)))


def share_two_area(effect: SimulatedEffect, study: Study, seed: int) -> float:
    """Return the mean share correct of "which is generated?" over people."""
    return _over_people(effect.d_prime, effect.d_prime_sd, two_alternatives)


def share_abx(effect: SimulatedEffect, study: Study, seed: int) -> float:
    """Return the mean share correct of ABX over people."""
    return _over_people(effect.d_prime, effect.d_prime_sd, abx_share)


@lru_cache(maxsize=64)
def _over_people(d_prime: float, sd: float, share: Callable[[float], float]) -> float:
    """Return the mean of a share over people whose d' is normal and at least 0."""
    if not sd:
        return share(d_prime)
    equally_likely = ndtri((np.arange(200) + 0.5) / 200)
    return float(np.mean([share(d) for d in np.maximum(0.0, d_prime + sd * equally_likely).tolist()]))


def evoked(item: str) -> Truth:
    """Return the truth of a difference in shares of evoked words; people's normal logits are integrated out."""

    def truth(effect: SimulatedEffect, study: Study, seed: int) -> float:
        nodes, weights = np.polynomial.hermite_e.hermegauss(60)
        logits = effect.between_sd / 2 * nodes
        gap = expit(effect.shift.get(item, 0.0) + logits) - expit(logits)
        return float(weights @ gap / weights.sum())

    return truth


def steps(first: str, second: str = "") -> Truth:
    """Return the truth of a difference in mean scores, between two conditions or an item and the others, in steps."""

    def truth(effect: SimulatedEffect, study: Study, seed: int) -> float:
        low, high, words = (getattr(study.design, name) for name in ("low", "high", "words"))
        sd = UNIT["steps"] * math.hypot(effect.between_sd, effect.within_sd)
        means: dict[str, list[float]] = {}
        for stimulus in study.setting.stimuli:
            # A condition with the name of its item is the item.
            names = {stimulus.item, stimulus.condition}
            shift = sum(effect.shift.get(name, 0.0) for name in names)
            for word in words:
                relative = 0.15 * typical(effect, seed, stimulus.item, word)
                mean = low + (high - low) * (0.5 + relative) + shift
                key = stimulus.condition if second else stimulus.item
                means.setdefault(key, []).append(expected_steps(mean, sd, low, high))
        whole = {key: float(np.mean(values)) for key, values in means.items()}
        others = [whole[second]] if second else [value for key, value in whole.items() if key != first]
        return whole[first] - float(np.mean(others))

    return truth


def level(item: str, correct: float) -> Truth:
    """Return the truth of the level at which a share of an item's answers is correct."""

    def truth(effect: SimulatedEffect, study: Study, seed: int) -> float:
        above = effect.spread_db * float(ndtri((correct - 0.5) / (0.5 - effect.lapse)))
        return effect.threshold_db + effect.shift.get(item, 0.0) + above

    return truth


def shifted(name: str, scale: Callable[[float], float] = float) -> Truth:
    """Return the truth of a shift on another scale."""
    return lambda effect, study, seed: float(scale(effect.shift.get(name, 0.0)))


def half(effect: SimulatedEffect, study: Study, seed: int) -> float:
    """Return 0.5."""
    return 0.5

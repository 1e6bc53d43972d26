"""Power of pairwise preferences: how often strengths are shown to differ, or to be equivalent, in many studies."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from tactogram.errors import ParameterError
from tactogram.statistics import holm_rows
from tactogram_study.analysis.bradley_terry import curvature, gap_errors, strengths_by_participant
from tactogram_study.power.assumptions import PowerAssumptions
from tactogram_study.power.methods import PowerMethod, StudyBatch, Truths

Numbers = NDArray[np.float64]
AT_ONCE = 400_000
"""Numbers in the tables of a batch of studies: as many as fit a processor's cache."""


class Strengths(PowerMethod):
    """Strengths of items by participant, with Holm's correction over all pairs."""

    of_pairs = True

    def shares(self, rng: np.random.Generator, batch: StudyBatch, truths: Truths) -> dict[str, float]:
        """Return power of pairs that differ; for ``type_1`` that any pair is shown, and equivalence."""
        found: dict[str, float] = {}
        assumed = batch.assumed
        for name, truth in truths.items():
            parts = [
                shown_and_equal(gaps, errors, people=batch.people, margin=assumed.margin, alpha=batch.alpha)
                for gaps, errors in simulated_preferences(
                    batch.people,
                    batch.trials,
                    items=assumed.items,
                    effect=truth,
                    person_sd=assumed.person_sd,
                    studies=batch.simulations,
                    rng=rng,
                )
            ]
            shown, equal = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
            if name == "power":
                found[name] = float(shown[:, : assumed.items - 1].mean())
            else:
                found[name] = float(shown.any(1).mean())
                found["equivalence"] = float(equal.mean())
                found["all_equivalent"] = float(equal.all(1).mean())
        return found

    def check(self, assumed: PowerAssumptions) -> None:
        """Raise `ParameterError` for too few or too many items."""
        if not 2 <= assumed.items <= 100:
            raise ParameterError(f"items must be from 2 to 100, got {assumed.items}")

    def notes(self) -> list[str]:
        return [
            "power: of a pair that differs; type_1: that any pair is shown where none differs; equivalence: of a pair, "
            "all_equivalent: of all pairs at once."
        ]


def simulated_preferences(
    people: int,
    comparisons: int,
    *,
    items: int,
    effect: float,
    person_sd: float,
    studies: int,
    rng: np.random.Generator,
) -> Iterator[tuple[Numbers, Numbers]]:
    """Yield, in batches of studies, each pair's difference of log strengths and its standard error.

    Both are of shape (study, pair); the first ``items - 1`` pairs are those of the first item, whose log strength is
    larger by ``effect``. Pairs are presented as equally often as the number of comparisons allows: with equal items,
    the choice of the most informative pair comes to the same.
    """
    pairs = np.array(list(combinations(range(items), 2)))
    first, second = pairs.T
    each, rest = divmod(comparisons, len(pairs))
    batch = max(1, AT_ONCE // (people * items**2))
    for begin in range(0, studies, batch):
        count = min(batch, studies - begin)
        strengths = person_sd * rng.standard_normal((count, people, items))
        strengths[..., 0] += effect
        order = np.argsort(rng.random((count, people, len(pairs))), axis=-1)
        asked = each + (order < rest)
        won = rng.binomial(asked, special.expit(strengths[..., first] - strengths[..., second]))
        tables = np.zeros((count, people, items, items))
        tables[..., first, second], tables[..., second, first] = won, asked - won
        found, covariance = strengths_by_participant(tables)
        errors, _ = gap_errors(covariance, curvature(tables.sum(1), found), first, second)
        yield found[:, first] - found[:, second], errors


def shown_and_equal(
    gaps: Numbers, errors: Numbers, *, people: int, margin: float, alpha: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which pairs are shown to differ, and which to be within the margin, each with Holm's correction.

    As `analyse_preference`, for many studies: all arrays are of shape (study, pair).
    """
    far = np.abs(gaps)
    shown = holm_rows(2 * stats.t.sf(far / errors, people - 1)) < alpha
    equal = holm_rows(stats.t.sf((margin - far) / errors, people - 1)) < alpha
    return shown, equal & ~shown

"""Power of pairwise preferences: how often strengths are shown to differ, or to be equivalent, in many studies.

Results equal those of `strengths_by_participant` with Holm's correction, without a table for each participant, who
compares few of the many pairs: the jackknife's equations are solved by conjugate gradients, preconditioned with the
inverse for all participants, which changes little when one is left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats
from scipy.sparse.linalg import LinearOperator, cg

from tactogram.errors import ParameterError
from tactogram.study.analysis.bradley_terry import bradley_terry, curvature, gap_errors
from tactogram.study.power.assumptions import PowerAssumptions
from tactogram.study.power.methods import PowerMethod, StudyBatch, Truths

Numbers = NDArray[np.float64]
Counts = NDArray[np.int64]
AT_ONCE = 400_000
"""Numbers per batch of studies, of participants and of tables of items: as many as fit a processor's cache."""
SOLVED = 1e-7
"""Residual of the jackknife's equations, relative to the first."""


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
        """Return the meaning of the columns."""
        return [
            "power: of a pair that differs; type_1: that any pair is shown where none differs; equivalence: of a pair, "
            "all_equivalent: of all pairs at once."
        ]


@dataclass(frozen=True)
class ComparisonCounts:
    """Answers of the participants of many studies by presented pair; arrays of shape (study, participant, pair)."""

    first: Counts
    second: Counts
    count: Counts
    won: Counts
    items: int

    def tables(self) -> Numbers:
        """Return how often all preferred the row's item to the column's, shape (study, item, item)."""
        studies, n = self.first.shape[0], self.items
        study = np.arange(studies)[:, None, None] * n
        summed = np.zeros(studies * n * n)
        for one, other, won in (
            (self.first, self.second, self.won),
            (self.second, self.first, self.count - self.won),
        ):
            summed += np.bincount(((study + one) * n + other).ravel(), won.ravel(), summed.size)
        return summed.reshape(studies, n, n)


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
    batch = max(1, AT_ONCE // (people * (items + min(comparisons, len(pairs))) + items**2))
    for begin in range(0, studies, batch):
        count = min(batch, studies - begin)
        strengths = person_sd * rng.standard_normal((count, people, items))
        strengths[..., 0] += effect
        place, times = _presented(comparisons, len(pairs), (count, people), rng)
        one, other = first[place], second[place]
        gap = np.take_along_axis(strengths, one, -1) - np.take_along_axis(strengths, other, -1)
        won = rng.binomial(times, special.expit(gap))
        answers = ComparisonCounts(one, other, times, won, items)
        found, covariance = jackknifed(answers)
        errors, _ = gap_errors(covariance, curvature(answers.tables(), found), first, second)
        yield found[:, first] - found[:, second], errors


def jackknifed(answers: ComparisonCounts) -> tuple[Numbers, Numbers]:
    """Return log strengths, shape (study, item), and their covariance by participant, as `strengths_by_participant`.

    The covariance, shape (study, item, item), is exact for differences between items only.
    """
    studies, people, _ = answers.first.shape
    n, size = answers.items, studies * people * answers.items
    tables = answers.tables()
    strengths = bradley_terry(tables)
    curved = curvature(tables, strengths)
    inverse = np.asarray(np.linalg.inv(curved), np.float64)
    begin = np.arange(studies * people).reshape(studies, people, 1) * n
    one, other = (begin + answers.first).ravel(), (begin + answers.second).ravel()
    theirs = np.repeat(strengths, people, axis=0).ravel()
    p = special.expit(theirs[one] - theirs[other])
    count, won = answers.count.ravel(), answers.won.ravel()
    weight = count * p * (1 - p)

    def scattered(values: Numbers) -> Numbers:
        return np.asarray(np.bincount(one, values, size) - np.bincount(other, values, size), np.float64)

    def times(matrices: Numbers, x: Numbers) -> Numbers:
        return np.asarray((x.reshape(studies, people, n) @ matrices).ravel())

    def without_own(x: Numbers) -> Numbers:
        """Return the curvature of all but each participant's own times x."""
        return times(curved, x) - scattered(weight * (x[one] - x[other]))

    left_out, _ = cg(
        LinearOperator((size, size), without_own, dtype=np.float64),
        scattered(won - count * p),
        M=LinearOperator((size, size), lambda x: times(inverse, x), dtype=np.float64),
        rtol=SOLVED,
    )
    by_person = left_out.reshape(studies, people, n)
    return strengths, np.swapaxes(by_person, 1, 2) @ by_person * ((people - 1) / people)


def shown_and_equal(
    gaps: Numbers, errors: Numbers, *, people: int, margin: float, alpha: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which pairs are shown to differ, and which to be within the margin, each with Holm's correction.

    As `analyse_preference`, for many studies: all arrays are of shape (study, pair).
    """
    far = np.abs(gaps)
    shown = _holm_above(far / errors, people - 1, alpha / 2)
    equal = _holm_above((margin - far) / errors, people - 1, alpha)
    return shown, equal & ~shown


def _holm_above(t: Numbers, freedom: int, alpha: float) -> NDArray[np.bool_]:
    """Return which t of each row are significant, one-sided, with Holm's correction.

    The number of significant ones so far gives the next critical value, until no more are: without sorting or p-values.
    """
    tests = t.shape[1]
    needed = _needed(tests, freedom, alpha)
    shown = np.zeros(len(t), np.int64)
    while True:
        above = t > needed[shown][:, None]
        more = np.maximum(above.sum(1), shown)
        if (more == shown).all():
            return above
        shown = more


@lru_cache(maxsize=8)
def _needed(tests: int, freedom: int, alpha: float) -> Numbers:
    """Return the critical t by the number of tests that are significant already; after the last, any t is."""
    return np.append(stats.t.isf(alpha / np.arange(tests, 0, -1), freedom), -np.inf)


def _presented(
    comparisons: int, pairs: int, shape: tuple[int, int], rng: np.random.Generator
) -> tuple[Counts, Counts]:
    """Return the pairs of each participant, and how often each comes: all equally often, the remainder at random."""
    each, rest = divmod(comparisons, pairs)
    if each or 4 * rest > pairs:
        places = np.argsort(rng.random((*shape, pairs)), axis=-1)
        if each:
            return np.broadcast_to(np.arange(pairs), places.shape), each + (places < rest)
        drawn = places[..., :rest]
    else:
        drawn = np.sort(rng.integers(pairs, size=(*shape, rest)), axis=-1)
        while (again := drawn[..., 1:] == drawn[..., :-1]).any():
            drawn[..., 1:][again] = rng.integers(pairs, size=int(again.sum()))
            drawn.sort(axis=-1)
    return drawn, np.ones_like(drawn)

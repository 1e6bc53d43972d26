"""Power of pairwise preferences: how often strengths are shown to differ, or to be equivalent, in many studies.

What is said is what `strengths_by_participant` and Holm's correction say. But no table is made of each participant, who
answers about few of the many pairs: the jackknife's equations are solved by conjugate gradients, preconditioned with
the inverse for all participants, which leaving one out changes little.
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
"""Numbers that are held at the same time, of participants and of tables of items: what a processor's cache takes."""
SOLVED = 1e-7
"""Residual of the jackknife's equations, as a share of what it began with."""


class Strengths(PowerMethod):
    """Strengths of items by participant, with Holm's correction over all pairs."""

    of_pairs = True

    def shares(self, rng: np.random.Generator, batch: StudyBatch, truths: Truths) -> dict[str, float]:
        """Return power of pairs that differ; with ``type_1`` that any pair is shown, and equivalence."""
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
        """Refuse too few or too many items."""
        if not 2 <= assumed.items <= 100:
            raise ParameterError(f"items must be from 2 to 100, got {assumed.items}")

    def notes(self) -> list[str]:
        """Return what the shares are of."""
        return [
            "power: of a pair that differs; type_1: that any pair is shown where none differs; equivalence: of a pair, "
            "all_equivalent: of all pairs at once."
        ]


@dataclass(frozen=True)
class ComparisonCounts:
    """Answers of the participants of many studies, without the pairs that were not asked about.

    Parameters
    ----------
    first, second : int64 array, shape (study, participant, asked)
        Items of a pair.
    count, won : int64 array, shape (study, participant, asked)
        How often the pair was asked about, and the first preferred.
    items : int
    """

    first: Counts
    second: Counts
    count: Counts
    won: Counts
    items: int

    def tables(self) -> Numbers:
        """Return how often the row's was preferred to the column's by all, shape (study, item, item)."""
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
    """Yield, of some studies at a time, every two items' difference of log strengths and its standard error.

    The first item is stronger by ``effect`` than the others, which are alike. Pairs are asked about equally often, as
    near as the number of comparisons lets them be: where items are alike that is what choosing the most informative
    pair comes to.

    Parameters
    ----------
    people, comparisons : int
        Participants of each study, and comparisons of each of them over all pairs.
    items : int
    effect : float
        Log strength.
    person_sd : float
        Spread of people's own log strength of each item.
    studies : int
    rng : numpy Generator

    Yields
    ------
    tuple of float64 array
        Both of shape (study, pair); the first ``items - 1`` pairs are those of the first item.
    """
    pairs = np.array(list(combinations(range(items), 2)))
    first, second = pairs.T
    some = max(1, AT_ONCE // (people * (items + min(comparisons, len(pairs))) + items**2))
    for begin in range(0, studies, some):
        count = min(some, studies - begin)
        strengths = person_sd * rng.standard_normal((count, people, items))
        strengths[..., 0] += effect
        place, asked = _asked(comparisons, len(pairs), (count, people), rng)
        one, other = first[place], second[place]
        gap = np.take_along_axis(strengths, one, -1) - np.take_along_axis(strengths, other, -1)
        won = rng.binomial(asked, special.expit(gap))
        answers = ComparisonCounts(one, other, asked, won, items)
        found, covariance = jackknifed(answers)
        errors, _ = gap_errors(covariance, curvature(answers.tables(), found), first, second)
        yield found[:, first] - found[:, second], errors


def jackknifed(answers: ComparisonCounts) -> tuple[Numbers, Numbers]:
    """Return log strengths and their covariance by participant: those of `strengths_by_participant`.

    Parameters
    ----------
    answers : Compared

    Returns
    -------
    strengths : float64 array, shape (study, item)
    covariance : float64 array, shape (study, item, item)
        Of differences between items; what is the same for all of them is left in.
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
    """Return which pairs are shown to differ and which to be within the margin, each with Holm's correction.

    As `analyse_preference` says it, for many studies.

    Parameters
    ----------
    gaps, errors : float64 array, shape (study, pair)
    people : int
    margin, alpha : float

    Returns
    -------
    tuple of bool array, shape (study, pair)
    """
    far = np.abs(gaps)
    shown = _holm_above(far / errors, people - 1, alpha / 2)
    equal = _holm_above((margin - far) / errors, people - 1, alpha)
    return shown, equal & ~shown


def _holm_above(t: Numbers, freedom: int, alpha: float) -> NDArray[np.bool_]:
    """Return which t of each row are shown, one-sided, with Holm's correction.

    As many as are shown so far say how large the next has to be, until no more are: without a p of each, or an order.
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
    """Return how large the next t has to be by how many of the tests are shown; after the last anything will do."""
    return np.append(stats.t.isf(alpha / np.arange(tests, 0, -1), freedom), -np.inf)


def _asked(
    comparisons: int, pairs: int, shape: tuple[int, int], rng: np.random.Generator
) -> tuple[Counts, Counts]:
    """Return which pairs each participant is asked about, and how often: all equally often, the rest at random."""
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

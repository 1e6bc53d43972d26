"""Many studies of pairwise preference at once: how often strengths are shown to differ, or to be as good as equal."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from tactogram.study.bradley_terry import strengths_by_participant

Numbers = NDArray[np.float64]
AT_ONCE = 3_600_000
"""Numbers of participants' tables that are held at the same time: 100,000 tables of six items."""


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
    some = max(1, AT_ONCE // (people * items**2))
    for begin in range(0, studies, some):
        count = min(some, studies - begin)
        strengths = person_sd * rng.standard_normal((count, people, items))
        strengths[..., 0] += effect
        asked = _asked(comparisons, len(pairs), (count, people), rng)
        won = rng.binomial(asked, special.expit(strengths[..., first] - strengths[..., second]))
        tables = np.zeros((count, people, items, items))
        tables[..., first, second] = won
        tables[..., second, first] = asked - won
        found, covariance = strengths_by_participant(tables)
        variance = (
            covariance[:, first, first] + covariance[:, second, second] - 2 * covariance[:, first, second]
        )
        yield found[:, first] - found[:, second], np.sqrt(np.maximum(variance, 1e-24))


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
    shown = _holm_below(2 * stats.t.sf(np.abs(gaps) / errors, people - 1), alpha)
    equal = _holm_below(stats.t.sf((margin - np.abs(gaps)) / errors, people - 1), alpha)
    return shown, equal & ~shown


def _holm_below(ps: Numbers, alpha: float) -> NDArray[np.bool_]:
    """Return which p of each row are below alpha with Holm's correction."""
    order = np.argsort(ps, axis=1)
    stepped = np.take_along_axis(ps, order, 1) * np.arange(ps.shape[1], 0, -1)
    below = np.empty(ps.shape, bool)
    np.put_along_axis(below, order, np.maximum.accumulate(stepped, axis=1) < alpha, 1)
    return below


def _asked(
    comparisons: int, pairs: int, shape: tuple[int, int], rng: np.random.Generator
) -> NDArray[np.int64]:
    """Return how often each participant is asked about each pair: all equally often, the rest at random."""
    each, rest = divmod(comparisons, pairs)
    places = np.argsort(rng.random((*shape, pairs)), axis=-1)
    return np.asarray(each + (places < rest), np.int64)

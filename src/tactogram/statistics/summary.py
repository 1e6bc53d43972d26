"""Mean, standard error and confidence interval of answers."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from tactogram.errors import ParameterError


@dataclass(frozen=True)
class GroupSummary:
    """Summary of one group, as figures show it.

    Parameters
    ----------
    n : int
        Values that were given; missing ones are not counted.
    mean, sd, se : float
        Of the values; ``sd`` with n - 1, ``se`` = sd / sqrt(n). NaN of a single value.
    low, high : float
        Interval of the mean by Student's t.
    """

    n: int
    mean: float
    sd: float
    se: float
    low: float
    high: float


def summary(values: ArrayLike, *, confidence: float = 0.95) -> GroupSummary:
    """Return mean, spread and the t interval of the mean; NaN are left out.

    Parameters
    ----------
    values : float array, any shape
    confidence : float

    Raises
    ------
    ParameterError
        If there is no value, or ``confidence`` is not between 0 and 1.
    """
    if not 0 < confidence < 1:
        raise ParameterError(f"confidence must be between 0 and 1, got {confidence:g}")
    given = np.asarray(values, np.float64).ravel()
    given = given[~np.isnan(given)]
    if not given.size:
        raise ParameterError("a summary needs a value, got none")
    mean = float(given.mean())
    if given.size == 1:
        return GroupSummary(1, mean, np.nan, np.nan, np.nan, np.nan)
    sd = float(given.std(ddof=1))
    se = sd / float(np.sqrt(given.size))
    half = float(stats.t.isf((1 - confidence) / 2, given.size - 1)) * se
    return GroupSummary(given.size, mean, sd, se, mean - half, mean + half)


def by_participant(
    values: ArrayLike, participants: Sequence[Hashable]
) -> tuple[tuple[Hashable, ...], NDArray[np.float64]]:
    """Return the mean of each participant's answers: what may count as independent where answers repeat.

    Parameters
    ----------
    values : float array, shape (answer,)
        NaN are left out.
    participants : sequence, length (answer,)
        Who gave each.

    Returns
    -------
    tuple of participants (sorted as text) and their means, float64, shape (participant,)
        NaN for a participant whose answers are all missing.

    Raises
    ------
    ParameterError
        If the two do not have one length, or are empty.
    """
    given = np.asarray(values, np.float64)
    if given.ndim != 1 or len(given) != len(participants) or not len(given):
        raise ParameterError(
            f"values and participants must be of one length >= 1, got shape {given.shape} and {len(participants)}"
        )
    people = tuple(sorted(set(participants), key=str))
    place = {name: number for number, name in enumerate(people)}
    who = np.array([place[name] for name in participants])
    there = ~np.isnan(given)
    total = np.bincount(who[there], given[there], minlength=len(people))
    count = np.bincount(who[there], minlength=len(people))
    return people, np.divide(total, count, out=np.full(len(people), np.nan), where=count > 0)

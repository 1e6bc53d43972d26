"""Threshold of one person from a staircase: the posterior of a logistic function, read where the trials lie.

A staircase of a few dozen trials carries little information on slope and lapse rate. Maximum likelihood makes the slope
too steep (C. Kaernbach, "Slope bias of psychometric functions derived from adaptive data", Percept. Psychophys. 63,
2001), and away from the trials, such as at 75 % of a 3 down 1 up staircase, the threshold errs with it. Here slope and
lapse rate have priors and are integrated out (H. H. Schuett and others, "Painfree and accurate Bayesian estimation of
psychometric functions for (potentially) overdispersed data", Vision Res. 122, 2016), and the threshold is read at the
share at which the staircase settles (H. Levitt, J. Acoust. Soc. Am. 49, 1971). All trials count, including the descent:
intensities that follow the answers do not bias a likelihood. Measured bias and spread: docs/studies.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from tactogram.errors import DataError, ParameterError

Numbers = NDArray[np.float64]
SETTLED_3_DOWN = 0.5 ** (1 / 3)
"""Share correct at which 3 down 1 up settles, .794 (Levitt 1971)."""
SLOPE_SD = 0.8
"""Standard deviation of the normal prior of the log slope, a factor of 2.2. Its mean is 1 per smallest step, as if the
experimenter had chosen a step of about half the spread of the function (sd 1.7 steps)."""
LAPSES = (0.0, 0.02, 0.04, 0.06)
"""Equally likely lapse rates, up to the bound of F. A. Wichmann and N. J. Hill, Percept. Psychophys. 63 (2001)."""
BEYOND_STEPS = 8.0
"""Range of thresholds below the weakest and above the strongest intensity, in smallest steps."""
PER_STEP = 8
"""Grid points of the threshold per smallest step."""
MOST_PLACES = 2000


@dataclass(frozen=True)
class Threshold:
    """Threshold from the answers to one staircase.

    Parameters
    ----------
    threshold : float
        Mode of the posterior of the intensity at which ``share`` is correct.
    low, high : float
        Ends of 95 % of the posterior.
    slope : float
        Geometric mean of the posterior, per unit of intensity.
    inside : bool
        Whether the threshold lies within the presented intensities.
    """

    threshold: float
    low: float
    high: float
    slope: float
    share: float
    inside: bool


def estimate_threshold(
    intensity: ArrayLike, correct: ArrayLike, *, share: float = SETTLED_3_DOWN, guess: float = 0.5
) -> Threshold:
    """Return the threshold of one person's answers, shape (answer,): mode and 95 % of its posterior on a grid.

    The function must be logistic over the intensity, such as dB. ``share`` is the share correct at the threshold (see
    `settled_share`), ``guess`` that without any signal. Raises `ParameterError` for invalid arrays or shares;
    `DataError` if there are fewer than two intensities, or all answers are alike.
    """
    if not 0 <= guess < share < 1 - max(LAPSES):
        raise ParameterError(f"must be 0 <= guess < share < {1 - max(LAPSES):g}, got {guess:g} and {share:g}")
    levels, n, k = _count_by_level(intensity, correct)
    step = float(np.diff(levels).min())
    places = _places(levels, step)
    slopes = np.exp(np.linspace(-2.5, 2.5, 15) * SLOPE_SD) / step
    log_weight = _log_posterior(levels, n, k, places, slopes, share=share, guess=guess)
    weight = np.exp(log_weight - log_weight.max())  # lapse, slope, place
    weight /= weight.sum()
    of_place = weight.sum((0, 1))
    below = np.cumsum(of_place)
    low, high = (float(places[np.searchsorted(below, tail)]) for tail in (0.025, 0.975))
    mode = _mode(places, of_place)
    return Threshold(
        mode,
        low,
        high,
        float(np.exp(weight.sum((0, 2)) @ np.log(slopes))),
        share,
        bool(levels[0] <= mode <= levels[-1]),
    )


def settled_share(intensity: ArrayLike, correct: ArrayLike) -> float | None:
    """Return the share correct at which a 1 up n down staircase settles, 2^(-1/n), with n inferred from its answers.

    Of intensities and outcomes in the order of the trials, shape (trial,). None if it never fell, or fell after a
    single right answer, which settles at guessing.
    """
    x, y = np.asarray(intensity, np.float64), np.asarray(correct, np.float64)
    moved = np.flatnonzero(np.diff(x))
    runs = np.diff(np.concatenate([[-1], moved]))
    fell = runs[np.diff(x)[moved] < 0] if len(moved) else runs
    # The first fall of a track may come early in a continued session; most falls follow the rule.
    n = int(np.median(fell)) if len(fell) and y.any() else 0
    share = 0.5 ** (1 / n) if n > 1 else None
    return share if share is not None and share < 1 - max(LAPSES) else None


def reversal_threshold(intensity: ArrayLike, reversal: Sequence[bool], *, leave_out: int = 2) -> float | None:
    """Return the mean intensity of a staircase's reversals, without the first ones; None if none is left.

    The first ``leave_out`` still depend on the starting intensity. If an odd number is left, one more is dropped, so
    that peaks and valleys count alike. Both arrays have shape (trial,).
    """
    turned = np.asarray(intensity, np.float64)[np.asarray(reversal, bool)][leave_out:]
    turned = turned[len(turned) % 2 :]
    return float(turned.mean()) if len(turned) else None


def _count_by_level(intensity: ArrayLike, correct: ArrayLike) -> tuple[Numbers, Numbers, Numbers]:
    """Return the distinct intensities, their numbers of trials, and of right answers."""
    x, y = np.asarray(intensity, np.float64), np.asarray(correct, np.float64)
    if x.ndim != 1 or x.shape != y.shape or not np.isfinite(x).all():
        raise ParameterError(
            f"intensity and correct must be finite, of one length, got {x.shape} and {y.shape}"
        )
    levels, level_index = np.unique(x, return_inverse=True)
    n = np.bincount(level_index).astype(np.float64)
    k = np.bincount(level_index, y).astype(np.float64)
    if len(levels) < 2 or k.sum() in (0, n.sum()):
        raise DataError(
            "a threshold needs two intensities and both right and wrong answers, "
            f"got {len(levels)} intensities and {int(k.sum())} of {int(n.sum())} right"
        )
    return levels, n, k


def _places(levels: Numbers, step: float) -> Numbers:
    low, high = float(levels[0]) - BEYOND_STEPS * step, float(levels[-1]) + BEYOND_STEPS * step
    count = min(MOST_PLACES, int(np.ceil((high - low) / step * PER_STEP)) + 1)
    return np.linspace(low, high, count)


def _log_posterior(
    levels: Numbers, n: Numbers, k: Numbers, places: Numbers, slopes: Numbers, *, share: float, guess: float
) -> Numbers:
    """Return the log posterior up to a constant, shape (lapse, slope, place)."""
    prior = -((np.log(slopes * np.diff(levels).min()) / SLOPE_SD) ** 2) / 2
    posteriors = []
    for lapse in LAPSES:
        at_share = special.logit((share - guess) / (1 - guess - lapse))
        z = slopes[:, None, None] * (levels - places[:, None]) + at_share  # slope, place, level
        p = np.clip(guess + (1 - guess - lapse) * special.expit(z), 1e-12, 1 - 1e-12)
        posteriors.append(np.log(p) @ k + np.log1p(-p) @ (n - k) + prior[:, None])
    return np.array(posteriors)


def _mode(places: Numbers, weight: Numbers) -> float:
    """Return the mode of a posterior: the top of the parabola through the three highest neighbours."""
    best = int(np.argmax(weight))
    if not 0 < best < len(places) - 1:
        return float(places[best])
    before, top, after = np.log(weight[best - 1 : best + 2])
    bend = before - 2 * top + after
    return float(
        places[best] + (places[1] - places[0]) * (0.5 * (before - after) / bend if bend < 0 else 0.0)
    )

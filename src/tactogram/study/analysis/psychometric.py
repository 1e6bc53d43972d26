"""Psychometric functions by maximum likelihood, and thresholds of staircases by their reversals.

F. A. Wichmann, N. J. Hill, "The psychometric function: I", Percept. Psychophys. 63 (2001): maximum likelihood with a
bounded lapse rate. H. Levitt, "Transformed up-down methods in psychoacoustics", J. Acoust. Soc. Am. 49 (1971): mean of
reversals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, special

from tactogram.errors import DataError, ParameterError

Numbers = NDArray[np.float64]
LAPSE_LIMIT = 0.06
"""Wichmann and Hill's bound of the lapse rate."""


@dataclass(frozen=True)
class LogisticFit:
    """Share correct guess + (1 - guess - lapse) / (1 + exp(-slope (x - place))), and the intensity at its target."""

    place: float
    slope: float
    lapse: float
    threshold: float


def count_by_level(
    intensity: ArrayLike, correct: ArrayLike, *, needed_by: str
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the distinct intensities, their numbers of trials, and of right answers; of arrays of shape (trial,).

    Raises `ParameterError` for invalid arrays; `DataError`, with ``needed_by`` as subject, if there are fewer than two
    intensities, or all answers are alike.
    """
    x, y = np.asarray(intensity, np.float64), np.asarray(correct, np.float64)
    if x.ndim != 1 or x.shape != y.shape or not np.isfinite(x).all():
        raise ParameterError(
            f"intensity and correct must be finite, of one length, got {x.shape} and {y.shape}"
        )
    levels, place = np.unique(x, return_inverse=True)
    n = np.bincount(place).astype(np.float64)
    k = np.bincount(place, y).astype(np.float64)
    if len(levels) < 2 or k.sum() in (0, n.sum()):
        raise DataError(
            f"{needed_by} needs two intensities and both right and wrong answers, "
            f"got {len(levels)} intensities and {int(k.sum())} of {int(n.sum())} right"
        )
    return levels, n, k


def fit_logistic(
    intensity: ArrayLike,
    correct: ArrayLike,
    *,
    target: float = 0.75,
    guess: float = 0.5,
    start: LogisticFit | None = None,
) -> LogisticFit:
    """Fit a logistic psychometric function by maximum likelihood.

    Of intensities and outcomes, shape (answer,). ``target`` is the share correct at the threshold, between ``guess``,
    the share without any signal, and 1 - `LAPSE_LIMIT`. ``start`` is a fit of similar answers; otherwise several
    starting points are tried. Raises as `count_by_level`.
    """
    if not 0 <= guess < target < 1 - LAPSE_LIMIT:
        raise ParameterError(
            f"must be 0 <= guess < target < {1 - LAPSE_LIMIT:g}, got {guess:g} and {target:g}"
        )
    levels, n, k = count_by_level(intensity, correct, needed_by="a psychometric function")
    place, log_slope, lapse = _Likelihood(levels, n, guess).maximum(k, start).tolist()
    slope = float(np.exp(log_slope))
    share = (target - guess) / (1 - guess - lapse)
    return LogisticFit(place, slope, lapse, float(place + special.logit(share) / slope))


def reversal_threshold(intensity: ArrayLike, reversal: Sequence[bool], *, leave_out: int = 2) -> float | None:
    """Return the mean intensity of a staircase's reversals, without the first ones; None if none is left.

    The first ``leave_out`` still depend on the starting intensity. If an odd number is left, one more is dropped, so
    that peaks and valleys count alike. Both arrays have shape (trial,).
    """
    turned = np.asarray(intensity, np.float64)[np.asarray(reversal, bool)][leave_out:]
    turned = turned[len(turned) % 2 :]
    return float(turned.mean()) if len(turned) else None


class _Likelihood:
    """The likelihood of one set of intensities; its parameters are place, log slope and lapse."""

    def __init__(self, levels: Numbers, n: Numbers, guess: float) -> None:
        self.levels, self.n, self.guess = levels, n, guess
        self.span = float(np.ptp(levels))
        self.bounds = [
            (float(levels[0]) - self.span, float(levels[-1]) + self.span),
            (float(np.log(0.3 / self.span)), float(np.log(60 / self.span))),
            (0.0, LAPSE_LIMIT),
        ]

    def loss(self, p: Numbers, k: Numbers) -> tuple[float, Numbers]:
        """Return the negative log likelihood and its gradient."""
        slope, lapse = float(np.exp(p[1])), float(p[2])
        z = slope * (self.levels - p[0])
        rise = special.expit(z)
        steep = rise * (1 - rise)
        span = 1 - self.guess - lapse
        share = np.clip(self.guess + span * rise, 1e-9, 1 - 1e-9)
        value = -float((k * np.log(share) + (self.n - k) * np.log1p(-share)).sum())
        pull = (self.n - k) / (1 - share) - k / share
        by_z = pull * span * steep
        return value, np.array([-slope * by_z.sum(), (by_z * z).sum(), -(pull * rise).sum()])

    def maximum(self, k: Numbers, start: LogisticFit | None) -> Numbers:
        if start is not None:
            low, high = np.transpose(self.bounds)
            starts = [np.clip([start.place, np.log(start.slope), start.lapse], low, high)]
        else:
            middle = float(np.average(self.levels, weights=self.n))
            starts = [
                np.array([place, np.log(steep / self.span), LAPSE_LIMIT / 3])
                for place in (middle, *np.quantile(self.levels, (0.25, 0.75)))
                for steep in (3.0, 10.0)
            ]
        fits = [
            optimize.minimize(self.loss, first, (k,), "L-BFGS-B", jac=True, bounds=self.bounds)
            for first in starts
        ]
        return np.asarray(min(fits, key=lambda fit: float(fit.fun)).x)

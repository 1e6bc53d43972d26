"""Thresholds: psychometric functions with guess and lapse rates, and staircases by their reversals.

F. A. Wichmann, N. J. Hill, "The psychometric function: I", Percept. Psychophys. 63 (2001): maximum likelihood with a
bounded lapse rate; "II", ibid.: parametric bootstrap of the threshold. H. Levitt, "Transformed up-down methods in
psychoacoustics", J. Acoust. Soc. Am. 49 (1971): mean of reversals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, special, stats

from tactogram.errors import DataError, ParameterError

Numbers = NDArray[np.float64]
Shape = Literal["weibull", "logistic", "gaussian"]
SHAPES = ("weibull", "logistic", "gaussian")
LAPSE_LIMIT = 0.06
"""Wichmann and Hill's bound of the lapse rate."""


@dataclass(frozen=True)
class PsychometricFit:
    """A psychometric function: guess + (1 - guess - lapse) F(x).

    Parameters
    ----------
    shape : {"weibull", "logistic", "gaussian"}
        weibull: F = 1 - exp(-(x / place)^slope); logistic: F = 1 / (1 + exp(-slope (x - place))); gaussian:
        F = normal distribution of slope (x - place).
    target : float
        Share correct at the threshold.
    threshold : float
        Intensity at ``target``.
    low, high : float
        Interval of the threshold by parametric bootstrap; NaN without draws.
    deviance, deviance_p : float
        Of the fit from the shares, and the share of bootstrap draws with a larger one (below .05: a bad fit).
    n : int
        Answers.
    inside : bool
        Whether the threshold lies within the presented intensities; otherwise it is an extrapolation.
    """

    shape: Shape
    place: float
    slope: float
    guess: float
    lapse: float
    target: float
    threshold: float
    low: float
    high: float
    deviance: float
    deviance_p: float
    n: int
    inside: bool

    def share(self, intensity: ArrayLike) -> Numbers:
        """Return the share correct at intensities."""
        x = np.asarray(intensity, np.float64)
        return self.guess + (1 - self.guess - self.lapse) * _rise(self.shape, x, self.place, self.slope)


def count_by_level(
    intensity: ArrayLike, correct: ArrayLike, *, needed_by: str
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the distinct intensities, their numbers of trials, and of right answers; of arrays of shape (trial,).

    ``needed_by`` is the subject of the error "… needs two intensities".

    Raises
    ------
    ParameterError
        If the arrays are invalid.
    DataError
        If there are fewer than two intensities, or all answers are alike.
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


def fit_psychometric(
    intensity: ArrayLike,
    correct: ArrayLike,
    *,
    rng: np.random.Generator,
    shape: Shape = "weibull",
    guess: float = 0.5,
    lapse_limit: float = LAPSE_LIMIT,
    target: float = 0.75,
    draws: int = 200,
    start: PsychometricFit | None = None,
) -> PsychometricFit:
    """Fit a psychometric function by maximum likelihood.

    Parameters
    ----------
    intensity : float array, shape (answer,)
        > 0 for weibull.
    correct : array of 0 and 1, shape (answer,)
    rng : numpy Generator
        For the bootstrap.
    shape : {"weibull", "logistic", "gaussian"}
    guess : float
        Share correct without any signal: 1/2 with two alternatives.
    lapse_limit : float
        Upper bound of the fitted lapse rate; 0 fixes it.
    target : float
        Between ``guess`` and 1 - ``lapse_limit``.
    draws : int
        Of the bootstrap; 0 for none.
    start : PsychometricFit, optional
        Starting point of the same shape, for similar answers; otherwise several are tried.

    Raises
    ------
    ParameterError
        If the arrays, the shape or the rates are invalid.
    DataError
        If there are fewer than two intensities, or all answers are alike.
    """
    if shape not in SHAPES:
        raise ParameterError(f"shape must be one of {', '.join(SHAPES)}, got {shape!r}")
    if not (0 <= guess < target < 1 - lapse_limit <= 1):
        raise ParameterError(
            f"must be 0 <= guess < target < 1 - lapse_limit, got {guess:g}, {target:g} and {lapse_limit:g}"
        )
    levels, n, k = count_by_level(intensity, correct, needed_by="a psychometric function")
    if shape == "weibull" and levels[0] <= 0:
        raise ParameterError(f"intensities of a weibull must be > 0, got {levels[0]:g}; take logistic")
    model = _Model(shape, levels, n, guess, lapse_limit)
    at = model.fit(k, start=None if start is None else model.inner(start))
    threshold = model.threshold(at, target)
    deviance = model.deviance(at, k)
    drawn, worse = [], 0
    shares = model.shares(at)
    for _ in range(draws):
        again = rng.binomial(n.astype(int), shares).astype(np.float64)
        if 0 < again.sum() < n.sum():
            found = model.fit(again, start=at)
            drawn.append(model.threshold(found, target))
            worse += model.deviance(found, again) >= deviance
    low, high = np.quantile(drawn, [0.025, 0.975]) if drawn else (np.nan, np.nan)
    a, b, lapse = model.natural(at)
    return PsychometricFit(
        shape,
        a,
        b,
        guess,
        lapse,
        target,
        threshold,
        float(low),
        float(high),
        deviance,
        worse / len(drawn) if drawn else float("nan"),
        int(n.sum()),
        bool(levels[0] <= threshold <= levels[-1]),
    )


def reversal_threshold(intensity: ArrayLike, reversal: Sequence[bool], *, leave_out: int = 2) -> float | None:
    """Return the mean intensity of a staircase's reversals, without the first ones; None if none is left.

    Parameters
    ----------
    intensity : float array, shape (trial,)
    reversal : sequence of bool, length (trial,)
    leave_out : int
        First reversals, which still depend on the starting intensity. If an odd number is left, one more is dropped, so
        that peaks and valleys count alike.
    """
    turned = np.asarray(intensity, np.float64)[np.asarray(reversal, bool)][leave_out:]
    turned = turned[len(turned) % 2 :]
    return float(turned.mean()) if len(turned) else None


def _rise(shape: Shape, x: Numbers, place: float, slope: float) -> Numbers:
    with np.errstate(over="ignore"):
        if shape == "weibull":
            return np.asarray(-np.expm1(-((x / place) ** slope)))
        z = slope * (x - place)
        return np.asarray(special.expit(z) if shape == "logistic" else special.ndtr(z))


class _Model:
    """The likelihood of one set of intensities; parameters are place, log slope and lapse, place as log for weibull."""

    def __init__(self, shape: Shape, x: Numbers, n: Numbers, guess: float, lapse_limit: float) -> None:
        self.shape, self.x, self.n, self.guess = shape, x, n, guess
        self.at = np.log(x) if shape == "weibull" else x
        span = float(np.ptp(self.at))
        self.bounds = [
            (float(self.at[0]) - span, float(self.at[-1]) + span),
            (float(np.log(0.3 / span)), float(np.log(60 / span))),
            (0.0, lapse_limit),
        ]

    def natural(self, p: Numbers) -> tuple[float, float, float]:
        place = float(np.exp(p[0])) if self.shape == "weibull" else float(p[0])
        return place, float(np.exp(p[1])), float(p[2])

    def inner(self, fit: PsychometricFit) -> Numbers:
        """Return a fit's parameters as the likelihood takes them, within the bounds."""
        place = np.log(fit.place) if self.shape == "weibull" else fit.place
        low, high = np.transpose(self.bounds)
        return np.asarray(np.clip([place, np.log(fit.slope), fit.lapse], low, high))

    def shares(self, p: Numbers) -> Numbers:
        place, slope, lapse = self.natural(p)
        return self.guess + (1 - self.guess - lapse) * _rise(self.shape, self.x, place, slope)

    def loss(self, p: Numbers, k: Numbers) -> tuple[float, Numbers]:
        """Return the negative log likelihood and its gradient."""
        slope, lapse = float(np.exp(p[1])), float(p[2])
        z = slope * (self.at - p[0])
        if self.shape == "weibull":
            risen = np.exp(np.minimum(z, 50))
            rise, steep = -np.expm1(-risen), risen * np.exp(-risen)
        elif self.shape == "logistic":
            rise = special.expit(z)
            steep = rise * (1 - rise)
        else:
            rise, steep = special.ndtr(z), np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)
        span = 1 - self.guess - lapse
        share = np.clip(self.guess + span * rise, 1e-9, 1 - 1e-9)
        value = -float((k * np.log(share) + (self.n - k) * np.log1p(-share)).sum())
        pull = (self.n - k) / (1 - share) - k / share
        by_z = pull * span * steep
        return value, np.array([-slope * by_z.sum(), (by_z * z).sum(), -(pull * rise).sum()])

    def fit(self, k: Numbers, start: Numbers | None = None) -> Numbers:
        span = float(np.ptp(self.at))
        middle = float(np.average(self.at, weights=self.n))
        starts = [
            np.array([place, np.log(steep / span), self.bounds[2][1] / 3])
            for place in (middle, *np.quantile(self.at, (0.25, 0.75)))
            for steep in (3.0, 10.0)
        ]
        found = [
            optimize.minimize(self.loss, first, (k,), "L-BFGS-B", jac=True, bounds=self.bounds)
            for first in (starts if start is None else [start])
        ]
        return np.asarray(min(found, key=lambda one: float(one.fun)).x)

    def threshold(self, p: Numbers, target: float) -> float:
        place, slope, lapse = self.natural(p)
        q = (target - self.guess) / (1 - self.guess - lapse)
        if self.shape == "weibull":
            return float(place * (-np.log1p(-q)) ** (1 / slope))
        return float(place + (special.logit(q) if self.shape == "logistic" else stats.norm.ppf(q)) / slope)

    def deviance(self, p: Numbers, k: Numbers) -> float:
        own = np.clip(k / self.n, 1e-9, 1 - 1e-9)
        best = float((k * np.log(own) + (self.n - k) * np.log1p(-own)).sum())
        return max(0.0, 2 * (best + self.loss(p, k)[0]))

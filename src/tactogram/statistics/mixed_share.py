"""Share of hits of a typical person and item: a binomial mixed model whose spreads may be 0.

statsmodels has such a model with variational Bayes only, whose prior keeps spreads from 0.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, special, stats

from tactogram.errors import ParameterError
from tactogram.statistics.clustered import TAIL, EffectEstimate

Numbers = NDArray[np.float64]
WIDEST = 5.0
"""Largest spread, logits: a member one sd above the typical one is then right in 99 % of trials."""
FLAT = 1e-2
"""Spread that counts as 0, logits: 0.25 % of a share near one half."""
FIRST, FARTHEST = 0.3, 30.0
"""First and last value in the search for spreads and interval ends, logits."""


@dataclass(frozen=True)
class MixedShareModel:
    """A binomial mixed model with a random intercept of each group, by Laplace's approximation.

    The members' effects are written as spread times a standard normal (D. Bates et al., J. Stat. Softw. 67(1), 2015,
    Sec. 3.2), so that the likelihood is defined at a spread of 0.

    Parameters
    ----------
    hits, trials : float64 array, shape (cell,)
        Of each combination of members with answers.
    members : float64 array, shape (cell, member)
        1 where a cell is of a member.
    group : int64 array, shape (member,)
    """

    hits: Numbers
    trials: Numbers
    members: Numbers
    group: NDArray[np.int64]

    def deviance(self, logit: float, spreads: Numbers) -> float:
        """Return -2 log likelihood up to a constant (N. E. Breslow, D. G. Clayton, JASA 88, 1993, Eq. 3).

        Of the logit of a typical member of each group, and the groups' standard deviations in logits, shape (group,).
        """
        z = self.members * spreads[self.group]
        effects = self._modes(logit, z)
        eta = logit + z @ effects
        return float(-2 * self._fit(eta, effects) + np.linalg.slogdet(self._curvature(eta, z))[1])

    def _modes(self, logit: float, z: Numbers) -> Numbers:
        """Return the most likely effects of the members, by Newton's method.

        The likelihood is concave, but far from its maximum full steps can oscillate around it: these are halved.
        """
        effects = np.zeros(z.shape[1])
        eta = logit + z @ effects
        fit = self._fit(eta, effects)
        for _ in range(100):
            slope = z.T @ (self.hits - self.trials * special.expit(eta)) - effects
            step = np.linalg.solve(self._curvature(eta, z), slope)
            if np.abs(step).max() < 1e-8:
                break
            for _ in range(60):
                eta = logit + z @ (effects + step)
                if (tried := self._fit(eta, effects + step)) >= fit - 1e-9:  # rounding of a sum of many
                    break
                step = step / 2
            effects, fit = effects + step, tried
        return effects

    def _fit(self, eta: Numbers, effects: Numbers) -> float:
        """Return the log likelihood of the answers and of the effects, up to a constant."""
        likelihood = (self.hits * eta - self.trials * np.logaddexp(0, eta)).sum()
        return float(likelihood - effects @ effects / 2)

    def _curvature(self, eta: Numbers, z: Numbers) -> Numbers:
        """Return its negative second derivatives by the effects, shape (member, member)."""
        p = special.expit(eta)
        return np.asarray(z.T @ (z * (self.trials * p * (1 - p))[:, None]) + np.eye(z.shape[1]))

    def fitted(self) -> tuple[float, Numbers, float]:
        """Return the logit and the spreads of the smallest deviance, and that deviance.

        Searched over variances: over spreads, the deviance is flat at 0, and a search would stop there.
        """
        count = int(self.group.max()) + 1
        start = special.logit(self.hits.sum() / self.trials.sum())
        found = optimize.minimize(
            lambda x: self.deviance(float(x[0]), np.sqrt(x[1:])),
            [float(start), *[FIRST**2] * count],
            method="L-BFGS-B",
            bounds=[(-FARTHEST, FARTHEST), *[(0.0, WIDEST**2)] * count],
        )
        return float(found.x[0]), np.sqrt(found.x[1:]), float(found.fun)

    def profiled(self, logit: float, start: Numbers) -> tuple[float, Numbers]:
        """Return the smallest deviance over all spreads, and the spreads."""
        found = optimize.minimize(
            lambda variances: self.deviance(logit, np.sqrt(variances)),
            start**2,
            method="L-BFGS-B",
            bounds=[(0.0, WIDEST**2)] * len(start),
        )
        return float(found.fun), np.sqrt(found.x)


def mixed_share(hits: ArrayLike, groups: dict[str, Sequence[Hashable]]) -> EffectEstimate:
    """Return the share of a typical member of each group: a binomial mixed model with random intercepts.

    By maximum likelihood, with the interval of 95 % of the profile likelihood: where members do not differ the spreads
    are 0, and the interval is that of all answers together. Its critical value is that at which a likelihood ratio of
    normal values equals Student's t (J. Neyman, E. S. Pearson, Biometrika 20A, 1928). The degrees of freedom are F. E.
    Satterthwaite's (Biometrics Bull. 2, 1946), from the variances of the groups' spreads, divided by their numbers of
    members, and of the answers: infinite where no spread is left, members - 1 where all variance is one group's. A
    check of `pooled_share` with more in the model. Estimated spreads are above 0 by chance, and never below: where few
    members do not differ, the interval is still somewhat too wide.

    ``hits`` are 0 or 1, shape (answer,); ``groups`` are e.g. participant and texture of each answer, those with a
    single member are ignored. Raises `ParameterError` if all answers are alike, or no group has two members.
    """
    values = np.asarray(hits, np.float64)
    several = {name: list(of) for name, of in groups.items() if len(set(of)) > 1}
    if not several or len(np.unique(values)) < 2:
        raise ParameterError("a mixed model needs answers of both kinds and two members of a group")
    model, counts = _model(values, several)
    logit, spreads, best = model.fitted()
    freedom = _freedom(model, logit, spreads, counts)
    t = float(stats.t.isf(TAIL, freedom))
    critical = float((freedom + 1) * np.log1p(t**2 / freedom))

    def excess(x: float) -> float:
        return model.profiled(x, np.maximum(spreads, FIRST / 3))[0] - best - critical

    low, high = (_crossing(excess, logit, sign) for sign in (-1.0, 1.0))
    none = [name for name, spread in zip(several, spreads, strict=True) if spread < FLAT]
    return EffectEstimate(
        float(special.expit(logit)),
        float(special.expit(low)),
        float(special.expit(high)),
        note=f"the fit leaves {'s and '.join(none)}s no spread" if none else "",
    )


def _model(values: Numbers, groups: dict[str, list[Hashable]]) -> tuple[MixedShareModel, NDArray[np.int64]]:
    """Return the model of the answers counted by cell, and the number of members of each group."""
    names = [list(dict.fromkeys(of)) for of in groups.values()]
    counts = np.array([len(one) for one in names])
    columns, begin = [], 0
    for of, one in zip(groups.values(), names, strict=True):
        place = {name: begin + k for k, name in enumerate(one)}
        columns.append([place[name] for name in of])
        begin += len(one)
    cells, cell = np.unique(np.array(columns).T, axis=0, return_inverse=True)
    members = np.zeros((len(cells), begin))
    np.put_along_axis(members, cells, 1.0, axis=1)
    return MixedShareModel(
        np.asarray(np.bincount(cell.ravel(), values), np.float64),
        np.bincount(cell.ravel()).astype(np.float64),
        members,
        np.repeat(np.arange(len(counts)), counts),
    ), counts


def _freedom(model: MixedShareModel, logit: float, spreads: Numbers, counts: NDArray[np.int64]) -> float:
    p = float(special.expit(logit))
    parts = spreads**2 / counts
    whole = parts.sum() + 1 / (model.trials.sum() * p * (1 - p))
    return float(whole**2 / max((parts**2 / (counts - 1)).sum(), 1e-12))


def _crossing(excess: Callable[[float], float], middle: float, sign: float) -> float:
    """Return the logit at which the profile crosses its critical value on one side of the estimate."""
    near, far = 0.0, FIRST
    while excess(middle + sign * far) < 0:
        near, far = far, 1.6 * far
        if far > FARTHEST:
            return sign * np.inf
    found = optimize.brentq(lambda away: excess(middle + sign * away), near, far, xtol=1e-4)
    return middle + sign * float(found)

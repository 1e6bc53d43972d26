"""Power methods: simulation of a power table's studies, and the rows of the table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import special, stats

from tactogram.errors import ParameterError
from tactogram_study.power.assumptions import PowerAssumptions
from tactogram_study.statistics.shares import exact_ps, share_equivalence_power

Numbers = NDArray[np.float64]
Truths = Mapping[str, float]
"""True effect by name of the reported share: ``power``, and ``type_1`` without an effect."""


@dataclass(frozen=True)
class StudyBatch:
    """Simulated studies of one size: a row of a power table."""

    people: int
    trials: int
    assumed: PowerAssumptions
    simulations: int
    alpha: float

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of studies and participants."""
        return self.simulations, self.people


class PowerMethod:
    """Simulation and test of one kind of study."""

    null = 0.0
    """Effect without a difference."""
    of_pairs = False
    """Whether equivalence is that of a pair of items."""

    def shares(self, rng: np.random.Generator, batch: StudyBatch, truths: Truths) -> dict[str, float]:
        """Return, for each of ``truths``, the share of studies in which the test shows a difference.

        With ``type_1`` also ``equivalence``.
        """
        raise NotImplementedError

    def equivalence(self, rng: np.random.Generator, batch: StudyBatch) -> float:
        """Return how often studies of one size show equivalence when there is no difference."""
        return float(self.shares(rng, batch, {"type_1": self.null})["equivalence"])

    def check(self, assumed: PowerAssumptions) -> None:
        """Raise `ParameterError` for assumptions that the method cannot simulate."""
        if assumed.items:
            raise ParameterError(f"items: this design compares no items with each other, got {assumed.items}")
        if assumed.trial_sd == 0:
            raise ParameterError("trial_sd must be > 0, got 0")

    def notes(self) -> list[str]:
        """Return sentences on the columns of this method."""
        return []


class Shares(PowerMethod):
    """Shares correct of two alternatives, tested by participant."""

    null = 0.5

    def shares(self, rng: np.random.Generator, batch: StudyBatch, truths: Truths) -> dict[str, float]:
        """Return power of the share by participant."""
        found: dict[str, float] = {}
        for name, truth in truths.items():
            hits = rng.binomial(batch.trials, _personal_shares(rng, truth, batch))
            p, equal = clustered_ps(hits, batch.trials, margin=batch.assumed.margin)
            found[name] = float((p < batch.alpha).mean())
            if name == "type_1":
                found["equivalence"] = float((equal < batch.alpha).mean())
        return found

    def check(self, assumed: PowerAssumptions) -> None:
        """Raise `ParameterError` for an effect that is no share."""
        if assumed.items:
            super().check(assumed)
        if not (0 < assumed.effect < 1 and assumed.margin < 0.5):
            raise ParameterError(
                "effect must be a share between 0 and 1 and margin below 0.5, "
                f"got {assumed.effect:g} and {assumed.margin:g}"
            )


class Votes(Shares):
    """One yes or no of each person: the exact binomial test."""

    def shares(self, rng: np.random.Generator, batch: StudyBatch, truths: Truths) -> dict[str, float]:
        """Return power of the exact test of one answer per person, where people differ in their tendency to say yes."""
        ps = exact_ps(batch.people)
        found: dict[str, float] = {}
        for name, truth in truths.items():
            yes = rng.binomial(1, _personal_shares(rng, truth, batch)).sum(1)
            found[name] = float((ps[yes] < batch.alpha).mean())
        if "type_1" in truths:  # exact, without simulation
            margin = batch.assumed.margin
            found["equivalence"] = share_equivalence_power(batch.people, margin=margin, alpha=batch.alpha)
        return found


class Means(PowerMethod):
    """Paired differences of means by Student's t."""

    def shares(self, rng: np.random.Generator, batch: StudyBatch, truths: Truths) -> dict[str, float]:
        """Return power of paired differences."""
        found: dict[str, float] = {}
        assumed, alpha = batch.assumed, batch.alpha
        for name, truth in truths.items():
            gaps, columns = self.gaps(rng, batch, truth)
            found[name] = float((self.ps(gaps) < alpha).mean())
            if name == "type_1":
                found["equivalence"] = float((within_ps(gaps, assumed.margin) < alpha).mean())
                found |= columns
        return found

    def gaps(
        self, rng: np.random.Generator, batch: StudyBatch, truth: float
    ) -> tuple[Numbers, dict[str, float]]:
        """Return estimated differences, shape (study, participant), and further columns of the row."""
        gaps = rng.normal(truth, batch.assumed.person_sd, batch.shape)
        return gaps + rng.normal(0, self.noise(batch), gaps.shape), {}

    def noise(self, batch: StudyBatch) -> float:
        """Return the standard error of a participant's difference from single answers."""
        return float(batch.assumed.trial_sd / np.sqrt(batch.trials) * np.sqrt(2))

    def ps(self, gaps: Numbers) -> Numbers:
        """Return p of each study: float64 array, shape (study,), from gaps of shape (study, participant)."""
        return np.asarray(stats.ttest_1samp(gaps, 0.0, axis=1).pvalue)


class Ranks(Means):
    """Paired differences of means by Wilcoxon's signed ranks."""

    def ps(self, gaps: Numbers) -> Numbers:
        """Return p of each study."""
        return np.asarray(stats.wilcoxon(gaps, axis=1).pvalue)


class Slopes(Means):
    """Slopes over five intensities that span a factor of 16, by Student's t."""

    def noise(self, batch: StudyBatch) -> float:
        """Return the standard error of a participant's slope."""
        # Sum of squared log distances from their middle.
        spread = float(((np.linspace(0, np.log(16), 5) - np.log(4)) ** 2).sum())
        return float(batch.assumed.trial_sd / np.sqrt(batch.trials) / np.sqrt(spread))


METHODS: Mapping[str, PowerMethod] = {
    "share": Shares(),
    "votes": Votes(),
    "means": Means(),
    "ranks": Ranks(),
    "slopes": Slopes(),
}
"""Methods for any design, by ``kind`` of its assumptions."""


def clustered_ps(hits: NDArray[np.int64], trials: int, *, margin: float) -> tuple[Numbers, Numbers]:
    """Return p against one half and p of equivalence of each study, as `pooled_share`.

    With equal numbers of trials, GEE with independence has a closed form. ``hits`` has shape (study, participant).
    """
    people = hits.shape[1]
    shares = hits / trials
    share = shares.mean(1)
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = share * (1 - share)
        se = np.sqrt(((shares - share[:, None]) ** 2).sum(1)) / ((people - 1) * spread)
        se = np.where(se > 1e-9, se, 1 / np.sqrt(people * trials * spread))
        logit = special.logit(share)
        t = logit / se
        above = (special.logit(0.5 + margin) - np.abs(logit)) / se
    p = 2 * stats.t.sf(np.abs(t), people - 1)
    equal = stats.t.sf(above, people - 1)
    alike = (share == 0) | (share == 1)
    return np.where(alike, 2 * 0.5**people, p), np.where(alike, 1.0, equal)


def within_ps(gaps: Numbers, margin: float) -> Numbers:
    """Return p of equivalence of each study, as `paired_equivalence`, from gaps of shape (study, participant)."""
    people = gaps.shape[1]
    se = gaps.std(1, ddof=1) / np.sqrt(people)
    with np.errstate(divide="ignore"):  # no spread: t is infinite
        return np.asarray(stats.t.sf((margin - np.abs(gaps.mean(1))) / se, people - 1))


def _personal_shares(rng: np.random.Generator, truth: float, batch: StudyBatch) -> Numbers:
    """Return each participant's true share, with normal logits."""
    logits = special.logit(truth) + rng.normal(0, batch.assumed.person_sd, batch.shape)
    return np.asarray(special.expit(logits))

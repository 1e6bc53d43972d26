"""Pairwise preference, with the most informative pair next.

Bradley-Terry: the first of a pair is preferred with probability 1 / (1 + exp(-(u_i - u_j))) (R. A. Bradley and M. E.
Terry, Biometrika 39, 324-345, 1952). Utilities have a normal prior; the posterior is taken as normal at its mode
(Laplace). The expected information of a pair is that between its answer and the difference of utilities (D. V. Lindley,
"On a measure of the information provided by an experiment", Ann. Math. Stat. 27, 986-1005, 1956), in bits, by
Gauss-Hermite quadrature. Pairs follow from the answers of one participant alone.

Answers to the question ``preferred``: ``stimulus`` and ``other`` are the pair, ``side`` is the slot of ``stimulus``;
``answer`` is A or B, ``value`` 1 if ``stimulus`` was chosen, else 0.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram_study.designs.design import Design, MarginScale, ab_question
from tactogram_study.planned import PowerAssumptions
from tactogram_study.trials import DesignContext, History, Page, PageQuestion, Participant, generator
from tactogram_study.wording import Wording, text_field

if TYPE_CHECKING:
    from tactogram_study.simulated_observer import SimulatedObserver

NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(61)
"""61 nodes give the expected information to 2e-6 bits for differences of sd up to 3."""
Comparison = tuple[int, int]
Numbers = NDArray[np.float64]
PRIOR_SD = 3.0
"""Of log strengths: keeps those of items that always win finite, and moves others little (one SD is a factor of 20)."""
LEAST = 1e-6
"""Smaller standard errors of a difference count as 0: they are rounding."""


class PairwiseComparison(Design):
    """Settings of a test by pairs."""

    title: ClassVar[str] = "Pairwise preference"
    question_text: ClassVar[str] = "Which of two is preferred?"
    margins: ClassVar[Mapping[str, MarginScale]] = {"preference": MarginScale("of log strengths")}
    analysis: ClassVar[str] = "tactogram_study.designs.analysis.pairwise:analyse_preference"
    simulation: ClassVar[str] = "tactogram_study.designs.analysis.pairwise:Strengths"
    drawings: ClassVar[Mapping[str, str]] = {
        "pairwise": "tactogram_study.designs.analysis.pairwise:preference_figure",
    }
    power: ClassVar[Mapping[str, PowerAssumptions]] = {
        "pairwise": PowerAssumptions(
            "strengths", 0.7, "log strength of one item above the others", 0.5, 0.0, 0.7,
            (20, 40, 80), (30, 60), "comparisons of each participant, over all pairs",
            "Bradley-Terry by participant, Holm", items=6,
        )
    }  # fmt: skip
    columns: ClassVar[Mapping[str, str]] = {
        "expected_bits": "Information that was expected of this pair",
        "first": "Number of the first of the pair",
        "second": "Number of the second of the pair",
    }

    labels: ClassVar[Mapping[str, str]] = {
        "choice.informative": "the most informative pair next",
        "choice.listed": "every pair equally often",
    }

    kind: Literal["pairwise"] = "pairwise"
    choice: Literal["informative", "listed"] = Field(default="informative", title="Choice of the pairs")
    """``listed`` presents every pair ``repeats`` times by the study's order rule."""
    comparisons: int = Field(default=0, ge=0, le=100_000, title="Comparisons (0: three for each stimulus)")
    """Number of comparisons of informative pairs; 0 for three per stimulus."""
    repeats: int = Field(default=1, ge=1, le=1000, title="Repeats of each pair")
    prior_sd: float = Field(default=2.0, gt=0, le=100, title="Expected spread of preferences, logits")
    """Of the utilities, in logits. With 2, the best of many is nearly always preferred to the worst."""
    instructions: Wording = text_field("pairwise_instructions")
    preferred: Wording = text_field("pairwise_preferred", "Question")

    def check(self, setting: DesignContext) -> None:
        """Raise `ParameterError` for fewer than two stimuli."""
        if len(setting.stimuli) < 2:
            raise ParameterError(f"pairwise needs at least two stimuli, got {len(setting.stimuli)}")

    def total(self, setting: DesignContext) -> int:
        count = len(setting.stimuli)
        if self.choice == "listed":
            return self.repeats * count * (count - 1) // 2
        return self.comparisons or 3 * count

    def next_page(self, setting: DesignContext, participant: Participant, history: History) -> Page | None:
        total = self.total(setting)
        if len(history) == total:
            return None
        trial = len(history) + 1
        block, repeat, first, second, information = self._pair(setting, participant, history)
        one, two = setting.stimuli[first], setting.stimuli[second]
        side = self._sides(setting, participant)[trial - 1]
        question = ab_question("preferred", self.preferred, one, two, side, scored=False)
        a, b = (one, two) if side == "A" else (two, one)
        return self.trial_page(
            trial,
            [question],
            {"A": a, "B": b},
            block=block,
            repeat=repeat,
            total=total,
            more={"first": str(first), "second": str(second)}
            | ({} if information is None else {"expected_bits": f"{information:.4f}"}),
        )

    def power_options(self, setting: DesignContext) -> dict[str, Any]:
        return {"trials": (self.total(setting),), "items": len(setting.stimuli)}

    @classmethod
    def simulated_answer(cls, page: Page, question: PageQuestion, participant: SimulatedObserver) -> str:
        """Return the item that a participant prefers, by the difference of strengths for this participant."""
        gap = participant.strength(question.stimulus, question.condition)
        gap -= participant.strength(question.other, question.other_condition)
        return question.side if participant.yes(gap) else participant.other_option(question, question.side)

    def _sides(self, setting: DesignContext, participant: Participant) -> list[str]:
        """Return the slot of the first of the pair in each trial: drawn independently of the answers."""
        drawn = generator(setting.seed, participant.number, "sides").integers(2, size=self.total(setting))
        return ["AB"[i] for i in drawn]

    def _pair(
        self, setting: DesignContext, participant: Participant, history: History
    ) -> tuple[int, int, int, int, float | None]:
        """Return block, repeat, the pair and its expected information."""
        count = len(setting.stimuli)
        pairs = list(itertools.combinations(range(count), 2))
        if self.choice == "listed":
            order = setting.ordered(pairs, participant, repeats=self.repeats)
            block, repeat, (first, second) = order[len(history)]
            return block, repeat, first, second, None
        presented = [(int(page.facts["first"]), int(page.facts["second"])) for page in history]
        won = [
            pair if page.responses["preferred"] == side else pair[::-1]
            for page, pair, side in zip(history, presented, self._sides(setting, participant), strict=False)
        ]
        mean, covariance = posterior(won, count, prior_sd=self.prior_sd)
        expected = expected_information(mean, covariance, pairs)
        if len(pairs) > 1 and presented:
            expected[pairs.index(presented[-1])] = -np.inf
        # Ties up to rounding are drawn, so that no stimulus is favoured for its place in the file.
        best = np.flatnonzero(expected >= expected.max() - 1e-9)
        rng = generator(setting.seed, participant.number, "pair", len(history) + 1)
        chosen = int(best[rng.integers(len(best))])
        first, second = pairs[chosen]
        return 1, 1 + presented.count((first, second)), first, second, float(expected[chosen])


def posterior(won: Sequence[Comparison], count: int, *, prior_sd: float) -> tuple[np.ndarray, np.ndarray]:
    """Return mode, shape (stimulus,), and covariance of the utilities of ``count`` stimuli, in logits.

    ``won`` lists winner and loser of each comparison; the covariance is the inverse of the negative Hessian at the
    mode.
    """
    wins = np.zeros((count, count))
    for winner, loser in won:
        wins[winner, loser] += 1
    mode = bradley_terry(wins, prior_sd=prior_sd, tolerance=1e-10)
    return mode, np.linalg.inv(curvature(wins, mode, prior_sd=prior_sd))


def expected_information(mean: np.ndarray, covariance: np.ndarray, pairs: Sequence[Comparison]) -> np.ndarray:
    """Return the expected information of each pair's answer about its difference, in bits.

    H(E p) - E H(p), with p = 1 / (1 + exp(-d)) and d normal.
    """
    first, second = (np.array([pair[i] for pair in pairs]) for i in (0, 1))
    variance = covariance[first, first] + covariance[second, second] - 2 * covariance[first, second]
    d = (mean[first] - mean[second])[:, None] + np.sqrt(variance)[:, None] * NODES
    p = 1 / (1 + np.exp(-np.clip(d, -30, 30)))
    weights = WEIGHTS / WEIGHTS.sum()
    return np.asarray(_entropy(p @ weights) - _entropy(p) @ weights)


def _entropy(p: np.ndarray) -> np.ndarray:
    p = np.clip(p, 1e-15, 1 - 1e-15)
    return np.asarray(-(p * np.log2(p) + (1 - p) * np.log2(1 - p)))


def bradley_terry(wins: ArrayLike, *, prior_sd: float = PRIOR_SD, tolerance: float = 1e-5) -> Numbers:
    """Return log strengths of items, with mean 0: the maximum of the likelihood with a weak normal prior.

    ``wins``, shape (…, item, item), counts how often the row's item was preferred to the column's. Newton's method
    stops at steps below ``tolerance``; the remaining error is of the order of its square.
    """
    table = np.asarray(wins, np.float64)
    counts, won = table + np.swapaxes(table, -1, -2), table.sum(-1)
    strengths = np.zeros(table.shape[:-1])
    for _ in range(100):
        p = _preferred(strengths)
        gradient = won - (counts * p).sum(-1) - strengths / prior_sd**2
        step = np.linalg.solve(_negative_hessian(counts, p, 1 / prior_sd**2), gradient[..., None])[..., 0]
        # Concave: a bounded Newton step cannot run away.
        step *= np.minimum(1.0, 2.0 / np.maximum(np.abs(step).max(-1, keepdims=True), 1e-12))
        strengths = strengths + step
        if np.abs(step).max() < tolerance:
            break
    return np.asarray(strengths - strengths.mean(-1, keepdims=True))


def strengths_by_participant(tables: ArrayLike, *, prior_sd: float = PRIOR_SD) -> tuple[Numbers, Numbers]:
    """Return log strengths, shape (…, item), and their covariance by participant, shape (…, item, item).

    The covariance is that of the jackknife over participants, in one Newton step each: for the logit of a share this is
    that of L. A. Mancl and T. A. DeRouen (Biometrics 57, 2001). Answers of one participant may depend on each other in
    any way, and the next pair on the previous answers.

    ``tables``, shape (…, participant, item, item), count how often each of at least two participants preferred the
    row's item to the column's.
    """
    wins = np.asarray(tables, np.float64)
    people, items = wins.shape[-3], wins.shape[-1]
    strengths = bradley_terry(wins.sum(-3), prior_sd=prior_sd)
    p = _preferred(strengths)[..., None, :, :]
    counts = wins + np.swapaxes(wins, -1, -2)
    gradients, hessians = wins.sum(-1) - (counts * p).sum(-1), _negative_hessian(counts, p, 0.0)
    rest = hessians.sum(-3, keepdims=True) - hessians + np.eye(items) / prior_sd**2
    left_out = np.linalg.solve(rest, gradients[..., None])[..., 0]
    left_out -= left_out.mean(-1, keepdims=True)
    covariance = np.einsum("...pi,...pj->...ij", left_out, left_out) * (people - 1) / people
    return strengths, covariance


def curvature(wins: Numbers, strengths: Numbers, *, prior_sd: float = PRIOR_SD) -> Numbers:
    """Return the negative second derivatives of the maximum of `bradley_terry`, shape (…, item, item)."""
    return _negative_hessian(wins + np.swapaxes(wins, -1, -2), _preferred(strengths), 1 / prior_sd**2)


def gap_errors(
    covariance: Numbers, curved: Numbers, first: NDArray[np.int64], second: NDArray[np.int64]
) -> tuple[Numbers, NDArray[np.bool_]]:
    """Return the standard error of differences of two strengths, and whether all participants agree on them.

    Where they agree the jackknife has no error, however few they are; the error is then that of independent answers,
    from the `curvature` of all of them. The results have shape (…, pair).
    """
    variance = _of_gaps(covariance, first, second)
    alike = variance < LEAST**2
    if alike.any():
        alone = np.asarray(np.linalg.inv(curved), np.float64)
        variance = np.where(alike, _of_gaps(alone, first, second), variance)
    return np.sqrt(variance), alike


def _of_gaps(covariance: Numbers, first: NDArray[np.int64], second: NDArray[np.int64]) -> Numbers:
    variances = np.diagonal(covariance, axis1=-2, axis2=-1)
    return np.asarray(variances[..., first] + variances[..., second] - 2 * covariance[..., first, second])


def _preferred(strengths: Numbers) -> Numbers:
    """Return the probability that the row's item is preferred to the column's, shape (…, item, item)."""
    worth = np.exp(strengths - strengths.max(-1, keepdims=True))
    return np.asarray(worth[..., :, None] / (worth[..., :, None] + worth[..., None, :]))


def _negative_hessian(counts: Numbers, p: Numbers, prior: float) -> Numbers:
    """Return negative second derivatives, shape (…, item, item), from the number of comparisons of each pair."""
    hessian = counts * p * (p - 1)
    np.einsum("...ii->...i", hessian)[...] += prior - hessian.sum(-1)
    return np.asarray(hessian)

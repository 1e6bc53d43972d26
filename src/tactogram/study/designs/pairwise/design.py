"""Pairwise preference, asking next about the pair whose answer says most.

Bradley-Terry: the first of a pair is preferred with probability 1 / (1 + exp(-(u_i - u_j))) (R. A. Bradley and M. E.
Terry, Biometrika 39, 324-345, 1952). Utilities have a normal prior; the posterior is taken as normal at its mode
(Laplace). The expected information of a pair is that between its answer and the difference of utilities (D. V. Lindley,
"On a measure of the information provided by an experiment", Ann. Math. Stat. 27, 986-1005, 1956), in bits, by
Gauss-Hermite quadrature. Chosen so from the answers of one participant alone.

Answers to the question ``preferred``: ``stimulus`` and ``other`` are the pair, ``side`` is where ``stimulus`` was;
``answer`` is A or B, ``value`` 1 if ``stimulus`` was chosen, else 0.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.study.analysis.bradley_terry import bradley_terry, curvature
from tactogram.study.designs.design import Design, MarginScale, ab_question
from tactogram.study.orders import generator, ordered
from tactogram.study.power.assumptions import PowerAssumptions
from tactogram.study.trials import (
    DesignContext,
    Page,
    PageAnswers,
    PageQuestion,
    Participant,
    PresentedStimulus,
)
from tactogram.study.wording import Wording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tactogram.study.analysis.findings import AnalysisSection
    from tactogram.study.answers import Answers
    from tactogram.study.power.methods import PowerMethod
    from tactogram.study.simulated_participants import SimulatedParticipant
    from tactogram.study.study_analysis import AnalysisPlan

NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(61)
"""61 nodes give the expected information to 2e-6 bits for differences of sd up to 3."""
Comparison = tuple[int, int]


class PairwiseComparison(Design):
    """Values of a test by pairs."""

    title: ClassVar[str] = "Pairwise preference"
    question_text: ClassVar[str] = "Which of two is preferred?"
    margins: ClassVar[Mapping[str, MarginScale]] = {"preference": MarginScale("of log strengths")}
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

    kind: Literal["pairwise"] = "pairwise"
    choice: Literal["informative", "listed"] = "informative"
    """``listed`` asks about every pair ``repeats`` times by the study's order rule."""
    comparisons: int = Field(default=0, ge=0, le=100_000)
    """How many are asked where pairs are chosen; 0 is three for each stimulus."""
    repeats: int = Field(default=1, ge=1, le=1000)
    prior_sd: float = Field(default=2.0, gt=0, le=100)
    """Of the utilities, in logits. 2 lets the best of many be preferred to the worst nearly always."""
    instructions: Wording = Wording(ja="AとBに触れてください。", en="Touch A and B.")
    preferred: Wording = Wording(ja="どちらが良いですか。", en="Which one do you prefer?")

    def check(self, setting: DesignContext) -> None:
        """Refuse fewer than two stimuli."""
        if len(setting.stimuli) < 2:
            raise ParameterError(f"pairwise needs at least two stimuli, got {len(setting.stimuli)}")

    def total(self, setting: DesignContext) -> int:
        """Return the number of comparisons."""
        count = len(setting.stimuli)
        if self.choice == "listed":
            return self.repeats * count * (count - 1) // 2
        return self.comparisons or 3 * count

    def next_page(
        self, setting: DesignContext, participant: Participant, given: Sequence[PageAnswers]
    ) -> Page | None:
        """Return the next comparison."""
        total = self.total(setting)
        if len(given) == total:
            return None
        trial = len(given) + 1
        block, repeat, first, second, information = self._pair(setting, participant, given)
        one, two = setting.stimuli[first], setting.stimuli[second]
        side = self._sides(setting, participant)[trial - 1]
        asked = PageQuestion(
            ab_question("preferred", self.preferred),
            side=side,
            stimulus=one.item,
            condition=one.condition,
            other=two.item,
            other_condition=two.condition,
            values={slot: float(slot == side) for slot in "AB"},
        )
        a, b = (one, two) if side == "A" else (two, one)
        return Page(
            token=f"trial-{trial}.1",
            kind=self.kind,
            trial=trial,
            block=block,
            repeat=repeat,
            total=total,
            presented=(PresentedStimulus("A", a), PresentedStimulus("B", b)),
            text=self.instructions,
            asked=(asked,),
            more={"first": str(first), "second": str(second)}
            | ({} if information is None else {"expected_bits": f"{information:.4f}"}),
        )

    @classmethod
    def analyse(cls, answers: Answers, plan: AnalysisPlan) -> list[AnalysisSection]:
        """Return the strength of each item, and of every two which is preferred."""
        from tactogram.study.designs.pairwise.analysis import analyse_preference

        return [analyse_preference(answers, margin=plan.margins.get("preference"))]

    @classmethod
    def figures(cls, section: AnalysisSection, answers: Answers) -> dict[str, Figure]:
        """Return the strengths."""
        from tactogram.study.designs.pairwise.figures import preference_figure

        return {"pairwise": preference_figure(section)}

    @classmethod
    def power_method(cls, kind: str) -> PowerMethod:
        """Return that of strengths."""
        from tactogram.study.designs.pairwise.power import Strengths

        return Strengths()

    def power_options(self, setting: DesignContext) -> dict[str, Any]:
        """Return the numbers of comparisons and items."""
        return {"trials": (self.total(setting),), "items": len(setting.stimuli)}

    @classmethod
    def simulated_answer(cls, page: Page, asked: PageQuestion, participant: SimulatedParticipant) -> str:
        """Return the item that a participant prefers, by the difference of their own strengths."""
        gap = participant.strength(asked.stimulus, asked.condition)
        gap -= participant.strength(asked.other, asked.other_condition)
        return asked.side if participant.yes(gap) else participant.other_option(asked, asked.side)

    def _sides(self, setting: DesignContext, participant: Participant) -> list[str]:
        """Return where the first of the pair of each trial is: drawn, whatever was answered."""
        drawn = generator(setting.seed, participant.number, "sides").integers(2, size=self.total(setting))
        return ["AB"[i] for i in drawn]

    def _pair(
        self, setting: DesignContext, participant: Participant, given: Sequence[PageAnswers]
    ) -> tuple[int, int, int, int, float | None]:
        """Return block, repeat, the pair and its expected information."""
        count, rule, seed = len(setting.stimuli), setting.order, setting.seed
        pairs = list(itertools.combinations(range(count), 2))
        if self.choice == "listed":
            order = ordered(pairs, rule=rule, repeats=self.repeats, seed=seed, participant=participant.number)
            block, repeat, (first, second) = order[len(given)]
            return block, repeat, first, second, None
        asked = [(int(one.facts["first"]), int(one.facts["second"])) for one in given]
        won = [
            pair if one.responses["preferred"] == side else pair[::-1]
            for one, pair, side in zip(given, asked, self._sides(setting, participant), strict=False)
        ]
        mean, covariance = posterior(won, count, prior_sd=self.prior_sd)
        expected = expected_information(mean, covariance, pairs)
        if len(pairs) > 1 and asked:
            expected[pairs.index(asked[-1])] = -np.inf
        # To rounding equal: which of them is drawn, so that no stimulus is favoured for its place in the file.
        best = np.flatnonzero(expected >= expected.max() - 1e-9)
        rng = generator(seed, participant.number, "pair", len(given) + 1)
        chosen = int(best[rng.integers(len(best))])
        first, second = pairs[chosen]
        return 1, 1 + asked.count((first, second)), first, second, float(expected[chosen])


def posterior(won: Sequence[Comparison], count: int, *, prior_sd: float) -> tuple[np.ndarray, np.ndarray]:
    """Return mode and covariance of the utilities of ``count`` stimuli.

    Parameters
    ----------
    won : sequence of (int, int)
        Which was preferred to which.
    count : int
    prior_sd : float
        In logits.

    Returns
    -------
    mean : float64 array, shape (stimulus,)
    covariance : float64 array, shape (stimulus, stimulus)
        Inverse of the negative Hessian at the mode.
    """
    wins = np.zeros((count, count))
    for winner, loser in won:
        wins[winner, loser] += 1
    mode = bradley_terry(wins, prior_sd=prior_sd, tolerance=1e-10)
    return mode, np.linalg.inv(curvature(wins, mode, prior_sd=prior_sd))


def expected_information(mean: np.ndarray, covariance: np.ndarray, pairs: Sequence[Comparison]) -> np.ndarray:
    """Return how much the answer to each pair is expected to tell about its difference: float64 array, bits.

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

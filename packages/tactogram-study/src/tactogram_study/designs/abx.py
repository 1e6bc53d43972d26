"""ABX: X is either A or B.

W. A. Munson and M. B. Gardner, "Standardizing auditory tests", J. Acoust. Soc. Am. 22, 675 (1950).

Answers to the question ``which``: ``stimulus`` and ``condition`` are those of X, ``other`` is the other of the pair;
``side`` and ``answer`` are A or B; ``value`` is 1 if correct, else 0.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

from pydantic import Field

from tactogram.errors import ParameterError
from tactogram_study.designs.design import Design, MarginScale, ab_question
from tactogram_study.planned import GEE, PowerAssumptions
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import DesignContext, History, Page, Participant, Slot, balanced_sides, generator
from tactogram_study.wording import Wording, text_field

if TYPE_CHECKING:
    from tactogram_study.analysis.findings import AnalysisSection
    from tactogram_study.answers import Answers
    from tactogram_study.planned import AnalysisPlan
    from tactogram_study.simulated_observer import SimulatedObserver

PLACES = ("A A", "A B", "B A", "B B")
"""Slot of the pair's first stimulus, and that of X: each once in four trials."""


class Abx(Design):
    """Settings of an ABX test."""

    title: ClassVar[str] = "ABX"
    question_text: ClassVar[str] = "Is X the same as A or as B?"
    has_right_answers: ClassVar[bool] = True
    margins: ClassVar[Mapping[str, MarginScale]] = {"abx": MarginScale("of the share correct", below=0.5)}
    drawings: ClassVar[Mapping[str, str]] = {
        "abx_correct": "tactogram_study.analysis.figures:correct_figure",
    }
    power: ClassVar[Mapping[str, PowerAssumptions]] = {
        "abx": PowerAssumptions(
            "share", 0.6, "share correct of a typical participant (person_sd: of logits)", 0.4, 0.0, 0.1,
            (10, 20), (12, 48), "answers of each participant", GEE,
        )
    }  # fmt: skip

    kind: Literal["abx"] = "abx"
    pairs: tuple[tuple[str, str], ...] = ()
    """Names of stimuli. By default all pairs of conditions within each item, or all pairs if no item has two."""
    repeats: int = Field(default=4, ge=1, le=1000, title="Repeats of each pair")
    """Trials of each pair; with a multiple of four each arrangement of A, B and X comes equally often."""
    instructions: Wording = text_field("abx_instructions")
    which: Wording = text_field("abx_which", "Question")

    def check(self, setting: DesignContext) -> None:
        """Raise `ParameterError` for unknown stimuli in pairs, and for a study without any pair."""
        if not self._pairs(setting):
            raise ParameterError("abx needs at least two stimuli, got one")

    def total(self, setting: DesignContext) -> int:
        return self.repeats * len(self._pairs(setting))

    def practice_design(self, names: Sequence[str]) -> Self:
        return self.model_copy(
            update={"pairs": tuple(pair for pair in self.pairs if set(pair) <= set(names))}
        )

    def next_page(self, setting: DesignContext, participant: Participant, history: History) -> Page | None:
        pairs = self._pairs(setting)
        if len(history) == self.repeats * len(pairs):
            return None
        order = setting.ordered(range(len(pairs)), participant, repeats=self.repeats)
        rng = generator(setting.seed, participant.number, "places")
        places = [balanced_sides(self.repeats, rng, PLACES) for _ in pairs]
        trial = len(history) + 1
        block, repeat, which = order[trial - 1]
        first_at, x_is = places[which][repeat - 1].split()
        a, b = pairs[which] if first_at == "A" else pairs[which][::-1]
        x, not_x = (a, b) if x_is == "A" else (b, a)
        question = ab_question("which", self.which, x, not_x, x_is)
        slots: dict[Slot, Stimulus | None] = {"A": a, "B": b, "X": x}
        return self.trial_page(trial, [question], slots, block=block, repeat=repeat, total=len(order))

    @classmethod
    def analyse(cls, answers: Answers, plan: AnalysisPlan) -> list[AnalysisSection]:
        """Return the shares correct, over all and by texture, with the d' of ABX."""
        from tactogram_study.analysis.discrimination import analyse_discrimination
        from tactogram_study.statistics import d_prime_abx

        margin = plan.margins.get("abx")
        return [
            analyse_discrimination(
                answers, title="ABX: is X A or B?", d_prime=d_prime_abx, margin=margin, alpha=plan.alpha
            )
        ]

    def power_options(self, setting: DesignContext) -> dict[str, Any]:
        return {"trials": (self.total(setting),)}

    @classmethod
    def simulated_share(cls, page: Page, participant: SimulatedObserver) -> float:
        """Return the share correct in ABX at a simulated participant's d'."""
        from tactogram_study.statistics import abx_share

        return abx_share(participant.d_prime)

    def _pairs(self, setting: DesignContext) -> list[tuple[Stimulus, Stimulus]]:
        stimuli = {stimulus.name: stimulus for stimulus in setting.stimuli}
        if self.pairs:
            for name in itertools.chain.from_iterable(self.pairs):
                if name not in stimuli:
                    raise ParameterError(
                        f"pairs name {name!r}, which is no stimulus; there are {', '.join(stimuli)}"
                    )
            return [(stimuli[first], stimuli[second]) for first, second in self.pairs]
        every = list(itertools.combinations(setting.stimuli, 2))
        within = [(first, second) for first, second in every if first.item == second.item]
        return within or every

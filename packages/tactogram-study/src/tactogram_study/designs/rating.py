"""Ratings: several words on scales of steps, felt with or without an image in the line of sight.

[1], [2] as in `tactogram_study.designs.single_stimulus`. Answers: a question per word; ``value`` is the step.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from pydantic import Field

from tactogram.errors import ParameterError
from tactogram_study.designs.design import MarginScale
from tactogram_study.designs.single_stimulus import WordScales
from tactogram_study.planned import PowerAssumptions
from tactogram_study.questions import Question
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import DesignContext, PageQuestion
from tactogram_study.wording import Wording, text_field

if TYPE_CHECKING:
    from tactogram_study.analysis.findings import AnalysisSection
    from tactogram_study.answers import Answers
    from tactogram_study.planned import AnalysisPlan


class WordRating(WordScales):
    """Words on a scale of steps, felt with or without an image in the line of sight."""

    title: ClassVar[str] = "Ratings"
    question_text: ClassVar[str] = "How well does each word fit, in steps?"
    gives_targets: ClassVar[bool] = True
    margins: ClassVar[Mapping[str, MarginScale]] = {"rating": MarginScale("points")}
    drawings: ClassVar[Mapping[str, str]] = {
        "rating_conditions": "tactogram_study.designs.analysis.rating:conditions_figure",
        "rating_words": "tactogram_study.designs.analysis.rating:words_figure",
    }
    power: ClassVar[Mapping[str, PowerAssumptions]] = {
        "rating": PowerAssumptions(
            "ranks", 0.2, "points of mean absolute error between conditions", 0.2, 0.9, 0.2,
            (10, 20), (12, 120), "scores of each participant and condition", "Wilcoxon signed ranks",
        )
    }  # fmt: skip

    kind: Literal["rating"] = "rating"
    low: int = Field(default=1, title="Lowest step")
    high: int = Field(default=7, title="Highest step")
    """Ends of the scale. [1], Sec. III-A: "a 7-point unipolar scale ranging from 1 (negative) to 7 (positive)"."""
    low_text: Wording = text_field("rating_low_text", "Text at the lower end")
    high_text: Wording = text_field("rating_high_text", "Text at the upper end")
    image_mm: float = Field(default=30.0, gt=0, le=1000, title="Side of a picture, mm")
    """Side of the square image, where a stimulus has one ([2], Sec. II-D: "adjusted to a size of 30 mm square")."""
    instructions: Wording = text_field("rating_instructions")

    def check(self, setting: DesignContext) -> None:
        """Raise `ParameterError` unless low < high."""
        if self.low >= self.high:
            raise ParameterError(f"rating needs low < high, got {self.low} and {self.high}")

    @classmethod
    def analyse(cls, answers: Answers, plan: AnalysisPlan) -> list[AnalysisSection]:
        """Return the errors of scores to the plan's targets, or the scores, by condition."""
        from tactogram_study.designs.analysis.rating import analyse_words

        return [
            analyse_words(
                answers,
                rng=plan.generator(),
                targets=plan.targets,
                reference=plan.reference,
                margin=plan.margins.get("rating"),
                draws=plan.draws,
            )
        ]

    def layout(self) -> dict[str, Any]:
        return {"image_mm": self.image_mm}

    def word_question(self, word: str, stimulus: Stimulus) -> PageQuestion:
        question = Question(
            id=word,
            text=self.word_text(word),
            kind="steps",
            low=self.low,
            high=self.high,
            low_text=self.low_text,
            high_text=self.high_text,
        )
        return PageQuestion(question, stimulus=stimulus.item, condition=stimulus.condition)

"""Ratings: each of several words on a scale of steps, felt with or without an image in the line of sight.

[1], [2] as in `tactogram.study.designs.word_scales`.
"""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.study.designs.word_scales import WordScales
from tactogram.study.questions import Question
from tactogram.study.stimuli import Stimulus
from tactogram.study.trials import DesignContext, PageQuestion
from tactogram.study.wording import Wording


class Rating(WordScales):
    """Words on a scale of steps, felt with or without an image in the line of sight."""

    kind: Literal["rating"] = "rating"
    low: int = 1
    high: int = 7
    """[1], Sec. III-A: "a 7-point unipolar scale ranging from 1 (negative) to 7 (positive)"."""
    low_text: Wording = Wording(ja="まったくあてはまらない", en="not at all")
    high_text: Wording = Wording(ja="非常にあてはまる", en="very much")
    image_mm: float = Field(default=30.0, gt=0, le=1000)
    """Side of the square image, where a stimulus has one ([2], Sec. II-D: "adjusted to a size of 30 mm square")."""
    instructions: Wording = Wording(
        ja="触って、それぞれのことばがどれくらいあてはまるか答えてください。",
        en="Touch it, and say how well each word fits.",
    )

    def check(self, setting: DesignContext) -> None:
        """Refuse a scale without length."""
        if self.low >= self.high:
            raise ParameterError(f"rating needs low < high, got {self.low} and {self.high}")

    def _layout(self) -> dict[str, Any]:
        return {"image_mm": self.image_mm}

    def _asked(self, word: str, stimulus: Stimulus) -> PageQuestion:
        question = Question(
            id=word,
            text=self._word_text(word),
            kind="steps",
            low=self.low,
            high=self.high,
            low_text=self.low_text,
            high_text=self.high_text,
        )
        return PageQuestion(question, stimulus=stimulus.item, condition=stimulus.condition)

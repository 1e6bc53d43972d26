"""Questions to a participant, and their valid answers."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from tactogram.errors import ParameterError
from tactogram.validation import DescribedModel
from tactogram_study.wording import Wording

LONGEST_TEXT = 2000
"""Characters of a free-text answer."""
IDENTIFIER = r"^[A-Za-z][A-Za-z0-9_-]{0,63}$"
Identifier = Annotated[str, Field(pattern=IDENTIFIER)]


class AnswerOption(DescribedModel):
    """Option of a choice."""

    value: Annotated[str, Field(min_length=1, max_length=100)]
    """Stored answer."""
    text: Wording = Wording()
    """Label; the value by default."""

    @model_validator(mode="after")
    def _text_by_default(self) -> Self:
        if not self.text:
            object.__setattr__(self, "text", Wording(self.value))
        return self


class Question(DescribedModel):
    """Question of a study's file."""

    id: Identifier
    text: Wording
    kind: Literal["choice", "steps", "vas", "number", "text"]
    """``choice`` of ``options``; ``steps`` from ``low`` to ``high``, whole numbers; ``vas``, a line from ``low`` to
    ``high`` without marks; ``number`` from ``low`` to ``high``; free ``text``."""
    options: tuple[AnswerOption, ...] = ()
    low: float = Field(default=math.nan)
    high: float = Field(default=math.nan)
    low_text: Wording = Wording()
    """At the lower end."""
    high_text: Wording = Wording()
    """At the upper end."""
    required: bool = True

    @model_validator(mode="after")
    def _whole(self) -> Self:
        if self.kind == "choice":
            values = [option.value for option in self.options]
            if len(values) < 2 or len(set(values)) != len(values):
                raise ValueError(f"{self.id}: a choice needs at least two different options")
        elif self.options:
            raise ValueError(f"{self.id}: only a choice has options")
        if self.kind in ("steps", "vas") and not self.low < self.high:
            raise ValueError(f"{self.id}: {self.kind} needs low < high")
        if self.kind == "steps" and (self.low % 1 or self.high % 1):
            raise ValueError(f"{self.id}: steps go from one whole number to another")
        return self

    def accepted(self, text: str) -> str:
        """Return an answer as it is stored; raise `ParameterError` if it is no option, off the scale, or missing."""
        text = text.strip()
        if not text:
            if self.required:
                raise ParameterError(f"{self.id}: must be answered, got nothing")
            return ""
        if self.kind == "text":
            if len(text) > LONGEST_TEXT:
                raise ParameterError(
                    f"{self.id}: must have at most {LONGEST_TEXT} characters, got {len(text)}"
                )
            return text
        if self.kind == "choice":
            values = [option.value for option in self.options]
            if text not in values:
                raise ParameterError(f"{self.id}: must be one of {', '.join(values)}, got {text[:60]!r}")
            return text
        return self._number(text)

    @property
    def example(self) -> str:
        """An accepted answer."""
        if self.kind == "choice":
            return self.options[0].value
        limits = [limit for limit in (self.low, self.high) if math.isfinite(limit)]
        return "-" if self.kind == "text" else f"{(limits or [0.0])[0]:.17g}"

    def _number(self, text: str) -> str:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        low = -math.inf if math.isnan(self.low) else self.low
        high = math.inf if math.isnan(self.high) else self.high
        if not (math.isfinite(value) and low <= value <= high) or (self.kind == "steps" and value % 1):
            kind = "a whole number" if self.kind == "steps" else "a number"
            limits = " and ".join(
                text
                for text, limit in ((f"at least {low:g}", low), (f"at most {high:g}", high))
                if math.isfinite(limit)
            )
            raise ParameterError(f"{self.id}: must be {kind} {limits}".rstrip() + f", got {text[:60]!r}")
        return repr(int(value)) if value % 1 == 0 and abs(value) < 1e15 else repr(value)

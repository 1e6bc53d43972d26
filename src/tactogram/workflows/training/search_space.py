"""Search space of a sweep: ranges and choices of a recipe's values."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tactogram.text_files import read_toml
from tactogram.validation import validated


class Dimension(BaseModel):
    """Values of one key: ``choices``, or the range from ``low`` to ``high``, both included."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    choices: tuple[Any, ...] = ()
    low: float | None = None
    high: float | None = None
    log: bool = False
    """Draw the logarithm evenly."""
    integer: bool = False

    @model_validator(mode="after")
    def _choices_or_range(self) -> Self:
        ranged = self.low is not None and self.high is not None
        if bool(self.choices) == ranged or (self.low is None) != (self.high is None):
            raise ValueError("must have choices, or low and high")
        if self.low is not None and self.high is not None:
            if not self.low < self.high:
                raise ValueError(f"low must be < high, got {self.low:g} and {self.high:g}")
            if self.log and self.low <= 0:
                raise ValueError(f"low must be > 0 with log, got {self.low:g}")
            if self.integer and not (self.low.is_integer() and self.high.is_integer()):
                raise ValueError(
                    f"low and high must be whole with integer, got {self.low:g} and {self.high:g}"
                )
        return self


class SearchSpace(BaseModel):
    """A sweep: what is varied, and by which figure of the validation trials are compared."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    measure: str
    """A key of the model's validation, such as ``recording_accuracy``."""
    goal: Literal["max", "min"]
    trials: int = Field(default=16, ge=1)
    seed: int = Field(default=0, ge=0)
    vary: dict[str, Dimension] = Field(min_length=1)
    """By dotted key of the recipe."""

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a TOML file; a `ParameterError` names the key that is wrong."""
        return validated(cls, read_toml(path), where=str(path))

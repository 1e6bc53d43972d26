"""Learner that is trained in one step on all examples."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from tactogram.model import Stage


class OneStepLearner:
    """Setup, stage and batch of models with a closed form, or without weights; they compute on the processor."""

    stage = "fit"

    def setup(self, fabric: Any) -> None:
        """Do nothing: no network is trained."""

    def stages(self, examples: Sequence[Any]) -> tuple[Stage, ...]:
        """Return the one stage."""
        return (Stage(self.stage, 1),)

    def batches(self, stage: Stage, examples: Sequence[Any], *, seed: int, start: int = 0) -> Iterator[Any]:
        """Yield ``examples``, the one batch."""
        if start == 0:
            yield examples

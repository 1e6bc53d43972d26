"""The label of a signal: a weight per material, and speed and force, standardised."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.model import Condition, Example

NUMBERS = ("speed_mm_s", "force_n")
"""Conditions that are numbers."""


class Number(NamedTuple):
    """A numeric condition over the training recordings."""

    median: float
    deviation: float
    least: float
    most: float

    def standardised(self, value: float) -> float:
        """Return ``value``, or the nearest of the recordings', so that the median is 0 and a deviation 1."""
        if self.deviation == 0:
            return 0.0
        return (min(max(float(value), self.least), self.most) - self.median) / self.deviation


class Labels:
    """Labels of the networks from the conditions of signals.

    Parameters
    ----------
    names : sequence of str
        The numbers, of `NUMBERS`, that stand beside the materials: ``config.conditions``.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self.known: Mapping[str, Number] = {}
        """The numbers that every training recording has, in the label or not."""

    def fit(self, examples: Sequence[Example]) -> None:
        """Measure the numeric conditions of the training part."""
        found: dict[str, Number] = {}
        for name in NUMBERS:
            values = [example.condition.get(name) for example in examples]
            if all(value is not None for value in values):
                x = np.array(values, np.float64)
                found[name] = Number(float(np.median(x)), float(x.std()), float(x.min()), float(x.max()))
        self.known = found

    def label(self, weights: NDArray[np.float64], condition: Condition) -> Tensor:
        """Return the label, float32, shape (C,); ``weights``, shape (material,), go in as they are."""
        return torch.tensor([*weights, *self.numbers(condition)], dtype=torch.float32)

    def numbers(self, condition: Condition) -> list[float]:
        """Return the numeric conditions, standardised: 0 is the median, and stands for what is not known."""
        return [self._standardised(name, condition.get(name)) for name in self.names]

    def check(self, condition: Condition) -> None:
        """Refuse a speed or force that is invalid or was not learned.

        Raises
        ------
        ParameterError
            If it is not finite or below 0, if the recordings have none, or if it is beyond theirs and not in the label.
        """
        for name in NUMBERS:
            value = condition.get(name)
            if value is None:
                continue
            if not (np.isfinite(value) and value >= 0):
                raise ParameterError(f"{name} must be finite and >= 0, got {value}")
            if name not in self.known:
                raise ParameterError(f"{name} is not known of the training recordings; leave it out")
            known = self.known[name]
            if name not in self.names and not known.least <= value <= known.most:
                raise ParameterError(
                    f"{name} was {known.least:g} to {known.most:g} in training and is not one of "
                    f"config.conditions, got {value:g}; leave it out"
                )

    def state(self) -> dict[str, Any]:
        """Return what was fitted."""
        return {name: list(values) for name, values in self.known.items()}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`."""
        self.known = {name: Number(*values) for name, values in state.items()}

    def _standardised(self, name: str, value: float | None) -> float:
        known = self.known.get(name)
        return 0.0 if value is None or known is None else known.standardised(value)

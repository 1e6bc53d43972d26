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


class ConditionRange(NamedTuple):
    """Distribution of a numeric condition over the training recordings."""

    median: float
    deviation: float
    least: float
    most: float

    def standardised(self, value: float) -> float:
        """Return ``value``, limited to the recorded range, so that the median is 0 and a deviation 1."""
        if self.deviation == 0:
            return 0.0
        return (min(max(float(value), self.least), self.most) - self.median) / self.deviation


class Labels:
    """Labels of the networks; ``names`` are the numbers in them, after the materials: ``config.conditions``."""

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self.ranges: Mapping[str, ConditionRange] = {}
        """Ranges of the numbers that every training recording has, in the label or not."""

    def fit(self, examples: Sequence[Example]) -> None:
        """Measure the numeric conditions of the training part."""
        ranges: dict[str, ConditionRange] = {}
        for name in NUMBERS:
            values = [example.condition.get(name) for example in examples]
            if all(value is not None for value in values):
                x = np.array(values, np.float64)
                ranges[name] = ConditionRange(
                    float(np.median(x)), float(x.std()), float(x.min()), float(x.max())
                )
        self.ranges = ranges

    def label(self, weights: NDArray[np.float64], condition: Condition) -> Tensor:
        """Return the label, float32, shape (C,); ``weights``, shape (material,), are not scaled."""
        return torch.tensor([*weights, *self.numbers(condition)], dtype=torch.float32)

    def numbers(self, condition: Condition) -> list[float]:
        """Return the numeric conditions, standardised; 0, the median, if unknown."""
        return [self._standardised(name, condition.get(name)) for name in self.names]

    @property
    def limited(self) -> dict[str, tuple[float, float]]:
        """Lowest and highest of each number of the label; one beyond counts as the nearest of these."""
        return {name: self.ranges[name][2:] for name in self.names if name in self.ranges}

    def check(self, condition: Condition) -> None:
        """Refuse a speed or force that is invalid or was not learned.

        Raises
        ------
        ParameterError
            If it is not finite or below 0, if the recordings have none, or if it is outside their range and not in the
            label.
        """
        for name in NUMBERS:
            value = condition.get(name)
            if value is None:
                continue
            if not (np.isfinite(value) and value >= 0):
                raise ParameterError(f"{name} must be finite and >= 0, got {value}")
            if name not in self.ranges:
                raise ParameterError(f"{name} is unknown for the training recordings; omit it")
            trained = self.ranges[name]
            if name not in self.names and not trained.least <= value <= trained.most:
                raise ParameterError(
                    f"{name} was {trained.least:g} to {trained.most:g} in training and is not one of "
                    f"config.conditions, got {value:g}; omit it"
                )

    def state(self) -> dict[str, Any]:
        """Return the ranges."""
        return {name: list(values) for name, values in self.ranges.items()}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Continue from `state`."""
        self.ranges = {name: ConditionRange(*values) for name, values in state.items()}

    def _standardised(self, name: str, value: float | None) -> float:
        trained = self.ranges.get(name)
        return 0.0 if value is None or trained is None else trained.standardised(value)

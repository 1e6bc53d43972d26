"""Selection of an adversarial training's iteration: the rule of the ultrasonic CGAN, and running averages.

"Conditional Generative Adversarial Network-Based Tactile Stimulus Generation for Ultrasonic Tactile Display",
Sec. IV-C: "the generator was selected at a point in the iterations where the generator's loss was the smallest non-zero
value and the discriminator's correct response rate was between 40% and 60%. … If the above conditions were not
satisfied during training, we defined the training as a failure." Here, the rate is averaged over
iterations: that of one batch is too noisy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError


@dataclass(frozen=True)
class SelectionRule:
    """Smallest non-zero loss of the generator at a smoothed correct rate from ``low`` to ``high``, inclusive."""

    low: float = 0.4
    high: float = 0.6
    window: int = 100
    """Iterations over which the rate is averaged: the current one and those before it, so that the rule works during
    training. The first ``window`` - 1 iterations cannot be selected."""
    after: int = 0
    """Initial iterations that cannot be selected: an untrained discriminator is right in half of the cases, too."""

    def __post_init__(self) -> None:
        if not 0 <= self.low < self.high <= 1:
            raise ParameterError.must(
                "limits", f"be 0 <= low < high <= 1, got {self.low:g} and {self.high:g}"
            )
        if self.window < 1 or self.after < 0:
            raise ParameterError.must(
                "window", f"be at least 1 and after at least 0, got {self.window} and {self.after}"
            )


@dataclass(frozen=True)
class SelectedIteration:
    """A selected iteration, counted from 1, with the generator's loss and the smoothed correct rate."""

    iteration: int
    loss: float
    rate: float


def choose(
    losses: NDArray[np.floating], rates: NDArray[np.floating], rule: SelectionRule
) -> SelectedIteration | None:
    """Return the iteration that ``rule`` selects, the first of equals; None if the training failed.

    ``losses`` of the generator and ``rates`` of the discriminator's correct answers have shape (iteration,).
    """
    losses = np.asarray(losses, np.float64)
    averaged = smoothed(rates, rule.window)
    with np.errstate(invalid="ignore"):
        allowed = (losses > 0) & (averaged >= rule.low) & (averaged <= rule.high)
    allowed[: rule.after] = False
    if not allowed.any():
        return None
    index = int(np.argmin(np.where(allowed, losses, np.inf)))
    return SelectedIteration(index + 1, float(losses[index]), float(averaged[index]))


def smoothed(values: NDArray[np.floating], window: int) -> NDArray[np.float64]:
    """Return the mean of each value and the ``window`` - 1 before it, shape (iteration,); NaN where there are fewer."""
    values = np.asarray(values, np.float64)
    averaged = np.full(len(values), np.nan)
    if len(values) >= window:
        averaged[window - 1 :] = np.lib.stride_tricks.sliding_window_view(values, window).mean(axis=1)
    return averaged


class IterationSelector:
    """Selection during training, with only the last ``window`` rates in memory.

    ``seen`` is the number of past iterations, ``rates`` their last rates, and ``chosen`` the best so far.
    """

    def __init__(
        self,
        rule: SelectionRule,
        chosen: SelectedIteration | None = None,
        rates: tuple[float, ...] = (),
        seen: int = 0,
    ) -> None:
        self.rule, self.chosen, self.seen = rule, chosen, seen
        self._ring = np.full(rule.window, np.nan)
        last = rates[-rule.window :]
        for number, rate in enumerate(last, start=seen - len(last)):
            self._ring[number % rule.window] = rate

    def update(self, loss: float, rate: float) -> bool:
        """Add an iteration; return whether it is the best so far, so that its weights must be saved."""
        self._ring[self.seen % self.rule.window] = rate
        self.seen += 1
        if self.chosen is not None and loss >= self.chosen.loss:
            return False
        rule, averaged = self.rule, self.rate
        if not (self.seen > rule.after and loss > 0 and rule.low <= averaged <= rule.high):
            return False
        self.chosen = SelectedIteration(self.seen, loss, averaged)
        return True

    @property
    def rate(self) -> float:
        """The current smoothed rate; NaN before ``window`` iterations."""
        # In order of time: another order changes the last digit of the mean.
        return float(np.roll(self._ring, -(self.seen % self.rule.window)).mean())

"""Selection of an adversarial training's iteration: the rule of the ultrasonic CGAN, and running averages.

"Conditional Generative Adversarial Network-Based Tactile Stimulus Generation for Ultrasonic Tactile Display",
Sec. IV-C: "the generator was selected at a point in the iterations where the generator's loss was the smallest non-zero
value and the discriminator's correct response rate was between 40% and 60%. … If the above conditions were not
satisfied during training, we defined the training as a failure." The rate is averaged over iterations here: that of one
batch is too noisy to go by.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError


@dataclass(frozen=True)
class SelectionRule:
    """Smallest non-zero loss of the generator where the smoothed correct rate is within limits.

    Parameters
    ----------
    low, high : float
        Limits of the smoothed rate, both included.
    window : int
        Iterations that the rate is averaged over: the one in question and those before it, none after it, so that
        the rule can be followed while training. Before ``window`` iterations are done, none is taken.
    after : int
        None of the first so many iterations is taken: an untrained discriminator is right in half of the cases too.
    """

    low: float = 0.4
    high: float = 0.6
    window: int = 100
    after: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.low < self.high <= 1:
            raise ParameterError(f"limits must be 0 <= low < high <= 1, got {self.low:g} and {self.high:g}")
        if self.window < 1 or self.after < 0:
            raise ParameterError(
                f"window must be at least 1 and after at least 0, got {self.window} and {self.after}"
            )

    def allows(self, iteration: int, loss: float, smoothed_rate: float) -> bool:
        """Say whether an iteration, counted from 1, may be taken at all."""
        return iteration > self.after and loss > 0 and self.low <= smoothed_rate <= self.high


@dataclass(frozen=True)
class SelectedIteration:
    """The iteration that was taken.

    Parameters
    ----------
    iteration : int
        From 1.
    loss : float
        Of the generator, at that iteration.
    rate : float
        The smoothed correct rate there.
    """

    iteration: int
    loss: float
    rate: float


def choose(
    losses: NDArray[np.floating], rates: NDArray[np.floating], rule: SelectionRule
) -> SelectedIteration | None:
    """Return the iteration that ``rule`` takes, the first of equals; None says that the training failed.

    Parameters
    ----------
    losses : array, shape (iteration,)
        Of the generator.
    rates : array, shape (iteration,)
        Share of its answers that the discriminator got right.
    """
    losses = np.asarray(losses, np.float64)
    averaged = smoothed(rates, rule.window)
    with np.errstate(invalid="ignore"):
        allowed = (losses > 0) & (averaged >= rule.low) & (averaged <= rule.high)
    allowed[: rule.after] = False
    if not allowed.any():
        return None
    place = int(np.argmin(np.where(allowed, losses, np.inf)))
    return SelectedIteration(place + 1, float(losses[place]), float(averaged[place]))


def smoothed(values: NDArray[np.floating], window: int) -> NDArray[np.float64]:
    """Return the mean of each value and the ``window`` - 1 before it, shape (iteration,); NaN where there are fewer."""
    values = np.asarray(values, np.float64)
    averaged = np.full(len(values), np.nan)
    if len(values) >= window:
        averaged[window - 1 :] = np.lib.stride_tricks.sliding_window_view(values, window).mean(axis=1)
    return averaged


class IterationSelector:
    """Follows a rule while the training goes on, with no more than the last ``window`` rates.

    Parameters
    ----------
    chosen : Chosen, optional
        The best so far.
    rates : sequence of float
        The last ones; fewer than ``rule.window`` at the beginning.
    seen : int
        Iterations that are done.
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
        """Take in one iteration; say whether it is the best so far, so that its weights must be kept."""
        self._ring[self.seen % self.rule.window] = rate
        self.seen += 1
        if self.chosen is not None and loss >= self.chosen.loss:
            return False
        averaged = self.rate
        if not self.rule.allows(self.seen, loss, averaged):
            return False
        self.chosen = SelectedIteration(self.seen, loss, averaged)
        return True

    @property
    def rate(self) -> float:
        """The smoothed rate now; NaN before ``window`` iterations are done."""
        # In the order of time: a mean in another order is another number in its last digit.
        return float(np.roll(self._ring, -(self.seen % self.rule.window)).mean())

"""What a study can show before it is run: exact for independent answers, and with simulated participants who differ.

A table has a row per number of participants and of trials of each. What an exact binomial test promises holds for
independent answers only; people differ, which the columns that are simulated take in.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.study.power.kinds import PowerAssumptions, equivalence_of, row_of

MOST_TRIALS = 10_000
MOST_PARTICIPANTS = 10_000
ENOUGH = 0.8
"""Share of studies that are to show equivalence, where the number of participants is looked for that reaches it."""
TRIED = (6, 8, 10, 15, 20, 30, 40, 60, 80, 120, 160, 240)
TRIED_SIMULATIONS = 200
TAKING, LOOKING = "simulated participants", "how many for equivalence"
"""Tasks that progress is told of."""

GEE, EXACT = "GEE by participant", "exact binomial of all answers"
DESIGNS: Mapping[str, PowerAssumptions] = {
    "two_area": PowerAssumptions(
        "share", 0.6, "share correct of a typical participant (person_sd: of logits)", 0.4, 0.0, 0.1,
        (10, 20), (10, 30, 90), "answers of each participant", GEE, EXACT,
    ),
    "realism": PowerAssumptions(
        "means", 5.0, "mm between conditions", 5.0, 15.0, 5.0,
        (10, 20), (10, 90), "marks of each participant and condition", "paired t", "Student's t of all marks", 10.0,
    ),
    "rating": PowerAssumptions(
        "ranks", 0.2, "points of mean absolute error between conditions", 0.2, 0.9, 0.2,
        (10, 20), (12, 120), "scores of each participant and condition", "Wilcoxon signed ranks",
        "Student's t of all scores", 0.3,
    ),
    "evoked": PowerAssumptions(
        "votes", 0.7, "share of people in whom it is evoked", 0.5, 0.0, 0.2,
        (10, 20, 30, 60), (1,), "answers of each participant to an image and word", EXACT,
    ),
    "abx": PowerAssumptions(
        "share", 0.6, "share correct of a typical participant (person_sd: of logits)", 0.4, 0.0, 0.1,
        (10, 20), (12, 48), "answers of each participant", GEE, "",
    ),
    "staircase": PowerAssumptions(
        "staircases", 3.0, "dB between two thresholds (trial_sd: slope of logistic functions, per dB)", 2.0, 0.5, 3.0,
        (6, 12), (40, 80), "trials of each staircase", "paired t of thresholds by reversals",
    ),
    "magnitude": PowerAssumptions(
        "slopes", 0.1, "of the exponent from 1 (trial_sd: of log estimates)", 0.15, 0.3, 0.1,
        (8, 16), (3, 6), "estimates of each of five intensities over a factor of 16", "t of slopes",
    ),
    "pairwise": PowerAssumptions(
        "strengths", 0.7, "log strength of one item above the others", 0.5, 0.0, 0.7,
        (20, 40, 80), (30, 60), "comparisons of each participant, over all pairs", "Bradley-Terry by participant, Holm",
        items=6,
    ),
}  # fmt: skip
"""``staircase``: person_sd is of people's differences, trial_sd the slope of their logistic function, per dB."""


@dataclass(frozen=True)
class PowerTable:
    """What a design can show.

    Parameters
    ----------
    design : str
    assumed : Assumed
        With everything that was asked for in place of the typical.
    simulations, seed : int
    alpha : float
    rows : tuple of mapping
        ``participants``, ``trials``, and shares from 0 to 1: ``power`` and ``type_1`` of the confirmatory test,
        ``equivalence`` (how often it is shown where the truth is no difference), ``printed_power`` and
        ``printed_type_1`` of the publication's; of shares also ``exact_…`` of independent answers; of preferences
        ``all_equivalent``: that all pairs are shown to be.
    equivalence_from : mapping from int to int or None
        By trials, the participants of `TRIED` from which on `ENOUGH` of the studies show equivalence where the truth is
        no difference; None where even the most do not. Empty where it cannot be said.
    """

    design: str
    assumed: PowerAssumptions
    simulations: int
    seed: int
    alpha: float
    rows: tuple[Mapping[str, Any], ...]
    equivalence_from: Mapping[int, int | None]

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain values, for JSON."""
        return {
            "design": self.design,
            "assumed": {**vars(self.assumed)},
            "simulations": self.simulations,
            "seed": self.seed,
            "alpha": self.alpha,
            "simulated": True,
            "rows": [dict(row) for row in self.rows],
            "equivalence_from": {str(trials): people for trials, people in self.equivalence_from.items()},
        }


def power_table(
    design: str,
    *,
    participants: Sequence[int] = (),
    trials: Sequence[int] = (),
    effect: float | None = None,
    person_sd: float | None = None,
    trial_sd: float | None = None,
    margin: float | None = None,
    items: int | None = None,
    simulations: int = 2000,
    seed: int = 0,
    alpha: float = 0.05,
    progress: Callable[[str, int, int], None] = lambda task, done, total: None,
) -> PowerTable:
    """Return how often a study of each size shows what is there, and what is not.

    Parameters
    ----------
    design : str
        One of `DESIGNS`; what is not given is as assumed there.
    participants, trials : sequence of int
    effect, person_sd, trial_sd, margin : float, optional
    items : int, optional
        That are compared with each other; of ``pairwise`` only.
    simulations : int
        Studies of simulated participants per row; a share near .05 is then known to about ± 2 sqrt(.05 .95 / n).
    seed : int
    alpha : float
    progress : callable, optional
        Called with a task, and how many of its simulated participants, or sizes, are done of how many.

    Raises
    ------
    ParameterError
        If the design is none, or a number is not one that it can have.
    """
    if design not in DESIGNS:
        raise ParameterError(f"design must be one of {', '.join(DESIGNS)}, got {design!r}")
    assumed = _replaced(DESIGNS[design], participants, trials, effect, person_sd, trial_sd, margin, items)
    if simulations < 100 or not 0 < alpha < 0.5:
        raise ParameterError(f"simulations must be >= 100 and alpha < 0.5, got {simulations} and {alpha:g}")
    rng = np.random.default_rng(seed)
    rows: list[Mapping[str, Any]] = []
    whole, done = simulations * sum(assumed.participants) * len(assumed.trials), 0
    progress(TAKING, done, whole)
    for people in assumed.participants:
        for count in assumed.trials:
            shares = row_of(rng, people, count, assumed, simulations, alpha)
            rows.append({"participants": people, "trials": count, **shares})
            done += simulations * people
            progress(TAKING, done, whole)
    enough = _enough(assumed, alpha, seed, progress)
    return PowerTable(design, assumed, simulations, seed, alpha, tuple(rows), enough)


def _enough(
    assumed: PowerAssumptions, alpha: float, seed: int, progress: Callable[[str, int, int], None]
) -> dict[int, int | None]:
    """Return from how many participants on equivalence is shown often enough, by trials of each."""
    found: dict[int, int | None] = {}
    for trials in assumed.trials:
        progress(LOOKING, len(found), len(assumed.trials))
        rng = np.random.default_rng([seed, trials])
        low, high = 0, len(TRIED)
        while low < high:  # more people show more: halved until one is left
            middle = (low + high) // 2
            shown = equivalence_of(rng, TRIED[middle], trials, assumed, TRIED_SIMULATIONS, alpha)
            low, high = (low, middle) if shown >= ENOUGH else (middle + 1, high)
        found[trials] = TRIED[low] if low < len(TRIED) else None
    progress(LOOKING, len(found), len(assumed.trials))
    return found


def _replaced(
    typical: PowerAssumptions,
    participants: Sequence[int],
    trials: Sequence[int],
    effect: float | None,
    person_sd: float | None,
    trial_sd: float | None,
    margin: float | None,
    items: int | None,
) -> PowerAssumptions:
    given = {"effect": effect, "person_sd": person_sd, "trial_sd": trial_sd, "margin": margin, "items": items}
    values = {name: value for name, value in given.items() if value is not None}
    made = PowerAssumptions(
        **{
            **vars(typical),
            **values,
            "participants": tuple(participants) or typical.participants,
            "trials": tuple(trials) or typical.trials,
        }
    )
    if min(made.participants) < 2:
        raise ParameterError(f"participants must be 2 or more, got {min(made.participants)}")
    if max(made.participants) > MOST_PARTICIPANTS:
        raise ParameterError(
            f"participants must be {MOST_PARTICIPANTS} or fewer, got {max(made.participants)}"
        )
    if not 1 <= min(made.trials) <= max(made.trials) <= MOST_TRIALS:
        raise ParameterError(f"trials must be from 1 to {MOST_TRIALS}, got {min(made.trials)}")
    if (made.kind == "strengths") != (2 <= made.items <= 100):
        raise ParameterError(f"items are those of pairwise comparisons, from 2 to 100, got {made.items}")
    for name in ("effect", "person_sd", "trial_sd", "margin"):
        if not math.isfinite(getattr(made, name)):
            raise ParameterError(f"{name} must be finite, got {getattr(made, name)}")
    if made.person_sd < 0 or made.trial_sd < 0 or not made.margin > 0:
        raise ParameterError(
            "person_sd and trial_sd must be >= 0 and margin > 0, "
            f"got {made.person_sd:g}, {made.trial_sd:g}, {made.margin:g}"
        )
    if made.kind in ("share", "votes") and not (0 < made.effect < 1 and made.margin < 0.5):
        raise ParameterError(
            f"effect must be a share between 0 and 1 and margin below 0.5, got {made.effect:g} and {made.margin:g}"
        )
    if made.kind not in ("share", "votes", "strengths") and made.trial_sd == 0:
        raise ParameterError("trial_sd must be > 0, got 0")
    return made

"""Assumptions of a power table: the effect, the spread of people and answers, and the sizes of the studies."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PowerAssumptions:
    """Assumptions of a power table where nothing else is given: typical sizes, to be replaced by those of a pilot.

    Parameters
    ----------
    kind : str
        How its studies are simulated: the name of one of `tactogram.study.power.methods.METHODS`, or of a method of the
        design's own.
    effect : float
        The truth that power is of.
    effect_text : str
        What it is, with its unit.
    person_sd, trial_sd : float
        Spread of people's own effects, and of a single answer.
    margin : float
        A margin for equivalence; for the table only, a study gives its own.
    participants, trials : tuple of int
    trials_text : str
        What a trial is.
    test, printed : str
        The confirmatory test, and that of the publication ("" where there is none).
    level_sd : float
        Spread of people's levels, whatever the condition; matters to the publication's test only.
    items : int
        How many are compared with each other; 0 where none are.
    """

    kind: str
    effect: float
    effect_text: str
    person_sd: float
    trial_sd: float
    margin: float
    participants: tuple[int, ...]
    trials: tuple[int, ...]
    trials_text: str
    test: str
    printed: str = ""
    level_sd: float = 0.0
    items: int = 0


GEE, EXACT = "GEE by participant", "exact binomial of all answers"
"""Names of tests that several designs share."""

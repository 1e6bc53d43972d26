"""Assumptions of a power table: the effect, the spread of people and answers, and the sizes of the studies."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PowerAssumptions:
    """Default assumptions of a power table: typical sizes, to be replaced by those of a pilot.

    Parameters
    ----------
    kind : str
        Name of one of `tactogram_study.power.methods.METHODS`, or of the design's own ``simulation``.
    effect : float
        True effect, described with its unit by ``effect_text``.
    person_sd, trial_sd : float
        Spread of effects between people, and of single answers.
    margin : float
        Margin of equivalence of the table; a study has its own.
    trials_text : str
        Description of a trial.
    test : str
        Confirmatory test.
    items : int
        Number of items compared with each other, or 0.
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
    items: int = 0


GEE = "GEE by participant"

"""Transformed up-down staircases with two alternatives.

H. Levitt, "Transformed up-down methods in psychoacoustics", J. Acoust. Soc. Am. 49, 467-477 (1971): with 1 up and n
down the intensity settles where p**n = 1/2: 70.7 % correct for 2 down, 79.4 % for 3 down.

Answers to the question ``which``: ``condition`` is the staircase; ``side`` and ``answer`` are A or B; ``value`` is the
intensity in dB above the level, ``correct`` the outcome; the extra column ``reversals`` counts those before the trial.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tactogram.errors import ParameterError
from tactogram_study.designs.design import Design, MarginScale, ab_question, check_standard
from tactogram_study.planned import PowerAssumptions
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import DesignContext, History, Page, Participant, Slot, generator
from tactogram_study.wording import Wording, text_field

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tactogram_study.analysis.findings import AnalysisSection
    from tactogram_study.answers import Answers
    from tactogram_study.simulated_observer import SimulatedObserver

ANALYSIS = "tactogram_study.designs.analysis.staircase"
BELOW_START_DB = 20.0
"""Middle of the function of a typical observer, below the start."""
SLOTS: tuple[Slot, Slot] = ("A", "B")


@dataclass(frozen=True)
class StaircaseTrack:
    """State of one staircase: the intensity of its next trial, and those of its reversals, dB.

    ``run`` counts correct (> 0) or wrong (< 0) answers since the intensity changed; ``heading`` is 1 upwards, -1
    downwards, 0 before the first change.
    """

    intensity: float
    trials: int = 0
    reversals: tuple[float, ...] = ()
    run: int = 0
    heading: int = 0


class Staircase(Design):
    """Settings of 2AFC staircases: one for each target, mixed at random."""

    title: ClassVar[str] = "Staircases"
    question_text: ClassVar[str] = "How weak may it be and still be felt?"
    has_right_answers: ClassVar[bool] = True
    margins: ClassVar[Mapping[str, MarginScale]] = {"staircase": MarginScale("dB")}
    analysis: ClassVar[str] = f"{ANALYSIS}:analyse_staircases"
    simulation: ClassVar[str] = f"{ANALYSIS}:Staircases"
    power: ClassVar[Mapping[str, PowerAssumptions]] = {
        "staircase": PowerAssumptions(
            "staircases", 3.0,
            "dB between two thresholds (trial_sd: slope of logistic functions, per dB)", 2.0, 0.5, 3.0,
            (6, 12), (40, 80), "trials of each staircase", "paired t of thresholds by reversals",
        )
    }  # fmt: skip
    """person_sd is the spread of people's differences."""
    columns: ClassVar[Mapping[str, str]] = {
        "value": "The intensity in dB",
        "staircase": "Which staircase",
        "reversals": "Reversals of the staircase before this trial",
    }
    key_columns: ClassVar[tuple[str, ...]] = ("staircase",)

    kind: Literal["staircase"] = "staircase"
    standard: str = Field(default="", title="Standard")
    """Name of the stimulus in the other interval; "" is silence, for detection thresholds."""
    start_db: float = Field(default=0.0, allow_inf_nan=False, title="First level, dB")
    """Intensity of the first trial, dB above the study's level."""
    steps_db: tuple[float, ...] = Field(default=(8.0, 4.0, 2.0), title="Steps, dB")
    """Step before the first reversal, before the second, …; the last one remains."""
    up: int = Field(default=1, ge=1, le=10, title="Wrong answers before the level rises")
    """Wrong answers in a row after which the intensity rises."""
    down: int = Field(default=3, ge=1, le=10, title="Right answers before the level falls")
    """Correct answers in a row after which it falls."""
    reversals: int = Field(default=8, ge=2, le=100, title="Reversals before a staircase ends")
    """Number of reversals after which a staircase ends."""
    most_trials: int = Field(default=80, ge=1, le=10_000, title="Most trials of a staircase")
    """Number of trials after which it ends in any case."""
    lowest_db: float = Field(default=-80.0, allow_inf_nan=False, title="Lowest level, dB")
    highest_db: float = Field(default=20.0, allow_inf_nan=False, title="Highest level, dB")
    """Limits of the intensity."""
    instructions: Wording = text_field("staircase_instructions")
    which: Wording = text_field("staircase_which", "Question")

    @model_validator(mode="after")
    def _in_range(self) -> Self:
        if not self.lowest_db <= self.start_db <= self.highest_db or self.lowest_db == self.highest_db:
            raise ValueError(
                "a staircase needs lowest_db <= start_db <= highest_db and lowest_db < highest_db"
            )
        if not self.steps_db or not all(0 < step < 1000 for step in self.steps_db):
            raise ValueError("steps_db needs at least one step, each > 0 dB")
        return self

    def check(self, setting: DesignContext) -> None:
        """Raise `ParameterError` for an unknown standard, and for targets without a signal."""
        check_standard(self.standard, setting)
        for target in self._targets(setting):
            if not target.is_played:
                raise ParameterError(
                    f"a staircase changes a level, and nothing is played for {target.name!r}"
                )
        if not self._targets(setting):
            raise ParameterError("a staircase needs a stimulus besides its standard, got none")

    def total(self, setting: DesignContext) -> int:
        """Return the trials after which all have ended in any case."""
        return self.most_trials * len(self._targets(setting))

    def next_page(self, setting: DesignContext, participant: Participant, history: History) -> Page | None:
        targets = self._targets(setting)
        tracks = {target.name: self.start() for target in targets}
        # All at once: the draws of a trial depend on its number alone.
        draws = generator(setting.seed, participant.number, "staircase").random((self.total(setting), 2))
        active = [target for target in targets if not self.ended(tracks[target.name])]
        for answered, draw in zip(history, draws, strict=False):
            target, side = _drawn(active, draw)
            track = self.after(tracks[target.name], correct=answered.responses["which"] == side)
            tracks[target.name] = track
            if self.ended(track):
                active = [other for other in active if other is not target]
        if not active:
            return None
        target, side = _drawn(active, draws[len(history)])
        return self._page(setting, target, side, tracks[target.name], len(history) + 1)

    @classmethod
    def figures(cls, section: AnalysisSection, answers: Answers) -> dict[str, Figure]:
        return {"staircase": resolve_name(f"{ANALYSIS}:staircase_figure")(section, answers)}

    def power_options(self, setting: DesignContext) -> dict[str, Any]:
        """Return the median number of trials of a study's staircase over 200 simulated observers.

        Their logistic function has a slope of 0.5 per dB, and its middle at `BELOW_START_DB`.
        """
        rng = np.random.default_rng(0)
        middle, trials = self.start_db - BELOW_START_DB, []
        for _ in range(200):
            track = self.start()
            while not self.ended(track):
                right = rng.random() < 0.5 + 0.5 / (1 + math.exp(-0.5 * (track.intensity - middle)))
                track = self.after(track, correct=bool(right))
            trials.append(track.trials)
        return {"trials": (int(np.median(trials)),)}

    @classmethod
    def simulated_share(cls, page: Page, participant: SimulatedObserver) -> float:
        """Return the share correct at the intensity of a trial: a cumulative normal above guessing, with lapses."""
        from scipy.special import ndtr

        question = page.questions[0]
        above = question.values["A"] - participant.threshold_db - participant.shift(question)
        return float(0.5 + (0.5 - participant.effect.lapse) * ndtr(above / participant.effect.spread_db))

    def start(self) -> StaircaseTrack:
        """Return the track before its first trial."""
        return StaircaseTrack(self.start_db)

    def ended(self, track: StaircaseTrack) -> bool:
        """Return whether a track is complete."""
        return len(track.reversals) >= self.reversals or track.trials >= self.most_trials

    def after(self, track: StaircaseTrack, *, correct: bool) -> StaircaseTrack:
        """Return the track after one more answer."""
        run = max(track.run, 0) + 1 if correct else min(track.run, 0) - 1
        heading = -1 if run >= self.down else 1 if -run >= self.up else 0
        if heading == 0:
            return StaircaseTrack(track.intensity, track.trials + 1, track.reversals, run, track.heading)
        reversals = track.reversals
        if track.heading and heading != track.heading:
            reversals = (*reversals, track.intensity)
        step = self.steps_db[min(len(reversals), len(self.steps_db) - 1)]
        intensity = min(max(track.intensity + heading * step, self.lowest_db), self.highest_db)
        return StaircaseTrack(intensity, track.trials + 1, reversals, 0, heading)

    def _targets(self, setting: DesignContext) -> list[Stimulus]:
        return [stimulus for stimulus in setting.stimuli if stimulus.name != self.standard]

    def _page(
        self, setting: DesignContext, target: Stimulus, side: Slot, track: StaircaseTrack, trial: int
    ) -> Page:
        standard = setting.stimulus(self.standard)
        question = replace(
            ab_question("which", self.which, target, standard, side),
            condition=target.condition or target.name,
            values=dict.fromkeys("AB", track.intensity),
        )
        slots = {slot: target if slot == side else standard for slot in SLOTS}
        return self.trial_page(
            trial,
            [question],
            slots,
            gains_db={side: track.intensity},
            repeat=track.trials + 1,
            total=self.total(setting),
            more={"staircase": target.name, "reversals": str(len(track.reversals))},
            layout={"presentation": "intervals", "at_most": True},
        )


def _drawn(active: Sequence[Stimulus], draw: np.ndarray) -> tuple[Stimulus, Slot]:
    """Return the target of a trial, of the staircases that have not ended, and its slot."""
    which, side = draw
    return active[int(which * len(active))], "A" if side < 0.5 else "B"

"""Session plan: materials x contactors x speeds x repetitions, in an order drawn from a seed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator

from tactogram.capture.session import plans as _plans
from tactogram.errors import ParameterError
from tactogram.text_files import read_toml
from tactogram.validation import validated, with_changes

Name = Annotated[str, Field(min_length=1)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class TakeLimits(BaseModel):
    """Limits of a good take. A take that breaks one is marked, and can still be accepted."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    shortest: float = Field(default=0.98, ge=0, le=1)
    """Share of the planned seconds that must have come, lost samples included."""
    most_lost: float = Field(default=0.05, ge=0, le=1)
    """Share of samples that may be lost."""
    longest_gap_s: float = Field(default=0.25, ge=0, allow_inf_nan=False)
    """Longest loss in one piece, s."""
    most_clipped: float = Field(default=0.0, ge=0, le=1)
    """Share of samples that may be at full scale."""
    full_scale: Positive | None = None
    """Where the sensor clips, in the source's unit (16 g are 156.9 m/s^2). None takes what the source says, and where
    it says nothing looks for samples that stay at the take's own extreme."""
    least_rms: float | None = Field(default=None, ge=0, allow_inf_nan=False)
    """Level below which nothing was stroked, in the source's unit: rms about the mean, root of the sum over axes. None
    takes 0.12 for m/s^2, which is half as much again as an ADXL345 shows at rest at 330 Hz (0.08: 290 and 430 ug per
    root Hz, its data sheet), and nothing for other units."""
    rate_off: float = Field(default=0.05, ge=0, le=1)
    """By how much the measured rate may differ from the source's nominal one, as a share."""


class SessionPlan(BaseModel):
    """Session plan from a TOML file. Unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    title: str = ""
    """What it is, in a line."""
    materials: tuple[Name, ...] = Field(min_length=1)
    """What is touched. The names become the classes of a classifier."""
    contactors: tuple[Name, ...] = ("finger",)
    """What touches it."""
    speeds_mm_s: tuple[Positive, ...] = (100.0,)
    """Nominal stroking speeds."""
    repetitions: int = Field(default=1, ge=1)
    """Takes of each combination."""
    seconds: Positive = 10.0
    """Length of a take."""
    order: Literal["random", "by-repetition", "as-listed"] = "random"
    """``random``: all takes in one drawn order; ``by-repetition``: every combination once, in a drawn order, then all
    again in another; ``as-listed``: material by material."""
    seed: int = Field(default=0, ge=0)
    """Draws the order."""
    countdown_s: float = Field(default=3.0, ge=0, le=60)
    """Between saying yes and the first sample of a take."""
    stroke_mm: Positive = 80.0
    """Length of one stroke; with the speed it gives the metronome's beat. 80 mm fits the plates of Saga et al., which
    are "70-100 mm length" (Fig. 4)."""
    back_and_forth: bool = True
    """Whether a beat is a turn (two tones), or the start of the next stroke in the same direction (one)."""
    metronome: bool = True
    force_n: Positive | None = None
    """Normal force that is aimed at; shown with each prompt and written into each recording."""
    direction_deg: float | None = Field(default=None, allow_inf_nan=False)
    """Direction of the stroke in the surface."""
    session: str = ""
    """What this session is called; recordings of one session can be kept on one side of a split."""
    subject: str = ""
    """A code for who strokes. Not a name: it goes into the store."""
    rate: Positive | None = None
    """What the device's rate should be, Hz, where the device does not say (330 for Saga et al.'s). A take whose
    measured rate is within 0.1 % of it is written with it, so that all takes have one rate; any other with the
    measured one."""
    stream: str = ""
    """Name of the recorded stream; by default ``acceleration`` for m/s^2, ``force`` for N, else ``signal``."""
    licence: str = "not stated"
    """Of a store that is made."""
    notes: str = ""
    """Written into each recording."""
    limits: TakeLimits = TakeLimits()

    @field_validator("materials", "contactors", "speeds_mm_s", mode="before")
    @classmethod
    def _listed(cls, values: Any) -> Any:
        """Take one value, or names separated by commas, as a command line has them."""
        if isinstance(values, str):
            return [part.strip() for part in values.split(",") if part.strip()]
        return [values] if isinstance(values, int | float) else values

    @field_validator("materials", "contactors", "speeds_mm_s")
    @classmethod
    def _different(cls, values: tuple[Any, ...]) -> tuple[Any, ...]:
        if len(set(values)) != len(values):
            raise ValueError("values must differ")
        return values

    @classmethod
    def load(cls, plan: Path | str, *, changes: Mapping[str, Any] | None = None) -> Self:
        """Read a TOML file, or one of `shipped_plans` by name; ``changes`` are values by (dotted) key.

        Raises
        ------
        DataError
            If the file is not TOML.
        ParameterError
            If there is no such file, or a key or value is not one of a plan.
        """
        path = shipped_plans().get(str(plan), Path(plan))
        if not path.exists():
            names = ", ".join(shipped_plans())
            raise ParameterError(f"{plan}: no such session plan; shipped ones are {names}")
        return cls.of(with_changes(read_toml(path), changes), where=str(path))

    @classmethod
    def of(cls, values: Mapping[str, Any], *, where: str = "session plan") -> Self:
        """Return the plan that ``values`` describe."""
        return validated(cls, values, where=where)

    @property
    def sha256(self) -> str:
        """Follows from everything that decides what is recorded; limits and notes may change within a session."""
        values = self.model_dump(mode="json", exclude={"title", "limits", "notes", "licence", "metronome"})
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()

    @property
    def combinations(self) -> int:
        """How many different takes there are, repetitions aside."""
        return len(self.materials) * len(self.contactors) * len(self.speeds_mm_s)

    def trials(self) -> tuple[PlannedTake, ...]:
        """Return every take in its order; the same plan gives the same order."""
        listed = [
            (*combination, repetition)
            for combination in product(self.materials, self.contactors, self.speeds_mm_s)
            for repetition in range(1, self.repetitions + 1)
        ]
        if self.order != "as-listed":
            rng = np.random.default_rng(self.seed)
            listed = [listed[i] for i in rng.permutation(len(listed))]
        if self.order == "by-repetition":
            listed.sort(key=lambda entry: entry[3])
        return tuple(PlannedTake(number, *entry) for number, entry in enumerate(listed, 1))


@dataclass(frozen=True)
class PlannedTake:
    """One take that is to be made.

    Parameters
    ----------
    number : int
        Its place in the order, from 1.
    repetition : int
        From 1.
    """

    number: int
    material: str
    contactor: str
    speed_mm_s: float
    repetition: int

    def __str__(self) -> str:
        """Return what is to be done, in a line."""
        return f"{self.material}, {self.contactor}, {self.speed_mm_s:g} mm/s, repetition {self.repetition}"


def shipped_plans() -> dict[str, Path]:
    """Return the plans that come with the package, by name."""
    [folder] = map(Path, _plans.__path__)
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}

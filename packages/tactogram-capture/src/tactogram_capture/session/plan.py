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
from pydantic import Field, field_validator

from tactogram.errors import ParameterError
from tactogram.text_files import read_toml
from tactogram.validation import FrozenModel, validated, with_changes

Name = Annotated[str, Field(min_length=1)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class TakeLimits(FrozenModel):
    """Limits of a good take. A take beyond one is marked, and can still be accepted."""

    shortest: float = Field(default=0.98, ge=0, le=1)
    """Least share of the planned length, lost samples included."""
    most_lost: float = Field(default=0.05, ge=0, le=1)
    """Share of samples that may be lost."""
    longest_gap_s: float = Field(default=0.25, ge=0, allow_inf_nan=False)
    """Longest loss in one piece, s."""
    most_clipped: float = Field(default=0.0, ge=0, le=1)
    """Share of samples that may be at full scale."""
    full_scale: Positive | None = None
    """Where the sensor clips, in the source's unit (16 g are 156.9 m/s^2). By default the source's; if that is unknown,
    clipping is detected by samples that stay at the take's extreme."""
    least_rms: float | None = Field(default=None, ge=0, allow_inf_nan=False)
    """Level below which nothing was stroked, in the source's unit: rms about the mean, root of the sum over axes. By
    default 0.12 for m/s^2, which is 1.5 times the noise of an ADXL345 at rest at 330 Hz (0.08: 290 and 430 ug per
    root Hz, its data sheet), and no limit for other units."""
    rate_off: float = Field(default=0.05, ge=0, le=1)
    """Largest relative difference between the measured rate and the source's nominal one."""


class SessionPlan(FrozenModel):
    """Session plan from a TOML file. Unknown keys are errors."""

    title: str = ""
    """A line."""
    materials: tuple[Name, ...] = Field(min_length=1)
    """Touched materials. Their names become the classes of a classifier."""
    contactors: tuple[Name, ...] = ("finger",)
    """Touching parts, e.g. finger or pen."""
    speeds_mm_s: tuple[Positive, ...] = (100.0,)
    """Nominal stroking speeds."""
    repetitions: int = Field(default=1, ge=1)
    """Takes of each combination."""
    seconds: Positive = 10.0
    """Length of a take."""
    order: Literal["random", "by-repetition", "as-listed"] = "random"
    """``random``: all takes in one random order; ``by-repetition``: every combination once, in random order, then all
    again in another; ``as-listed``: material by material."""
    seed: int = Field(default=0, ge=0)
    """Draws the order."""
    countdown_s: float = Field(default=3.0, ge=0, le=60)
    """Time from the experimenter's start to the first sample of a take."""
    stroke_mm: Positive = 80.0
    """Length of one stroke; with the speed it gives the metronome's beat. 80 mm fits the plates of Saga et al., which
    are "70-100 mm length" (Fig. 4)."""
    back_and_forth: bool = True
    """Whether a beat is a turn (two tones), or the start of the next stroke in the same direction (one)."""
    metronome: bool = True
    force_n: Positive | None = None
    """Intended normal force; shown with each prompt and written to each recording."""
    direction_deg: float | None = Field(default=None, allow_inf_nan=False)
    """Direction of the stroke in the surface."""
    session: str = ""
    """Name of the session; a split can keep the recordings of one session together."""
    subject: str = ""
    """Code of the person who strokes. Not a name: it is stored."""
    rate: Positive | None = None
    """Nominal rate, Hz, of a device that does not report one (330 for Saga et al.'s). Takes with a
    measured rate within 0.1 % of it are written with it, so that they share one rate; others with the
    measured one."""
    stream: str = ""
    """Name of the recorded stream; by default ``acceleration`` for m/s^2, ``force`` for N, else ``signal``."""
    licence: str = "not stated"
    """Of a new store."""
    notes: str = ""
    """Written to each recording."""
    limits: TakeLimits = TakeLimits()

    @field_validator("materials", "contactors", "speeds_mm_s", mode="before")
    @classmethod
    def _listed(cls, values: Any) -> Any:
        """Accept one value, or names separated by commas, as on a command line."""
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

        Raises `DataError` if the file is not TOML; `ParameterError` if there is no such file, or a key or value is
        wrong.
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
        """Hash of all settings that affect recordings; limits and notes may change within a session."""
        values = self.model_dump(mode="json", exclude={"title", "limits", "notes", "licence", "metronome"})
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()

    @property
    def combinations(self) -> int:
        """Number of different takes, without repetitions."""
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
    """One planned take; ``number`` in the session's order and ``repetition`` count from 1."""

    number: int
    material: str
    contactor: str
    speed_mm_s: float
    repetition: int

    def __str__(self) -> str:
        """Return the instruction in a line."""
        return f"{self.material}, {self.contactor}, {self.speed_mm_s:g} mm/s, repetition {self.repetition}"


def shipped_plans() -> dict[str, Path]:
    """Return the plans that come with the package, by name."""
    return {path.stem: path for path in sorted(Path(__file__).with_name("plans").glob("*.toml"))}

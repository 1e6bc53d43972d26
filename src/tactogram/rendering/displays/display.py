"""Display: the facts of a TOML file that decide how a signal becomes its drive.

A *drive* is what is sent to a display: volts, parts of full scale, newtons of a string, register values. What comes out
of the display, on the skin, is its *output*; a `Response` leads from one to the other where it was measured. How a
signal becomes a drive is the `DisplayFamily`'s.
"""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, SerializeAsAny, field_validator, model_validator

from tactogram.errors import ParameterError
from tactogram.rendering.displays.response import ResponseSource
from tactogram.signal.signal import UNITS

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Display(BaseModel):
    """A display: everything that is the same for all families, and the family's own ``settings``."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str = Field(pattern=r"^[a-z0-9][a-z0-9-]*$")
    """As it is called on the command line."""
    title: str
    """What it is, in one line."""
    family: str
    """Name of its `DisplayFamily`."""
    source: str = ""
    """Where the numbers come from; says which were assumed."""
    rate: Positive
    """Samples of the drive per second and channel, Hz."""
    channels: tuple[str, ...] = Field(min_length=1)
    """Names of the channels of the drive."""
    unit: str
    """Of the drive, one of the units of a Signal: V, N, or 1 for parts of full scale and register values."""
    limit: Positive
    """No sample of a drive is above it, in ``unit``; by default none is below its negative either."""
    lowest: float | None = Field(default=None, allow_inf_nan=False)
    """No sample of a drive is below it, in ``unit``; None is ``-limit``."""
    rest: float = Field(default=0.0, allow_inf_nan=False)
    """The drive at rest, in ``unit``: where fades begin and end, and what is sent after an error."""
    band: tuple[float, float] | None = None
    """What it can render, Hz: of its output, not of a carrier. None is all that its rate holds."""
    dc: bool = False
    """Whether a constant drive is allowed; where not, the mean over the whole drive is 0."""
    fade_ms: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Length of the fade in and of the fade out, ms."""
    latency_ms: float | None = Field(default=None, ge=0, allow_inf_nan=False)
    """From the drive to the skin, ms; None is not known."""
    axes: str = "dft321"
    """How several axes of a signal become its drive unless asked otherwise, see `tactogram.rendering.drive.axes`."""
    response: ResponseSource | None = None
    """Its output over its drive; None was not measured, and then no physical level can be matched."""
    settings: SerializeAsAny[BaseModel]
    """The family's own: the table of the family's name in the file."""

    @property
    def floor(self) -> float:
        """The lowest drive allowed, in ``unit``."""
        return -self.limit if self.lowest is None else self.lowest

    @property
    def output_unit(self) -> str:
        """The unit of what comes out, as far as it is known: the response's, else the drive's."""
        return self.response.unit if self.response is not None else self.unit

    def of(self, **changes: Any) -> Self:
        """Return the same display with other values, checked again."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        return type(self).model_validate(values | changes)

    def check_volts(self, peak_v: float, *, lower: str) -> None:
        """Refuse more than one channel, another unit than V, or a limit below the ``peak_v`` that the settings allow.

        Parameters
        ----------
        peak_v : float, V
        lower : str
            The setting that must be lowered then.

        Raises
        ------
        ParameterError
            Which of the three.
        """
        if len(self.channels) != 1 or self.unit != "V":
            raise ParameterError(
                f"{self.name}: a display of the family {self.family} has one channel in V, got {self.channels} in "
                f"{self.unit}"
            )
        if peak_v > self.limit * (1 + 1e-9):
            raise ParameterError(
                f"{self.name}: its limit of {self.limit:g} V is below the {peak_v:g} V that its settings allow; lower "
                f"{lower}"
            )

    @field_validator("unit")
    @classmethod
    def _unit_is_known(cls, unit: str) -> str:
        if unit not in UNITS:
            raise ValueError(f"must be one of {', '.join(UNITS)}")
        return unit

    @field_validator("channels")
    @classmethod
    def _channels_differ(cls, channels: tuple[str, ...]) -> tuple[str, ...]:
        if len(set(channels)) < len(channels):
            raise ValueError("must be different names")
        return channels

    @field_validator("band")
    @classmethod
    def _band_is_a_band(cls, band: tuple[float, float] | None) -> tuple[float, float] | None:
        if band is not None and not 0 <= band[0] < band[1]:
            raise ValueError("must be low < high in Hz")
        return band

    @model_validator(mode="after")
    def _limits_hold_the_rest(self) -> Self:
        if not self.floor <= self.rest <= self.limit:
            raise ValueError(f"rest must lie within {self.floor:g} to {self.limit:g} {self.unit}")
        if not self.dc and self.rest != 0:
            raise ValueError("rest must be 0 where dc is forbidden")
        if not self.dc and self.floor >= 0:
            raise ValueError("lowest must be below 0 where dc is forbidden: a mean of 0 needs both signs")
        return self

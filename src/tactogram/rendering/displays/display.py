"""Display: the content of its TOML file, which determines how a signal becomes its drive.

A *drive* is what is sent to a display: volts, parts of full scale, newtons of a string, register values. Its *output*
is what reaches the skin; a measured `Response` relates the two. The `DisplayFamily` computes the drive.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field, SerializeAsAny, field_validator, model_validator

from tactogram.errors import ParameterError
from tactogram.rendering.displays.response import Positive, ResponseSource, SignalUnit
from tactogram.validation import FrozenModel

S = TypeVar("S", bound=BaseModel)


class Display(FrozenModel):
    """A display: the values common to all families, and the family's own ``settings``."""

    name: str = Field(pattern=r"^[a-z0-9][a-z0-9-]*$")
    """Its name on the command line."""
    title: str
    """Description in one line."""
    family: str
    """Name of its `DisplayFamily`."""
    source: str = ""
    """Origin of the numbers, including which were assumed."""
    rate: Positive
    """Samples of the drive per second and channel, Hz."""
    channels: tuple[str, ...] = Field(min_length=1)
    """Names of the channels of the drive."""
    card_channels: tuple[Annotated[int, Field(ge=1, le=64)], ...] | None = None
    """Channels of a sound card, counted from 1, that ``channels`` are played on; None is the first ones."""
    unit: SignalUnit
    """Unit of the drive, one of a Signal's: V, N, or 1 for parts of full scale and register values."""
    limit: Positive
    """Largest value of a drive, in ``unit``; by default its negative is the smallest."""
    lowest: float | None = Field(default=None, allow_inf_nan=False)
    """Smallest value of a drive, in ``unit``; None is ``-limit``."""
    rest: float = Field(default=0.0, allow_inf_nan=False)
    """The drive at rest, in ``unit``: fades begin and end here, and it is sent after an error."""
    band: tuple[float, float] | None = None
    """Band of its output (not of a carrier), Hz; None is everything its rate allows."""
    dc: bool = False
    """Whether a constant drive is allowed; if not, the mean over the whole drive is 0."""
    fade_ms: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Length of the fade in and of the fade out, ms."""
    latency_ms: float | None = Field(default=None, ge=0, allow_inf_nan=False)
    """From the drive to the skin, ms; None is unknown."""
    shortest_ms: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    """Shortest time for which its motor can be switched on or off, ms; None is unknown."""
    axes: str = "dft321"
    """How several axes of a signal become its drive by default, see `tactogram.rendering.drive.axes`."""
    response: ResponseSource | None = None
    """Output per drive; None was not measured, so no physical level can be matched."""
    settings: SerializeAsAny[BaseModel]
    """The family's own, from the file's table of that name."""

    @property
    def floor(self) -> float:
        """Smallest value of a drive, in ``unit``."""
        return -self.limit if self.lowest is None else self.lowest

    @property
    def output_unit(self) -> str:
        """Unit of the output if its response is known, else of the drive."""
        return self.response.unit if self.response is not None else self.unit

    @property
    def shortest_steps(self) -> int:
        """`shortest_ms` in samples of the drive, rounded up; 1 if it is unknown."""
        return max(1, math.ceil((self.shortest_ms or 0.0) / 1e3 * self.rate - 1e-9))

    @property
    def card_width(self) -> int:
        """Number of channels with which a sound card is opened."""
        return max(self.card_channels or (len(self.channels),))

    def on_card(self, frames: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return a drive, shape (frames, channel), on the channels of a sound card, the others silent; C order."""
        if self.card_channels is None:
            return frames
        out = np.zeros((len(frames), self.card_width), np.float32)
        out[:, [channel - 1 for channel in self.card_channels]] = frames
        return out

    def of(self, **changes: Any) -> Self:
        """Return the display with other values, validated again."""
        values = {name: getattr(self, name) for name in type(self).model_fields}
        return type(self).model_validate(values | changes)

    def settings_as(self, kind: type[S]) -> S:
        """Return the settings of a ``kind``; `ParameterError` for a display of another family."""
        if not isinstance(self.settings, kind):
            raise ParameterError(
                f"{self.name}: the family {self.family} does not fit here; choose another display"
            )
        return self.settings

    def check_volts(self, peak_v: float, *, lower: str) -> None:
        """Refuse several channels, another unit than V, or a limit below the ``peak_v`` that the settings allow.

        ``lower`` is the setting to lower, for the error.

        Raises
        ------
        ParameterError
            Which of the three.
        """
        if len(self.channels) != 1 or self.unit != "V":
            raise ParameterError(
                f"{self.name}: a display of the family {self.family} must have one channel in V, got {self.channels} "
                f"in {self.unit}"
            )
        if peak_v > self.limit * (1 + 1e-9):
            raise ParameterError(
                f"{self.name}: its limit of {self.limit:g} V is below the {peak_v:g} V that its settings allow; lower "
                f"{lower}"
            )

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
    def _is_consistent(self) -> Self:
        if self.card_channels is not None and (
            len(set(self.card_channels)) < len(self.card_channels)
            or len(self.card_channels) != len(self.channels)
        ):
            raise ValueError(
                f"card_channels must be {len(self.channels)} different ones, one for each of channels"
            )
        if not self.floor <= self.rest <= self.limit:
            raise ValueError(f"rest must lie within {self.floor:g} to {self.limit:g} {self.unit}")
        if not self.dc and self.rest != 0:
            raise ValueError("rest must be 0 where dc is forbidden")
        if not self.dc and self.floor >= 0:
            raise ValueError("lowest must be below 0 where dc is forbidden: a mean of 0 needs both signs")
        return self

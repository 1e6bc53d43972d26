"""Rules of an HJIF document (ISO/IEC 23090-31), as the reference software checks them.

The standard's JSON schema is not public. Required members, ranges and vocabulary are from the reference software
(MPEGGroup/HapticReferenceSoftware, BSD).
"""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from tactogram.rendering.files.documents import DocumentPart

MOST_TICKS = 48_000

MODALITIES = (
    "Other",
    "Pressure",
    "Acceleration",
    "Velocity",
    "Position",
    "Temperature",
    "Vibrotactile",
    "Water",
    "Wind",
    "Force",
    "Vibrotactile Texture",
    "Stiffness",
    "Friction",
    "Electrotactile",
)

Whole = Annotated[int, Field(strict=False)]
"""A whole number, also as 20.0."""
Id = Annotated[int, Field(ge=0, strict=False)]


class Keyframe(DocumentPart):
    """Point of an effect, its position relative to the effect's, in ticks."""

    relative_position: Whole | None = Field(None, ge=0)
    amplitude_modulation: float | None = None
    frequency_modulation: Whole | None = Field(None, ge=0)


class Effect(DocumentPart):
    """Section of a band."""

    effect_type: Literal["Basis", "Reference", "Composite"] = "Basis"
    position: Whole = 0
    phase: float = 0.0
    base_signal: Literal["Sine", "Square", "Triangle", "SawToothUp", "SawToothDown"] = "Sine"
    keyframes: tuple[Keyframe, ...] = Field((), strict=False)


class Band(DocumentPart):
    """Component of a channel."""

    band_type: Literal["Transient", "Curve", "VectorialWave", "WaveletWave"]
    curve_type: Literal["Unknown", "Cubic", "Linear", "Akima", "Bezier", "Bspline"] = "Unknown"
    block_length: Whole | None = Field(None, gt=0)
    lower_frequency_limit: Whole = Field(ge=0)
    upper_frequency_limit: Whole = Field(ge=0)
    effects: tuple[Effect, ...] = Field(strict=False)

    @model_validator(mode="after")
    def _consistent(self) -> Band:
        if self.lower_frequency_limit > self.upper_frequency_limit:
            raise ValueError(
                f"lower_frequency_limit must not be above the upper, got {self.lower_frequency_limit} "
                f"and {self.upper_frequency_limit}"
            )
        if self.band_type == "WaveletWave" and self.block_length is None:
            raise ValueError("a WaveletWave band needs a block_length")
        if self.band_type in ("Curve", "VectorialWave", "Transient"):
            for effect in self.effects:
                places = [k.relative_position for k in effect.keyframes if k.relative_position is not None]
                if places != sorted(places):
                    raise ValueError("keyframes must be in order of relative_position")
        return self


class Channel(DocumentPart):
    """Signal of a perception."""

    id: Id
    description: str
    gain: float
    mixing_coefficient: float
    body_part_mask: Whole = Field(ge=0)
    bands: tuple[Band, ...] = Field(strict=False)
    frequency_sampling: Whole | None = Field(None, gt=0)
    sample_count: Whole | None = Field(None, ge=0)
    reference_device_id: Id | None = None


class Device(DocumentPart):
    """Device that a perception is made for."""

    id: Id
    name: str


class Perception(DocumentPart):
    """Signals of one modality."""

    id: Id
    avatar_id: Id
    description: str
    perception_modality: Literal[MODALITIES]  # type: ignore[valid-type]
    channels: tuple[Channel, ...] = Field(strict=False)
    effect_library: tuple[dict[str, Any], ...] = Field(strict=False)
    reference_devices: tuple[Device, ...] = Field((), strict=False)
    unit_exponent: int | None = None
    perception_unit_exponent: int | None = None

    @model_validator(mode="after")
    def _unique(self) -> Perception:
        _check_unique([channel.id for channel in self.channels], "channel")
        _check_unique([device.id for device in self.reference_devices], "reference device")
        known = {device.id for device in self.reference_devices}
        for channel in self.channels:
            if channel.reference_device_id is not None and channel.reference_device_id not in known:
                raise ValueError(f"reference_device_id {channel.reference_device_id} is no reference device")
        return self


class Avatar(DocumentPart):
    """A body."""

    id: Whole = Field(ge=1)
    """0 is reserved for an unspecified avatar."""


class Sync(DocumentPart):
    """Start position, in ticks."""

    timestamp: Whole = Field(ge=0)


class Haptics(DocumentPart):
    """A complete file."""

    version: str
    profile: Literal["Main", "Simple Parametric"]
    level: Literal[1, 2]
    date: str
    description: str
    timescale: Whole = Field(ge=1, le=MOST_TICKS)
    avatars: tuple[Avatar, ...] = Field(strict=False)
    perceptions: tuple[Perception, ...] = Field(strict=False)
    syncs: tuple[Sync, ...] = Field(strict=False)

    @model_validator(mode="after")
    def _consistent(self) -> Haptics:
        if not re.fullmatch(r"20\d\d(-\d)?", self.version) or int(self.version[:4]) < 2023:
            raise ValueError(
                f"version must be a year from 2023 on, such as 2023 or 2023-1, got {self.version!r}"
            )
        if self.profile == "Simple Parametric" and self.timescale != 1000:
            raise ValueError(f"timescale of Simple Parametric must be 1000, got {self.timescale}")
        _check_unique([avatar.id for avatar in self.avatars], "avatar")
        _check_unique([perception.id for perception in self.perceptions], "perception")
        for perception in self.perceptions:
            if perception.avatar_id and perception.avatar_id not in {avatar.id for avatar in self.avatars}:
                raise ValueError(
                    f"avatar_id {perception.avatar_id} of perception {perception.id} is no avatar"
                )
            self._check_level(perception)
        return self

    def _check_level(self, perception: Perception) -> None:
        """Check a level's limits; 127 channels at level 1 are those of the reference software's code."""
        most = 127 if self.level == 1 else 65_535
        if len(perception.channels) > most:
            raise ValueError(
                f"level {self.level} holds {most} channels at most, got {len(perception.channels)}"
            )
        for channel in perception.channels:
            if self.level == 1 and len(channel.bands) > 7:
                raise ValueError(f"level 1 holds 7 bands per channel at most, got {len(channel.bands)}")


def _check_unique(numbers: list[int], what: str) -> None:
    if len(set(numbers)) < len(numbers):
        raise ValueError(f"each {what} must have a unique id, got {numbers}")

"""What each family of displays makes of a block of a texture, causally.

What needs the whole of a signal, the level above all, was found on a rehearsal before (`output`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.response import EDGE_OCTAVES
from tactogram.rendering.drive.level_scaling import kinematic_power
from tactogram.rendering.drive.modulation import pre_emphasis
from tactogram.rendering.families import electrovibration, linear, ultrasonic
from tactogram.rendering.level import Level
from tactogram.rendering.streaming.electrovibration import ElectrovibrationStream
from tactogram.rendering.streaming.equaliser import Equaliser, EqualiserDesign, equaliser
from tactogram.rendering.streaming.finger_path import MotionBlock
from tactogram.rendering.streaming.surface import SurfaceTexture

Array = NDArray[np.float64]
Block = NDArray[np.float32]


class StreamDrive(Protocol):
    """What a family of displays makes of a block."""

    delay_s: float

    def process(self, block: Block, motion: MotionBlock | None) -> Array:
        """Return the drive of a block, float64, shape (channel, time), of ``block``, float32, (axis, time).

        ``motion`` is the finger over this block, None while nothing is known of it.
        """
        ...

    def facts(self) -> dict[str, Any]:
        """Return what it does, as JSON values."""
        ...


class LinearDrive:
    """A factor, and what makes up for the response; see `tactogram.rendering.families.linear`."""

    def __init__(self, display: Display, unit: str, found: Mapping[str, Any]) -> None:
        settings = display.settings
        if not isinstance(settings, linear.Settings):
            raise ParameterError(f"{display.name}: expected a linear display, got {display.family}")
        self._channels = len(display.channels)
        self._factor = float(found["factor"])
        self.equalises = display.response is not None and settings.equalise != "none"
        self._equaliser = Equaliser(_linear_design(display, settings, kinematic_power(unit, display)))
        self.delay_s = self.design.facts()["delay_ms"] / 1e3

    @property
    def design(self) -> EqualiserDesign:
        """The filter in use."""
        return self._equaliser.design

    def process(self, block: Block, motion: MotionBlock | None = None) -> Array:
        """Return the drive, one axis on every channel, or an axis per channel."""
        x = self._equaliser.process(block * self._factor)
        if len(x) == 1 < self._channels:
            return np.repeat(x, self._channels, axis=0)
        return np.asarray(x[: self._channels], np.float64)

    def facts(self) -> dict[str, Any]:
        """Return the factor and what the equaliser does."""
        return {"factor": self._factor, "equaliser": {"on": self.equalises, **self.design.facts()}}


class UltrasonicDrive:
    """The amplitude of a carrier, whose phase goes on from block to block; see `rendering.families.ultrasonic`."""

    def __init__(self, display: Display, unit: str, found: Mapping[str, Any]) -> None:
        settings = display.settings
        if not isinstance(settings, ultrasonic.Settings):
            raise ParameterError(f"{display.name}: expected an ultrasonic display, got {display.family}")
        if settings.mapping != "vibration":
            raise ParameterError(
                f"{display.name}: only the mapping vibration can be streamed so far, got {settings.mapping}"
            )
        self._settings = settings
        self._full_scale = float(found["full_scale"])
        self.equalises = settings.pre_emphasis
        self._equaliser = Equaliser(_envelope_design(display, settings))
        self.delay_s = self.design.facts()["delay_ms"] / 1e3
        self._turn = 2 * np.pi * settings.carrier_hz / display.rate
        self._sent = 0
        self.limited = 0

    @property
    def design(self) -> EqualiserDesign:
        """The filter in use."""
        return self._equaliser.design

    def process(self, block: Block, motion: MotionBlock | None = None) -> Array:
        """Return the drive, float64, shape (1, time)."""
        s = self._settings
        x = self._equaliser.process(np.asarray(block[:1], np.float64) / self._full_scale)
        self.limited += int(np.count_nonzero(np.abs(x) > 1))
        envelope = s.carrier_v * (1 + s.modulated_depth * np.clip(x, -1, 1))
        if s.output == "envelope":
            return np.asarray(envelope)
        # Reduced to one turn, since a float loses the phase of a carrier within hours.
        phase = (self._turn * (self._sent + np.arange(x.shape[1]))) % (2 * np.pi)
        self._sent += x.shape[1]
        return np.asarray(envelope * np.sin(phase))

    def facts(self) -> dict[str, Any]:
        """Return full scale, the carrier, how many samples were over-modulated, and what the equaliser does."""
        return {
            "full_scale": self._full_scale,
            "carrier_hz": self._settings.carrier_hz,
            "over_modulated_samples": self.limited,
            "equaliser": {"on": self.equalises, **self.design.facts()},
        }


class ElectrovibrationDrive:
    """A surface's friction as a voltage at the finger's place; see `ElectrovibrationStream`.

    It plays the surface itself and not the engine's blocks of it: hysteresis, slew and watchdog are its own, and
    transients of landings, which are no friction, are left out. Beyond the surface's ends it is mirrored.
    """

    delay_s = 0.0

    def __init__(self, display: Display, surface: SurfaceTexture, level: Level) -> None:
        settings = display.settings
        if not isinstance(settings, electrovibration.Settings):
            raise ParameterError(
                f"{display.name}: expected an electrovibration display, got {display.family}"
            )
        display.check_volts(settings.peak_v, lower="v_max")
        self._along = surface.along
        self._stream = ElectrovibrationStream(
            surface.signal,
            settings,
            rate=display.rate,
            level=level,
            highest_hz=display.band[1] if display.band else electrovibration.HIGHEST_HZ,
        )

    def process(self, block: Block, motion: MotionBlock | None = None) -> Array:
        """Return the voltage at the generator, float64, shape (1, time); ``block`` says only how long it is."""
        count = block.shape[1]
        if motion is None or motion.count != count:
            return np.asarray(self._stream.process(None, count)[None], np.float64)
        place = {"path": motion.path_mm, "x": motion.x_mm, "y": motion.y_mm}[self._along]
        touching = bool(motion.contact[:count].any())
        return np.asarray(self._stream.process(place[:count], count, contact=touching)[None], np.float64)

    def facts(self) -> dict[str, Any]:
        """Return what was scaled and clipped of the whole surface, and what cannot be reached."""
        return {"fitted": self._stream.facts}


def _linear_design(display: Display, settings: linear.Settings, motion: int) -> EqualiserDesign:
    """Return a filter with the magnitude of `tactogram.rendering.families.linear`: band, capped inverse, unit."""
    response, band = display.response, linear.reachable_band(display)
    # A file's cosine edges lie inside of the band; between them and its ends the two may differ.
    inner = (band[0] * 2**EDGE_OCTAVES, band[1] / 2**EDGE_OCTAVES)
    checked = inner if inner[0] < inner[1] else band
    if response is None or settings.equalise == "none":
        gain = 1.0 if response is None else 1 / abs(complex(response.at(settings.reference_hz)))
        return equaliser(display.rate, band, lambda f: gain * (2 * np.pi * f) ** motion, checked=checked)
    known = np.geomspace(max(band[0], 1.0), band[1], 2000)
    least = np.abs(response.at(known)).max() / 10 ** (settings.cap_db / 20)

    def wanted(frequency: Array) -> Array:
        size = np.maximum(np.abs(response.at(frequency)), least)
        return np.asarray((2 * np.pi * frequency) ** motion / size)

    return equaliser(display.rate, band, wanted, checked=checked)


def _envelope_design(display: Display, settings: ultrasonic.Settings) -> EqualiserDesign:
    """Return a filter with the magnitude of `tactogram.rendering.drive.modulation`: band, and capped pre-emphasis."""
    band = display.band or ultrasonic.BAND
    if not (settings.pre_emphasis and settings.q):
        return equaliser(display.rate, band, np.ones_like)
    cutoff, cap = settings.carrier_hz / (2 * settings.q), settings.cap_db
    return equaliser(display.rate, band, lambda f: np.abs(pre_emphasis(f, cutoff_hz=cutoff, cap_db=cap)))

"""From blocks of a texture to blocks of a display's drive, causally, with the display's own guard at the end.

`tactogram.rendering.fit` sees a whole signal; a stream has only the past. So a *rehearsal* (seconds of the same
textures under a simulated hand) is fitted first, with its level and its report, and what it found is kept: one factor,
and the equaliser's magnitude as a filter of least phase, which is causal and as quick as that magnitude allows.
An electrovibration display needs no rehearsal: the whole of its surface is known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import signal as dsp

from tactogram.errors import ParameterError
from tactogram.rendering import electrovibration, linear, ultrasonic
from tactogram.rendering.display import Display
from tactogram.rendering.electrovibration_stream import ElectrovibrationStream
from tactogram.rendering.fit import fit
from tactogram.rendering.level import Level
from tactogram.rendering.levelled import kinematic_power
from tactogram.rendering.modulation import StreamPreEmphasis
from tactogram.rendering.safety import Guard
from tactogram.rendering.streaming.following import MotionBlock
from tactogram.rendering.streaming.surface import SurfaceTexture
from tactogram.signal.signal import Signal

Array = NDArray[np.float64]
Block = NDArray[np.float32]

FILTER_S = 0.03
"""Length of an equaliser, s."""
REFERENCE_HZ = 250.0
"""Where the equaliser's delay is told, Hz."""
DEEPEST_DB = 80.0


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


class DisplayOutput:
    """The drive of a display, block by block; never NaN, never over a limit, at rest after an error.

    Parameters
    ----------
    display : Display
    rehearsed : Signal or SurfaceTexture
        Some seconds of what will be streamed, at the display's rate: its level decides the factor. For an
        electrovibration display the surface itself.
    level : Level

    Attributes
    ----------
    clipped : int
        Samples that were beyond the display's limits, of all channels.

    Raises
    ------
    ParameterError, UnitError
        If the display's family cannot be streamed to, or the level has no meaning for it.
    """

    def __init__(self, display: Display, rehearsed: Signal | SurfaceTexture, *, level: Level) -> None:
        makers: dict[str, Callable[[Display, str, Mapping[str, Any]], StreamDrive]] = {
            "linear": LinearDrive,
            "ultrasonic": UltrasonicDrive,
        }
        if display.family not in (*makers, "electrovibration"):
            raise ParameterError(
                f"{display.name}: a {display.family} display cannot be streamed to so far; "
                f"streaming is for {', '.join(makers)} and electrovibration displays: render a file for it instead"
            )
        self.display = display
        self.drive: StreamDrive
        if display.family == "electrovibration":
            if not isinstance(rehearsed, SurfaceTexture):
                raise ParameterError(
                    f"{display.name}: streams one surface, a friction coefficient over displacement; got "
                    "what is not a surface"
                )
            self.drive = ElectrovibrationDrive(display, rehearsed, level)
            self.rehearsal: dict[str, Any] | None = None
        else:
            if not isinstance(rehearsed, Signal):
                raise ParameterError(f"{display.name}: the level is found on a signal, got a surface")
            report = fit(rehearsed, display, level=level).report
            self.drive = makers[display.family](display, rehearsed.unit, report.facts)
            self.rehearsal = report.as_json()
        self.guard = Guard(display)
        self.clipped = 0

    def process(self, block: Block, motion: MotionBlock | None = None) -> Block:
        """Return the drive that may be sent, float32, shape (channel, time)."""
        drive = self.drive.process(block, motion)
        # By more than a float's rounding: what is made to reach the limit is not clipped by it.
        over = (drive > self.display.limit * (1 + 1e-6)) | (
            drive < self.display.floor - 1e-6 * self.display.limit
        )
        self.clipped += int(np.count_nonzero(over))
        return self.guard.process(drive)

    def missing(self, count: int) -> Block:
        """Return what is sent while there is nothing to send: a fade to rest, then rest."""
        if isinstance(self.drive, ElectrovibrationDrive):
            # Its carrier goes on while it fades: held at an instant it would be a direct voltage.
            with suppress(Exception):
                return self.guard.leaving(self.drive.process(np.zeros((1, count), np.float32), None))
        return self.guard.missing(count)

    def facts(self) -> dict[str, Any]:
        """Return what it does, as JSON values."""
        return {
            "display": self.display.name,
            "family": self.display.family,
            "unit": self.display.unit,
            "limit": self.display.limit,
            "rehearsal": self.rehearsal,
            "clipped_samples": self.clipped,
            **self.drive.facts(),
        }


class LinearDrive:
    """A gain and an equaliser of least phase; see `tactogram.rendering.linear`."""

    def __init__(self, display: Display, unit: str, found: Mapping[str, Any]) -> None:
        settings = display.settings
        if not isinstance(settings, linear.Settings):
            raise ParameterError(f"{display.name}: expected a linear display, got {display.family}")
        self._channels = len(display.channels)
        self._factor = float(found["factor"])
        self._taps = np.ones(1)
        if display.response is not None:
            self._taps = _equaliser(display, settings, kinematic_power(unit, display))
        self._state: Array | None = None
        response = dsp.freqz(self._taps, worN=[REFERENCE_HZ * 0.99, REFERENCE_HZ * 1.01], fs=display.rate)[1]
        turn = 2 * np.pi * 0.02 * REFERENCE_HZ
        self.delay_s = float(-np.angle(response[1] / response[0]) / turn)

    def process(self, block: Block, motion: MotionBlock | None = None) -> Array:
        """Return the drive, one axis on every channel, or an axis per channel."""
        x = block * self._factor
        if len(self._taps) > 1:
            if self._state is None:
                self._state = np.zeros((len(x), len(self._taps) - 1))
            x, self._state = dsp.lfilter(self._taps, 1.0, x, axis=1, zi=self._state)
        if len(x) == 1 < self._channels:
            return np.repeat(x, self._channels, axis=0)
        return np.asarray(x[: self._channels], np.float64)

    def facts(self) -> dict[str, Any]:
        """Return the factor and the equaliser's length and delay."""
        return {
            "factor": self._factor,
            "equaliser_taps": len(self._taps),
            "equaliser_delay_ms": 1e3 * self.delay_s,
            "reference_hz": REFERENCE_HZ,
        }


class UltrasonicDrive:
    """The amplitude of a carrier, whose phase goes on from block to block; see `tactogram.rendering.ultrasonic`.

    Pre-emphasis is causal here: flat but for a first-order low-pass, where `fit`'s is flat up to an edge.
    """

    delay_s = 0.0

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
        self._lead = (
            StreamPreEmphasis(
                display.rate, cutoff_hz=settings.carrier_hz / (2 * settings.q), cap_db=settings.cap_db
            )
            if settings.pre_emphasis and settings.q
            else None
        )
        self._turn = 2 * np.pi * settings.carrier_hz / display.rate
        self._sent = 0
        self.limited = 0

    def process(self, block: Block, motion: MotionBlock | None = None) -> Array:
        """Return the drive, float64, shape (1, time)."""
        s = self._settings
        x = np.asarray(block[:1], np.float64) / self._full_scale
        if self._lead is not None:
            x = self._lead.process(x)
        self.limited += int(np.count_nonzero(np.abs(x) > 1))
        envelope = s.carrier_v * (1 + s.modulated_depth * np.clip(x, -1, 1))
        if s.output == "envelope":
            return np.asarray(envelope)
        # Reduced to one turn, since a float loses the phase of a carrier within hours.
        phase = (self._turn * (self._sent + np.arange(x.shape[1]))) % (2 * np.pi)
        self._sent += x.shape[1]
        return np.asarray(envelope * np.sin(phase))

    def facts(self) -> dict[str, Any]:
        """Return full scale, the carrier and how many samples were over-modulated and clipped."""
        return {
            "full_scale": self._full_scale,
            "carrier_hz": self._settings.carrier_hz,
            "over_modulated_samples": self.limited,
            "minus_3_db_hz": None if self._lead is None else self._lead.minus_3_db_hz,
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
        if settings.peak_v > display.limit * (1 + 1e-9):
            raise ParameterError(
                f"{display.name}: its limit of {display.limit:g} V is below the {settings.peak_v:g} V that its "
                "settings allow; lower v_max"
            )
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


def _equaliser(display: Display, settings: linear.Settings, motion: int) -> Array:
    """Return the taps of the filter of least phase with the magnitude of the response's capped inverse."""
    response = display.response
    if response is None:
        return np.ones(1)
    if settings.equalise == "none":
        return np.array([1 / abs(complex(response.at(settings.reference_hz)))])
    size = 1 << 15
    frequency = np.fft.rfftfreq(size, 1 / display.rate)
    # Held outside of the band: a wall there would make the filter late inside.
    low, high = linear.reachable_band(display)
    inside = np.clip(frequency, max(low, frequency[1]), min(high, 0.49 * display.rate))
    size_of = np.abs(response.at(inside))
    most_effective = size_of[(frequency >= low) & (frequency <= high)].max()
    gain = 1 / np.maximum(size_of, most_effective / 10 ** (settings.cap_db / 20))
    gain = gain * (2 * np.pi * inside) ** motion
    return least_phase(gain, max(2, round(FILTER_S * display.rate)))


def least_phase(gain: Array, taps: int) -> Array:
    """Return a filter of ``taps`` taps with ``gain`` (over 0 to half the rate, even steps) and least phase.

    By the folded cepstrum (Oppenheim & Schafer, Discrete-Time Signal Processing, 3rd ed., Sec. 13.5.2); the end is
    faded out by a quarter of a cosine.
    """
    floor = gain.max() * 10 ** (-DEEPEST_DB / 20)
    cepstrum = np.fft.irfft(np.log(np.maximum(gain, floor)))
    half = len(cepstrum) // 2
    cepstrum[1:half] *= 2
    cepstrum[half + 1 :] = 0
    impulse: Array = np.fft.irfft(np.exp(np.fft.rfft(cepstrum)))[:taps]
    fade = taps // 4
    if fade:
        impulse[-fade:] *= np.cos(np.pi / 2 * np.arange(fade) / fade)
    return impulse

"""Linear displays (voice coils, audio actuators): the drive is the wanted output divided by the measured response."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy import fft

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import DisplayFamily, MotionBlock
from tactogram.rendering.displays.display import Display
from tactogram.rendering.displays.response import EDGE_OCTAVES, InverseResponse, edges, inverse
from tactogram.rendering.drive.equaliser import Equaliser, EqualiserDesign, equaliser
from tactogram.rendering.drive.level_scaling import MOTION, factor_of, kinematic_power, within_limits
from tactogram.rendering.drive.report import band_table, out_of_band_db
from tactogram.rendering.drive.safety import settled
from tactogram.rendering.level import Level
from tactogram.signal.perception import sensation_level_db
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal
from tactogram.validation import FrozenModel

PADDING_S = 0.25
"""Silence added on both sides for a ringing response, s."""


class Settings(FrozenModel):
    """Equalisation of a linear display's response, and treatment of its limit."""

    equalise: Literal["full", "magnitude", "none"] = "full"
    """``full`` inverts gain and phase, ``magnitude`` only the gain, ``none`` neither: the response then only predicts
    the output, and its gain at ``reference_hz`` applies to all frequencies."""
    cap_db: float = Field(default=20.0, ge=0, le=60)
    """Largest gain of a frequency relative to the most effective one, dB."""
    reference_hz: float = Field(default=250.0, gt=0)
    """Frequency of the response without equalisation, Hz: the most sensitive frequency of touch."""
    over: Literal["scale", "clip", "refuse"] = "scale"
    """If more than ``clip_share`` of the drive exceeds the limit: reduce all of it, clip, or refuse."""
    clip_share: float = Field(default=0.001, ge=0, lt=1)
    """Share of samples that may be clipped."""


def drive(
    signal: Signal, settings: Settings, *, display: Display, level: Level
) -> tuple[Signal, dict[str, Any]]:
    """Return the drive of a display that is linear up to its limit, see `DriveFunction`.

    Raises `UnitError` if a physical or sensation level does not apply to signal or display; `ParameterError` if there
    are fewer axes than channels (and not one), or too much exceeds the limit and ``over`` is ``refuse``.
    """
    scaled: list[str] = []
    clipped: list[str] = []
    unreachable: list[str] = []
    x, dropped = _per_channel(signal, display)
    if dropped:
        unreachable.append(f"axes {', '.join(dropped)}: the display has {len(display.channels)} channels")
    x = resample(x, display.rate)
    motion = kinematic_power(signal.unit, display)
    plan = _Plan(x, display, settings, motion)
    unit_drive = plan.unit_drive()
    faded = display.rest == 0
    if faded:
        # Before the level, so that the level is met even if the signal is loudest at its ends.
        unit_drive, _ = settled(unit_drive, display)
    factor, aim, words = factor_of(
        level,
        display=display,
        signal=x,
        output=plan.output(unit_drive, x),
        peak=float(np.abs(unit_drive).max()),
    )
    scaled.append(words)
    if motion:
        scaled.append(f"{signal.unit} converted to {display.output_unit}, frequency by frequency")
    samples, limiting = within_limits(
        unit_drive * factor,
        display.floor,
        display.limit,
        unit=display.unit,
        over=settings.over,
        clip_share=settings.clip_share,
        scaled=scaled,
        clipped=clipped,
    )
    output = plan.output(samples, x)
    aimed = x.with_samples(x.samples * np.float64(aim))
    lost_db = out_of_band_db(aimed, plan.band)
    unreachable += plan.unreachable(lost_db)
    facts: dict[str, Any] = {
        "faded": faded,
        "factor": factor * limiting,
        "limiting": limiting,
        "aim": aim,
        "band": list(plan.band),
        "equalised": settings.equalise if display.response is not None else "none",
        "cap_db": settings.cap_db,
        "capped_hz": list(plan.capped) if plan.capped else None,
        "out_of_band_db": lost_db,
        "bands": band_table(aimed, output, plan.band, below=signal.rate / 2),
    }
    if signal.unit in MOTION and display.output_unit in MOTION:
        facts["sensation_level_db"] = _levels(aimed, output)
    # One axis goes to every channel.
    copies = len(display.channels) if len(x.axes) == 1 else 1
    result = x.with_samples(np.repeat(samples, copies, axis=0), unit=display.unit, axes=display.channels)
    return result, facts | {"scaled": scaled, "clipped": clipped, "unreachable": unreachable}


class _Plan:
    """Conversion of a wanted output to the drive and, through the response, back to the output."""

    def __init__(self, x: Signal, display: Display, settings: Settings, motion: int) -> None:
        self.length, self.pad = len(x), round(PADDING_S * display.rate)
        self.size = fft.next_fast_len(len(x) + 2 * self.pad, real=True)
        self.size += self.size % 2
        frequency = fft.rfftfreq(self.size, 1 / display.rate)
        self.band = band = reachable_band(display)
        samples = x.samples.astype(np.float64)
        if not display.dc:
            samples = samples - samples.mean(axis=1, keepdims=True)
        self.wanted = self._spectrum(samples)
        self.response = np.ones(len(frequency), np.complex128)
        self.capped: tuple[float, float] | None = None
        self.needed_db = 0.0
        self.cap_db = settings.cap_db
        # Acceleration to displacement divides by (j w)^2; nothing below the band is wanted.
        w = 2j * np.pi * np.maximum(frequency, max(band[0], frequency[1] if len(frequency) > 1 else 1.0))
        self.motion = w**motion
        result = InverseResponse(
            edges(frequency, band).astype(np.complex128), np.zeros(len(frequency), np.bool_)
        )
        if display.response is not None:
            self.response[1:] = display.response.at(frequency[1:])
            self.response[0] = 0.0
            if settings.equalise == "none":
                reference = abs(complex(display.response.at(settings.reference_hz)))
                result = InverseResponse(result.gain / reference, result.capped)
            else:
                full = settings.equalise == "full"
                result = inverse(display.response, frequency, band, cap_db=settings.cap_db, phase=full)
                inside = (frequency > band[0]) & (frequency < band[1])
                size = 1 / np.abs(self.response[inside])
                self.needed_db = float(20 * np.log10(size.max() / size.min()))
            if result.capped.any():
                where = frequency[result.capped]
                self.capped = (float(where.min()), float(where.max()))
        self.inverse = result.gain

    def unit_drive(self) -> NDArray[np.float64]:
        """Return the drive for a level factor of 1, float64, shape (channel, time)."""
        return self._time(self.wanted * self.motion * self.inverse)

    def output(self, drive: NDArray[np.float64], like: Signal) -> Signal:
        """Return the predicted output for ``drive``, in the unit of ``like``."""
        return like.with_samples(self._time(self._spectrum(drive) * self.response / self.motion))

    def unreachable(self, lost_db: float) -> list[str]:
        """Return sentences on the band and the cap; ``lost_db`` is the power outside of the band."""
        sentences = []
        if lost_db > 0.1:
            sentences.append(
                f"frequencies outside {self.band[0]:g} to {self.band[1]:g} Hz: {lost_db:.1f} dB of the signal's power"
            )
        if self.capped:
            sentences.append(
                f"{self.capped[0]:.0f} to {self.capped[1]:.0f} Hz in full: the response would need a gain of up to "
                f"{self.needed_db:.0f} dB, the cap is {self.cap_db:g} dB"
            )
        return sentences

    def _spectrum(self, x: NDArray[np.float64]) -> NDArray[np.complex128]:
        padded = np.zeros((len(x), self.size))
        padded[:, self.pad : self.pad + self.length] = x
        return np.asarray(fft.rfft(padded, axis=1))

    def _time(self, spectrum: NDArray[np.complex128]) -> NDArray[np.float64]:
        x = fft.irfft(spectrum, n=self.size, axis=1)
        return np.asarray(x[:, self.pad : self.pad + self.length])


def reachable_band(display: Display) -> tuple[float, float]:
    """Return the band of a display in Hz: its own, within the range of its response and half its rate."""
    low, high = display.band or (0.0, np.inf)
    if display.response is not None:
        low, high = max(low, display.response.range[0]), min(high, display.response.range[1])
    return low, float(min(high, display.rate / 2))


def _per_channel(signal: Signal, display: Display) -> tuple[Signal, list[str]]:
    """Return ``signal`` with one axis, or one per channel, and the names of the unused axes."""
    count = len(display.channels)
    if len(signal.axes) == 1:
        return signal, []
    if len(signal.axes) < count:
        raise ParameterError(
            f"{display.name} has {count} channels, the signal {len(signal.axes)} axes: give one axis or as many"
        )
    names = list(signal.axes[count:])
    return signal.with_samples(signal.samples[:count], axes=display.channels), names


def _levels(target: Signal, rendered: Signal) -> dict[str, float | None]:
    levels = {"wanted": sensation_level_db(target), "rendered": sensation_level_db(rendered)}
    return {name: value if np.isfinite(value) else None for name, value in levels.items()}


class LinearStream:
    """Drive of a linear display, block by block: a factor, and a causal equaliser of the response."""

    runs_on = False

    def __init__(self, display: Display, unit: str, facts: Mapping[str, Any]) -> None:
        settings = display.settings_as(Settings)
        self._channels = len(display.channels)
        self._factor = float(facts["factor"])
        self.equalises = display.response is not None and settings.equalise != "none"
        self._equaliser = Equaliser(_stream_design(display, settings, kinematic_power(unit, display)))

    @property
    def design(self) -> EqualiserDesign:
        """The filter in use."""
        return self._equaliser.design

    def process(self, block: NDArray[np.float32], motion: MotionBlock | None = None) -> NDArray[np.float64]:
        """Return the drive, one axis on every channel, or an axis per channel."""
        x = self._equaliser.process(block * self._factor)
        if len(x) == 1 < self._channels:
            return np.repeat(x, self._channels, axis=0)
        return np.asarray(x[: self._channels], np.float64)

    def facts(self) -> dict[str, Any]:
        """Return the factor and the equaliser's facts."""
        return {"factor": self._factor, "equaliser": {"on": self.equalises, **self.design.facts()}}


def _stream_design(display: Display, settings: Settings, motion: int) -> EqualiserDesign:
    """Return a filter with the magnitude of `drive`: band, capped inverse, unit."""
    response, band = display.response, reachable_band(display)
    # A file's cosine edges lie inside the band, where the two may differ.
    inner = (band[0] * 2**EDGE_OCTAVES, band[1] / 2**EDGE_OCTAVES)
    checked = inner if inner[0] < inner[1] else band
    if response is None or settings.equalise == "none":
        gain = 1.0 if response is None else 1 / abs(complex(response.at(settings.reference_hz)))
        return equaliser(display.rate, band, lambda f: gain * (2 * np.pi * f) ** motion, checked=checked)
    known = np.geomspace(max(band[0], 1.0), band[1], 2000)
    least = np.abs(response.at(known)).max() / 10 ** (settings.cap_db / 20)

    def wanted(frequency: NDArray[np.float64]) -> NDArray[np.float64]:
        size = np.maximum(np.abs(response.at(frequency)), least)
        return np.asarray((2 * np.pi * frequency) ** motion / size)

    return equaliser(display.rate, band, wanted, checked=checked)


FAMILY = DisplayFamily(
    name="linear",
    settings=Settings,
    drive=drive,
    stream_signal=LinearStream,
    measured_by="measure it with `tactogram sweep` and `tactogram response`",
    swept=True,
)

"""Ultrasonic displays: a vibration or a friction profile as the amplitude of a carrier at the transducer's resonance.

The drive is ``A (1 + m x) sin(2 pi f t)`` with A = limit / (gain (1 + m)), so that the amplifier's output stays within
the limit. Friction falls as the amplitude rises, so a friction profile is inverted first. The transducer passes the
envelope as a first-order low-pass at f / (2 Q); pre-emphasis compensates for it up to a cap, at the cost of depth, and
the facts state how far it reaches.

References
----------
- Hatori & Takemura (2023). IEEE Access 11. Sec. III-C: carrier at the resonance (about 28.2 kHz), gain 10, "a maximum
  voltage of 22 V", without stating peak or peak-to-peak, or the depth.
- Wiertlewski, Friesen & Colgate (2016). PNAS 113, 9210. doi 10.1073/pnas.1603908113: friction falls with amplitude.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.catalogue import DisplayFamily, MotionBlock
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.equaliser import Equaliser, EqualiserDesign, equaliser
from tactogram.rendering.drive.modulation import CarrierSettings, limited, pre_emphasis, scaled_within, shaped
from tactogram.rendering.drive.report import amount
from tactogram.rendering.drive.safety import fade_window
from tactogram.rendering.level import Level
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal

BAND = (0.0, 1000.0)
"""Band of the envelope, Hz: the publication's signals end at 1 kHz."""


class Settings(CarrierSettings):
    """Map from a signal to the drive of an ultrasonic display: the generator's voltage, before the amplifier."""

    resonant: ClassVar[bool] = True

    carrier_hz: float = Field(default=28_200.0, gt=0)
    """The transducer's resonance (Sec. III-C), which resonance tracking adjusts."""
    amplifier_gain: float = Field(default=10.0, gt=0)
    """Between generator and transducer. Sec. III-C."""
    limit_v: float = Field(default=22.0, gt=0)
    """Largest voltage at the transducer. Sec. III-C."""
    limit_is: Literal["peak", "peak-to-peak"] = "peak-to-peak"
    """Meaning of ``limit_v``, which the publication does not state; the smaller voltage is the default."""
    mapping: Literal["vibration", "friction"] = "vibration"
    """``vibration``: A (1 + m x). ``friction``: inverted, most amplitude where friction is least."""
    depth: float = Field(default=1.0, gt=0, le=1)
    """m of ``vibration``; the publication gives none."""
    friction_range: tuple[float, float] | None = None
    """Smallest and largest friction coefficient of the display, for ``friction``; None: the clip's own, reported."""
    q: float | None = Field(default=None, gt=0.5)
    """Quality factor of the transducer as it is touched; without it the response is unknown."""
    pre_emphasis: bool = False
    """Compensate for the transducer's low-pass; needs ``q``."""
    cap_db: float = Field(default=20.0, gt=0, le=60)
    """Largest gain of the pre-emphasis, dB."""
    loop: bool = False
    """The clip is one period of a loop: pre-emphasis continues across the seam, and nothing is faded."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.pre_emphasis and self.q is None:
            raise ValueError("pre_emphasis needs q, the transducer's quality factor as it is touched")
        if self.friction_range is not None and not self.friction_range[0] < self.friction_range[1]:
            raise ValueError(f"friction_range must be smallest and largest, got {self.friction_range}")
        if self.friction_range is not None and self.mapping != "friction":
            raise ValueError("friction_range is only for the mapping friction")
        return self

    @property
    def peak_v(self) -> float:
        """Largest voltage of the generator, 0 to peak."""
        at_transducer = self.limit_v if self.limit_is == "peak" else self.limit_v / 2
        return at_transducer / self.amplifier_gain

    @property
    def modulated_depth(self) -> float:
        """Effective depth m: friction uses the whole range of amplitudes."""
        return 1.0 if self.mapping == "friction" else self.depth

    @property
    def carrier_v(self) -> float:
        """Modulated amplitude A, V, 0 to peak."""
        return self.peak_v / (1 + self.modulated_depth)


def drive(
    signal: Signal, settings: Settings, *, display: Display, level: Level
) -> tuple[Signal, dict[str, Any]]:
    """Return the drive of an ultrasonic display, see `DriveFunction`.

    Level ``peak=SHARE``: the pre-emphasised clip's peak uses this share of the depth. ``gain=FACTOR``: parts of full
    modulation per unit of the signal. ``physical``: only the mapping ``friction`` with a measured ``friction_range``.
    The output on the skin in m/s^2 is unknown, so other levels are refused. Raises `UnitError` if the level does not
    apply; `ParameterError` if the display's limit is below what the settings allow, it has several channels, or
    `modulated` refuses.
    """
    display.check_volts(settings.peak_v, lower="limit_v")
    full_scale, share, words = _full_scale(level, settings, display)
    raw, facts = modulated(
        signal,
        settings,
        rate=display.rate,
        full_scale=full_scale,
        share=share,
        band=display.band or BAND,
        fade_s=0.0,
    )
    facts |= _sentences(facts, words) | {"faded": settings.loop}
    if settings.loop:
        facts["scaled"].append("nothing faded: it is one period of a loop, faded by its player")
    return Signal(raw.samples, display.rate, "V", display.channels), facts


def modulated(
    signal: Signal,
    settings: Settings,
    *,
    rate: float,
    full_scale: float | None = None,
    share: float = 1.0,
    band: tuple[float, float] = BAND,
    fade_s: float = 0.01,
) -> tuple[Signal, dict[str, Any]]:
    """Return the generator's voltage for ``signal`` (never above ``settings.peak_v`` in magnitude), and facts.

    ``signal`` has one axis over time, and is a friction coefficient (unit 1) for the mapping ``friction``. The
    ``rate`` (Hz) must be above twice carrier and band for a waveform, above twice the band for an envelope.
    ``full_scale`` is the value of the signal, in its own unit, that becomes x = 1; by default the clip's own peak
    becomes ``share``. The signal outside of ``band`` (Hz) is removed. Both ends are faded over ``fade_s`` (raised
    cosine) except for a loop.

    An envelope is >= 0. The facts are JSON values, among them ``highest_v``, ``recovered_depth`` (of the signal's peak
    as it arrives, within the attained band), ``removed_share`` (of the power) and ``transducer`` (None if q is
    unknown). Raises `UnitError` if the mapping is friction and the unit is not 1; `ParameterError` if the signal has
    several axes or is over displacement, the rate is too low, or the signal over-modulates.
    """
    _check(signal, settings, rate, band)
    x, span = _wanted(signal, settings)
    cutoff = settings.carrier_hz / (2 * settings.q) if settings.q else None
    waveform, filtering = shaped(
        resample(x, rate).samples[0].astype(np.float64),
        rate,
        band=band,
        cutoff_hz=cutoff,
        cap_db=settings.cap_db if settings.pre_emphasis else None,
        loop=settings.loop,
    )
    if settings.mapping == "friction":
        # -1..1 already. With the clip's own range it shrinks if pre-emphasis made it larger; a given range is fixed.
        full_scale = 1.0 if settings.friction_range else max(1.0, float(np.abs(waveform).max()))
    modulating, scale = scaled_within(
        waveform,
        full_scale=full_scale,
        share=share,
        remedy="widen friction_range or leave it out"
        if settings.mapping == "friction"
        else "lower the level",
    )
    depth = settings.modulated_depth
    envelope = settings.carrier_v * (1 + depth * modulating)
    if not settings.loop:
        envelope = envelope * fade_window(len(envelope), round(fade_s * rate))
    samples = limited(settings.output_of(envelope, rate), settings.peak_v)
    arriving = min(float(np.abs(x.samples).max()) / scale, 1.0)
    names = ("mapping", "output", "carrier_hz", "carrier_v", "peak_v", "limit_v", "limit_is")
    facts: dict[str, Any] = {
        **{name: getattr(settings, name) for name in names},
        "highest_v": float(np.abs(samples).max()),
        "depth": depth,
        "recovered_depth": depth * arriving,
        "unit": signal.unit,
        "friction_range": span,
        "full_scale": scale,
        **filtering,
    }
    if facts["transducer"] is not None:
        facts["transducer"]["q"] = settings.q
    return Signal(samples, rate, "V", ("drive",)), facts


def _full_scale(level: Level, settings: Settings, display: Display) -> tuple[float | None, float, str]:
    """Return full scale in the signal's unit, or the share that its peak becomes, and a sentence."""
    if settings.mapping == "friction":
        known = settings.friction_range is not None
        if (level.kind == "physical" and known) or (level.kind == "peak" and level.value == 1 and not known):
            what = f"the display's friction, {settings.friction_range}," if known else "the clip's own range"
            return None, 1.0, f"{what} becomes the whole range of amplitudes, inverted"
        raise UnitError(
            f"{display.name}: level {level} does not apply to the mapping friction: use physical with friction_range, "
            "or peak=1 without"
        )
    match level.kind:
        case "peak":
            share = float(level.value or 1.0)
            return None, share, f"the largest swing is {share:g} of the depth; the signal's own level is lost"
        case "gain":
            factor = float(level.value or 1.0)
            return 1 / factor, 1.0, f"{factor:g} of full modulation per unit of the signal, as requested"
    raise UnitError(
        f"{display.name}: level {level} needs this display's output on the skin, which was not measured: use "
        "gain=FACTOR (parts of full modulation per unit) or peak=SHARE"
    )


def _sentences(facts: dict[str, Any], words: str) -> dict[str, list[str]]:
    scaled = [words]
    if facts["mapping"] != "friction":
        scaled.append(f"{amount(facts['full_scale'], facts['unit'])} of the signal is full modulation")
    elif facts["full_scale"] > 1:
        scaled.append(
            f"the swing times {1 / facts['full_scale']:.4g}: band and pre-emphasis raised its peaks"
        )
    scaled.append(
        f"carrier of {facts['carrier_v']:.4g} V at the generator: {facts['limit_v']:g} V {facts['limit_is']} at the "
        "transducer, gain and depth"
    )
    unreachable = []
    if facts["removed_share"] > 1e-3:
        low, high = facts["band"]
        unreachable.append(
            f"{100 * facts['removed_share']:.1f} % of the power, outside {low:g} to {high:g} Hz"
        )
    transducer = facts["transducer"]
    if transducer is None:
        unreachable.append("frequencies that the transducer's resonance attenuates: its q is not known")
        return {"scaled": scaled, "clipped": [], "unreachable": unreachable}
    if transducer["minus_3_db_hz"] < facts["band"][1]:
        how = f"flat to {transducer['flat_to_hz']:.0f} Hz, " if transducer["pre_emphasis"] else ""
        unreachable.append(
            f"above {transducer['minus_3_db_hz']:.0f} Hz in full: Q {transducer['q']:g} passes the envelope {how}-3 dB "
            f"there; {100 * transducer['power_not_reached']:.1f} % of the power lies above"
        )
    if transducer["pre_emphasis"]:
        scaled.append(
            f"pre-emphasis: the signal's peak arrives with a depth of {facts['recovered_depth']:.3g} instead of "
            f"{facts['depth']:g}"
        )
    return {"scaled": scaled, "clipped": [], "unreachable": unreachable}


def _check(signal: Signal, settings: Settings, rate: float, band: tuple[float, float]) -> None:
    if signal.domain != "time":
        raise ParameterError(
            "the signal is over displacement: play it at a speed first (signal.displacement.played)"
        )
    if len(signal.axes) != 1:
        raise ParameterError(
            f"an ultrasonic display has one channel, got axes {', '.join(signal.axes)}: select one, or dft321"
        )
    if settings.mapping == "friction" and signal.unit != "1":
        raise UnitError(f"the mapping friction needs a friction coefficient, unit 1, got {signal.unit}")
    if not 0 <= band[0] < band[1] < settings.carrier_hz / 2:
        raise ParameterError.must("band", "be low < high in Hz and below half the carrier", band)
    settings.check_rate(rate, band[1])


def _wanted(signal: Signal, settings: Settings) -> tuple[Signal, list[float] | None]:
    """Return the modulating signal, for friction inverted and scaled to -1..1, and friction's range."""
    if settings.mapping != "friction":
        return signal, None
    mu: NDArray[np.float64] = signal.samples.astype(np.float64)
    low, high = settings.friction_range or (float(mu.min()), float(mu.max()))
    if high <= low:
        raise ParameterError(f"the friction coefficient is {low:g} throughout: give friction_range")
    return signal.with_samples(1 - 2 * (mu - low) / (high - low)), [low, high]


class UltrasonicStream:
    """Drive of an ultrasonic display, block by block, with a continuous carrier."""

    runs_on = False

    def __init__(self, display: Display, unit: str, facts: Mapping[str, Any]) -> None:
        settings = display.settings_as(Settings)
        if settings.mapping != "vibration":
            raise ParameterError(
                f"{display.name}: only the mapping vibration can be streamed, got {settings.mapping}"
            )
        self._settings = settings
        self._full_scale = float(facts["full_scale"])
        self.equalises = settings.pre_emphasis
        self._equaliser = Equaliser(_stream_design(display, settings))
        self._rate, self._sent = display.rate, 0
        self.limited = 0

    @property
    def design(self) -> EqualiserDesign:
        """The filter in use."""
        return self._equaliser.design

    def process(self, block: NDArray[np.float32], motion: MotionBlock | None = None) -> NDArray[np.float64]:
        """Return the drive, float64, shape (1, time)."""
        s = self._settings
        x = self._equaliser.process(np.asarray(block[:1], np.float64) / self._full_scale)
        self.limited += int(np.count_nonzero(np.abs(x) > 1))
        envelope = s.carrier_v * (1 + s.modulated_depth * np.clip(x, -1, 1))
        self._sent += x.shape[1]
        return s.output_of(envelope[0], self._rate, first=self._sent - x.shape[1])[None]

    def facts(self) -> dict[str, Any]:
        """Return full scale, carrier, over-modulated samples and the equaliser's facts."""
        return {
            "full_scale": self._full_scale,
            "carrier_hz": self._settings.carrier_hz,
            "over_modulated_samples": self.limited,
            "equaliser": {"on": self.equalises, **self.design.facts()},
        }


def _stream_design(display: Display, settings: Settings) -> EqualiserDesign:
    """Return a filter with the magnitude of `modulated`: band, and capped pre-emphasis."""
    band = display.band or BAND
    if not (settings.pre_emphasis and settings.q):
        return equaliser(display.rate, band, np.ones_like)
    cutoff, cap = settings.carrier_hz / (2 * settings.q), settings.cap_db
    return equaliser(display.rate, band, lambda f: np.abs(pre_emphasis(f, cutoff_hz=cutoff, cap_db=cap)))


FAMILY = DisplayFamily(
    name="ultrasonic",
    settings=Settings,
    drive=drive,
    stream_signal=UltrasonicStream,
    response_known=lambda display: isinstance(display.settings, Settings) and display.settings.q is not None,
    measured_by="set its q, which `tactogram transducer` determines from a measured admittance",
    hazard=(
        "The transducer runs at a high voltage behind the amplifier: keep hands off its terminals, and start with the "
        "amplifier turned down."
    ),
    close_up_s=0.02,
)

"""Electrovibration: a friction coefficient as the amplitude of a carrier, by the square law.

An electrode under an insulator attracts the finger with F_e = k_e V^2 (V rms), so that the friction coefficient seems
to be mu_0 (1 + k_e V^2 / F_n). Only increases are possible. The envelope is the *root* of the wanted increase: a
linear envelope would leave a second harmonic at a quarter of the first.

k_e is calibrated for a display and a person: that of an ideal plate is wrong by orders of magnitude, and people differ
much (Meyer, Peshkin & Colgate 2013). `rendering.drive.friction_calibration` fits it. A physical match is not a
perceptual match: played as measured, textures felt weak and needed 3 to 5 times the gain (Grigorii et al. 2021).

References
----------
- Cai et al. (2020). FrictGAN. ICAT-EGVE: friction over displacement for an electrostatic display.
- Meyer, Peshkin & Colgate (2013). IEEE World Haptics: the square law, and how people differ.
- Grigorii, Klatzky & Colgate (2021). IEEE Trans. Haptics. doi 10.1109/TOH.2021.3130091: playback of measured friction.
"""

from __future__ import annotations

import math
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field, model_validator

from tactogram.errors import ParameterError, UnitError
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.modulation import CarrierSettings, limited, shaped
from tactogram.rendering.drive.report import percent
from tactogram.rendering.level import Level
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal

HIGHEST_HZ = 1000.0
"""Highest frequency of the friction if a display states no band: that of Grigorii et al."""


class Settings(CarrierSettings):
    """Map from a friction coefficient to the voltage of an electrovibration display, at the electrode."""

    newton_per_v2: float = Field(gt=0, allow_inf_nan=False)
    """k_e: attraction per square of the rms voltage, N/V^2. Calibrated; typically about 1e-5."""
    calibrated_by: str = ""
    """Origin of k_e (person, date, file); empty if it was assumed, which reports state."""
    calibrated_to_v_rms: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    """Largest voltage of that calibration, V rms; reports state if it is exceeded."""
    mu_0: float = Field(gt=0, allow_inf_nan=False)
    """Friction coefficient of the finger on the display without voltage."""
    normal_force_n: float = Field(default=0.5, gt=0, allow_inf_nan=False)
    """Normal force of the finger, N; assumed if not measured. 0.2 to 1 N are usual."""
    perceptual_gain: float = Field(default=1.0, gt=0, allow_inf_nan=False)
    """Gain of the friction's deviation from its mean. 1 is the physical match; 3 (fine) to 5 (coarse) felt right to
    people (Grigorii et al. 2021)."""
    v_max: float = Field(gt=0, allow_inf_nan=False)
    """Largest voltage, 0 to peak. The amplifier must limit the current, too: no software does."""
    carrier_hz: float = Field(default=10_000.0, gt=0)
    """Above what can be felt. Grigorii & Colgate use 10 kHz and more."""
    slew_v_per_s: float = Field(default=200_000.0, gt=0, allow_inf_nan=False)
    """Largest slope of the envelope. 200 V/ms passes 250 Hz of 100 V at full depth."""
    below: Literal["shift", "clip"] = "shift"
    """Friction below mu_0 is impossible: raise all of it, or clip. Either is reported."""
    over: Literal["scale", "clip", "refuse"] = "scale"
    """For friction that needs more than v_max: reduce all increases, clip, or refuse."""
    clip_share: float = Field(default=0.001, ge=0, lt=1)
    """Share of the samples beyond v_max that may be clipped."""
    hysteresis_mm: float = Field(default=0.1, ge=0)
    """Playing along a finger's path: a finger that turns back moves this far before the texture does."""
    watchdog_s: float = Field(default=0.05, gt=0, le=1)
    """After this time without news of the finger the voltage goes to zero."""
    release_s: float = Field(default=0.01, gt=0, le=0.1)
    """Time in which it does so."""

    @model_validator(mode="after")
    def _carrier_is_fast(self) -> Self:
        if self.carrier_hz < 2000:
            raise ValueError(f"carrier_hz must be 2000 or more, above what is felt, got {self.carrier_hz:g}")
        return self

    @property
    def peak_v(self) -> float:
        """Largest voltage of the generator, 0 to peak."""
        return self.v_max / self.amplifier_gain

    @property
    def mu_max(self) -> float:
        """Largest friction coefficient, at v_max."""
        return float(friction(self.v_max / math.sqrt(2), self))


def friction(volts_rms: ArrayLike, settings: Settings) -> NDArray[np.float64]:
    """Return the friction coefficient at a voltage (V rms at the electrode): mu_0 (1 + k_e V^2 / F_n)."""
    v = np.asarray(volts_rms, np.float64)
    return np.asarray(settings.mu_0 * (1 + settings.newton_per_v2 * v**2 / settings.normal_force_n))


def voltage(mu: ArrayLike, settings: Settings) -> NDArray[np.float64]:
    """Return the voltage (V rms at the electrode) for a friction coefficient.

    0 if ``mu`` is mu_0 or less; at most v_max as an amplitude.
    """
    increase = np.asarray(mu, np.float64) / settings.mu_0 - 1
    # A smaller increase is a float32's rounding, but its root would be a voltage.
    increase = np.where(increase > 2e-7, increase, 0.0)
    square = np.clip(increase * settings.normal_force_n / settings.newton_per_v2, 0, settings.v_max**2 / 2)
    return np.asarray(np.sqrt(square))


def drive(
    signal: Signal, settings: Settings, *, display: Display, level: Level
) -> tuple[Signal, dict[str, Any]]:
    """Return the drive of an electrovibration display, see `DriveFunction`.

    Level ``physical``: the friction coefficient times the settings' perceptual gain. ``gain=FACTOR``: its deviation
    from the mean also times FACTOR. ``peak=SHARE``: any unit; the signal's minimum becomes mu_0, its maximum this
    share of v_max; its own level is lost. Raises `UnitError` if the level does not apply; `ParameterError` if the
    display's limit is below what the settings allow, it has several channels, or `modulated` refuses.
    """
    display.check_volts(settings.peak_v, lower="v_max")
    highest = display.band[1] if display.band else HIGHEST_HZ
    target, facts, sentences = friction_target(signal, settings, level)
    raw, more = modulated(target, settings, rate=display.rate, highest_hz=highest)
    if more["removed_share"] > 1e-3:
        share = 100 * more["removed_share"]
        sentences["unreachable"].append(f"{share:.1f} % of the power, above {highest:g} Hz")
    if more["slewed_share"] > 1e-3:
        sentences["clipped"].append(
            f"{percent(more['slewed_share'])} of the samples reduced by the slew limit of {settings.slew_v_per_s:g} V/s"
        )
    rms = more["highest_v"] / math.sqrt(2)
    if settings.calibrated_to_v_rms is not None and rms > settings.calibrated_to_v_rms * (1 + 1e-3):
        sentences["scaled"].append(
            f"up to {rms:.3g} V rms, but calibrated to {settings.calibrated_to_v_rms:g} V rms only: extrapolated"
        )
    return Signal(raw.samples, display.rate, "V", display.channels), {**facts, **more, **sentences}


def friction_target(
    signal: Signal, settings: Settings, level: Level
) -> tuple[Signal, dict[str, Any], dict[str, list[str]]]:
    """Return the friction coefficient to be rendered (unit 1, mu_0 to mu_max), with facts and lists of sentences.

    ``signal`` has one axis, over time or displacement: a friction coefficient (unit 1), or with level ``peak``
    anything; see `drive` for the levels. The facts are JSON values, among them ``gain`` (total), ``shift`` (added to
    the coefficient), ``below_share`` and ``beyond_share`` (of the samples that were clipped), ``mu_wanted`` and
    ``mu_given`` (minimum, mean, maximum). The sentences are ``scaled``, ``clipped`` and ``unreachable``.
    """
    if len(signal.axes) != 1:
        raise ParameterError(f"friction needs one axis, got {', '.join(signal.axes)}: select one")
    s = settings
    mu = signal.samples[0].astype(np.float64)
    scaled = [
        f"k_e {s.newton_per_v2:.3g} N/V^2, {s.calibrated_by or 'assumed, not calibrated'}; at a normal "
        f"force of {s.normal_force_n:g} N; perceptual gain {s.perceptual_gain:g}"
    ]
    clipped: list[str] = []
    unreachable: list[str] = []
    facts: dict[str, Any] = {
        **{
            name: getattr(s, name)
            for name in ("newton_per_v2", "mu_0", "mu_max", "normal_force_n", "perceptual_gain")
        },
        **dict.fromkeys(("shift", "below_share", "beyond_share"), 0.0),
        "calibrated_by": s.calibrated_by or None,
        "mu_wanted": None,
        "increase_scaled_by": 1.0,
    }
    if level.kind == "peak":
        gain, offset = _to_range(mu, s, float(level.value or 1.0))
        target = offset + gain * mu
        scaled.append(
            f"times {gain:.4g}: the largest voltage is {level.value:g} of v_max; its own level is lost"
        )
        facts |= {"gain": gain, "shift": offset}
    else:
        gain = s.perceptual_gain * _gain(signal, level)
        mean = float(mu.mean())
        target = mean + gain * (mu - mean)
        facts |= {"gain": gain, "mu_wanted": _least_mean_largest(target)}
        if gain != 1:
            scaled.append(f"deviation from the mean times {gain:.4g}: not a physical match")
        target = _raised(target, s, facts, scaled, clipped)
        target = _lowered(target, s, facts, scaled, clipped)
        if facts["shift"]:
            unreachable.append(f"friction below {s.mu_0:g}, that of the finger on the bare display")
        if facts["increase_scaled_by"] < 1:
            unreachable.append(
                f"friction above {s.mu_max:.3g}: {percent(facts['increase_scaled_by'])} of the wanted swing is rendered"
            )
    target = np.clip(target, s.mu_0, s.mu_max)
    facts["mu_given"] = _least_mean_largest(target)
    sentences = {"scaled": scaled, "clipped": clipped, "unreachable": unreachable}
    return signal.with_samples(target, unit="1", axes=("friction",)), facts, sentences


def modulated(
    target: Signal, settings: Settings, *, rate: float, highest_hz: float = HIGHEST_HZ
) -> tuple[Signal, dict[str, Any]]:
    """Return the generator's voltage for a friction coefficient over time, and facts.

    The coefficient (unit 1) is clipped to mu_0 to mu_max and low-passed at ``highest_hz``. The voltage's magnitude
    never exceeds ``settings.peak_v``; an envelope is the carrier's amplitude, the root of two times the rms.
    ``highest_v`` is that at the electrode, ``removed_share`` of the power, ``slewed_share`` of the samples. Raises
    `UnitError` or `ParameterError` if it is no friction coefficient over time, or ``rate`` (Hz) is too low.
    """
    if target.unit != "1":
        raise UnitError(f"a friction coefficient must have unit 1, got {target.unit}")
    if target.domain != "time" or len(target.axes) != 1:
        raise ParameterError.must(
            "friction",
            "be one axis over time (played along a finger's path first), got "
            f"{len(target.axes)} over {target.domain}",
        )
    s = settings
    s.check_rate(rate, highest_hz)
    mu = resample(target, rate).samples[0].astype(np.float64)
    mu, filtering = shaped(mu, rate, band=(0.0, highest_hz), cutoff_hz=None, cap_db=None, loop=False)
    amplitude_v = math.sqrt(2) * voltage(mu, s)
    envelope = slewed(amplitude_v, s.slew_v_per_s / rate)
    samples = limited(s.output_of(envelope, rate) / s.amplifier_gain, s.peak_v)
    return Signal(samples, rate, "V", ("drive",)), {
        "output": s.output,
        "carrier_hz": s.carrier_hz,
        "v_max": s.v_max,
        "highest_v": float(np.abs(samples).max()) * s.amplifier_gain,
        "highest_hz": highest_hz,
        "removed_share": filtering["removed_share"],
        "slew_v_per_s": s.slew_v_per_s,
        "slewed_share": float(np.mean(amplitude_v - envelope > 1e-6 * s.v_max)),
    }


def slewed(wanted: NDArray[np.float64], most: float) -> NDArray[np.float64]:
    """Return the largest envelope nowhere above ``wanted`` (>= 0) that changes by at most ``most`` per sample."""
    ramp = most * np.arange(len(wanted))
    rising = np.minimum.accumulate(wanted - ramp) + ramp
    falling: NDArray[np.float64] = (np.minimum.accumulate((rising + ramp)[::-1])[::-1]) - ramp
    return np.maximum(falling, 0)


def _gain(signal: Signal, level: Level) -> float:
    """Return the level's factor of the friction's deviation from its mean."""
    if signal.unit != "1":
        raise UnitError(
            f"level {level} needs a friction coefficient (unit 1), got {signal.unit}; any signal takes peak=SHARE"
        )
    if level.kind == "sensation":
        raise UnitError(
            "level sensation does not apply to friction, whose threshold is not vibration's; use physical or gain"
        )
    return float(level.value or 1.0) if level.kind == "gain" else 1.0


def _to_range(mu: NDArray[np.float64], s: Settings, share: float) -> tuple[float, float]:
    low, high = float(mu.min()), float(mu.max())
    if high <= low:
        raise ParameterError(f"the signal is {low:g} throughout: it must vary")
    gain = (float(friction(share * s.v_max / math.sqrt(2), s)) - s.mu_0) / (high - low)
    return gain, s.mu_0 - gain * low


def _raised(
    target: NDArray[np.float64], s: Settings, facts: dict[str, Any], scaled: list[str], clipped: list[str]
) -> NDArray[np.float64]:
    """Return the target without values below mu_0, shifted or clipped."""
    low = float(target.min())
    if low >= s.mu_0:
        return target
    if s.below == "shift":
        facts["shift"] = s.mu_0 - low
        scaled.append(f"{s.mu_0 - low:.3g} added to the friction coefficient: only increases are possible")
        return target + (s.mu_0 - low)
    facts["below_share"] = float(np.mean(target < s.mu_0))
    clipped.append(f"{percent(facts['below_share'])} of the samples at mu_0 {s.mu_0:g}, the least possible")
    return np.maximum(target, s.mu_0)


def _lowered(
    target: NDArray[np.float64], s: Settings, facts: dict[str, Any], scaled: list[str], clipped: list[str]
) -> NDArray[np.float64]:
    """Return the target without values above mu_max, its increases scaled or clipped."""
    most = s.mu_max
    share = float(np.mean(target > most * (1 + 1e-12)))
    if share > s.clip_share and s.over != "clip":
        high = float(target.max())
        if s.over == "refuse":
            raise ParameterError(
                f"{percent(share)} of the friction is beyond {most:.3g}, what v_max {s.v_max:g} V gives (largest "
                f"{high:.3g}); lower the level or the gain, or let it scale or clip"
            )
        factor = (most - s.mu_0) / (high - s.mu_0)
        facts["increase_scaled_by"] = factor
        scaled.append(f"increases times {factor:.3g}: v_max {s.v_max:g} V gives no more than {most:.3g}")
        return s.mu_0 + factor * (target - s.mu_0)
    facts["beyond_share"] = share
    if share > 0:
        clipped.append(f"{percent(share)} of the samples at {most:.3g}, what v_max {s.v_max:g} V gives")
    return np.minimum(target, most)


def _least_mean_largest(x: NDArray[np.float64]) -> list[float]:
    return [float(x.min()), float(x.mean()), float(x.max())]

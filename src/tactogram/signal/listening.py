"""Signal as sound: one axis, at a rate that browsers play."""

from __future__ import annotations

from tactogram.signal.displacement import played
from tactogram.signal.figure import AUDIBLE_RATE, SPEED_MM_S, strongest, wav_of
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal


def strongest_axis(signal: Signal) -> Signal:
    """Return the axis with the most power, without its mean."""
    index = strongest(signal.samples)
    samples = signal.samples[index]
    return signal.with_samples(samples - samples.mean(), axes=(signal.axes[index],))


def audible(signal: Signal) -> Signal:
    """Return the `strongest_axis` over time, at `AUDIBLE_RATE` or above."""
    mono = strongest_axis(signal)
    if mono.domain == "displacement":
        return played(mono, SPEED_MM_S, max(AUDIBLE_RATE, mono.rate * SPEED_MM_S))
    return resample(mono, max(AUDIBLE_RATE, mono.rate))


def wav_bytes(signal: Signal) -> bytes:
    """Return `audible` as a WAV file, peak at 0.9."""
    heard = audible(signal)
    return wav_of(heard.samples[0], heard.rate)

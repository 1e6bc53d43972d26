"""Signal as sound: one axis, at a rate that browsers play."""

from __future__ import annotations

import io

import numpy as np
import soundfile

from tactogram.signal.displacement import played
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal

AUDIBLE_RATE = 8000.0
"""Hz; browsers refuse to play files below 3000."""
SPEED_MM_S = 100.0
"""Of the finger, for signals over displacement."""


def strongest_axis(signal: Signal) -> Signal:
    """Return the axis with the most power, without its mean."""
    samples = signal.samples - signal.samples.mean(axis=1, keepdims=True)
    place = int((samples.astype(np.float64) ** 2).sum(axis=1).argmax())
    return signal.with_samples(samples[place], axes=(signal.axes[place],))


def audible(signal: Signal) -> Signal:
    """Return the `strongest_axis` over time, at `AUDIBLE_RATE` or above."""
    one = strongest_axis(signal)
    if one.domain == "displacement":
        return played(one, SPEED_MM_S, max(AUDIBLE_RATE, one.rate * SPEED_MM_S))
    return resample(one, max(AUDIBLE_RATE, one.rate))


def wav_bytes(signal: Signal) -> bytes:
    """Return `audible` as a WAV file, peak at 0.9."""
    heard = audible(signal)
    sound = heard.samples[0] / max(float(np.abs(heard.samples).max()), 1e-12) * 0.9
    file = io.BytesIO()
    soundfile.write(file, sound, round(heard.rate), format="WAV", subtype="PCM_16")
    return file.getvalue()

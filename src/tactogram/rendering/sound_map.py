"""Sounds mapped to touch: by envelope, by pitch, or band by band.

A sound of 20 Hz to 20 kHz does not fit the 20 to 500 Hz that skin feels well, and no mapping is best for all: an
envelope suits speech, engines and impacts, a pitch one instrument or voice, bands music. Each keeps the sound's level
(rms).
"""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy import fft

from tactogram.errors import ParameterError
from tactogram.rendering.files.analysis import READ_RATE, carrier, envelope_of
from tactogram.rendering.files.events import Events, Part
from tactogram.signal import Signal
from tactogram.signal.resampling import resample

SoundMap = Literal["envelope", "pitch", "bands"]

LOWEST_HZ, HIGHEST_HZ = 20.0, 500.0
"""Band of touch that sounds are mapped to, Hz."""
CARRIER_HZ = 250.0
"""Of an envelope: where touch is most sensitive."""
BANDS = ((0.0, 200.0, 50.0), (200.0, 800.0, 100.0), (800.0, 3200.0, 200.0), (3200.0, np.inf, 400.0))
"""Bands of the sound and the tone that each becomes, Hz. A choice: two octaves become one."""
PITCHES = (50.0, 2000.0)
"""Pitches that are found, Hz."""
PITCH_RATE = 16_000.0
HOP_S, WINDOW_S = 0.010, 0.040
APERIODIC = 0.15
"""Threshold of `pitch_of`: de Cheveigné & Kawahara use 0.1 to 0.15."""
QUARTER_TONE = 1 / 24
"""Octaves by which a pitch may exceed the band of touch."""
FRAMES = 1000
"""Frames that are analysed together."""


def sound_to_touch(sound: Signal, by: SoundMap) -> tuple[Signal, dict[str, Any]]:
    """Return a vibration of 20 to 500 Hz for a sound of one axis over time, at `READ_RATE`, and JSON facts.

    - ``envelope``: a tone of `CARRIER_HZ` with the sound's strength.
    - ``pitch``: a tone at the sound's pitch (`pitch_of`), with its strength. All of it is moved down by the octaves
      that bring the highest pitch to 500 Hz or below, so that intervals remain; what is then below 20 Hz is moved up.
    - ``bands``: the sum of a tone for each of `BANDS`, with the strength of that band.

    ``facts`` has ``by``, ``touch_hz`` (lowest and highest) and, of a pitch, ``octaves_down`` and ``voiced`` (the share
    of the time with a pitch). Raises `ParameterError` if there is no such map, or the sound has no pitch.
    """
    if by not in get_args(SoundMap):
        raise ParameterError.one_of("map", get_args(SoundMap), by)
    facts: dict[str, Any] = {"by": by}
    if by == "bands":
        used = [(low, min(high, sound.rate / 2), hz) for low, high, hz in BANDS if low < sound.rate / 2]
        tones = [_tone(sound, envelope_of(sound, low=low, high=high), hz) for low, high, hz in used]
        touch = tones[0].with_samples(np.sum([tone.samples for tone in tones], axis=0))
        span = (used[0][2], used[-1][2])
    else:
        strength = envelope_of(sound, high=sound.rate / 2)
        hz: NDArray[np.float64] | float = CARRIER_HZ
        if by == "pitch":
            pitch = pitch_of(sound)
            hz, octaves = _moved_down(pitch, strength)
            facts |= {"octaves_down": octaves, "voiced": float(np.mean(np.isfinite(pitch)))}
        touch = _tone(sound, strength, hz)
        span = (float(np.min(hz)), float(np.max(hz)))
    return touch.with_samples(touch.samples, unit=sound.unit), facts | {"touch_hz": list(span)}


def pitch_of(sound: Signal) -> NDArray[np.float64]:
    """Return the pitch of a sound of one axis every `HOP_S`, Hz, NaN where it has none: float64, shape (time,).

    YIN (de Cheveigné & Kawahara 2002, JASA 111:1917), steps 1 to 5, of frames that begin at each time.
    """
    x = resample(sound, PITCH_RATE).samples[0].astype(np.float64)
    window, longest = round(WINDOW_S * PITCH_RATE), round(PITCH_RATE / PITCHES[0])
    shortest, hop = round(PITCH_RATE / PITCHES[1]), round(HOP_S * PITCH_RATE)
    count = int(sound.seconds / HOP_S) + 1
    needed = (count - 1) * hop + window + longest + 1
    x = np.pad(x, (0, max(0, needed - len(x))))
    frames = sliding_window_view(x, window + longest + 1)[: (count - 1) * hop + 1 : hop]
    pitches = [
        _pitches(frames[first : first + FRAMES], window, shortest) for first in range(0, len(frames), FRAMES)
    ]
    return np.concatenate(pitches)


def _pitches(frames: NDArray[np.float64], window: int, shortest: int) -> NDArray[np.float64]:
    lags = np.arange(frames.shape[1] - window)
    size = fft.next_fast_len(frames.shape[1] + window, real=True)
    spectrum = fft.rfft(frames, size)
    head = fft.rfft(frames[:, :window], size)
    product = fft.irfft(spectrum * np.conj(head), size)[:, : len(lags)]
    energy = np.cumsum(np.pad(frames**2, ((0, 0), (1, 0))), axis=1)
    power = energy[:, window:][:, : len(lags)] - energy[:, : len(lags)]
    difference = np.maximum(power[:, :1] + power - 2 * product, 0)
    mean = np.cumsum(difference, axis=1) / np.maximum(lags, 1)
    # Silence has no pitch: its difference is 0 at every lag.
    loud = power[:, 0] > 1e-9 * max(float(power.max()), 1e-30)
    normal = np.where(mean > 0, difference / np.maximum(mean, 1e-30), 1.0)
    normal[~loud] = 1.0
    pitch = np.full(len(frames), np.nan)
    for i, curve in enumerate(normal):
        below = np.flatnonzero(curve[shortest:-1] < APERIODIC)
        if not len(below):
            continue
        lag = shortest + int(below[0])
        while lag + 1 < len(curve) - 1 and curve[lag + 1] < curve[lag]:
            lag += 1
        # Step 5: the minimum of the difference itself, since its mean moves that of their ratio.
        before, here, after = difference[i, lag - 1 : lag + 2]
        bend = before - 2 * here + after
        pitch[i] = PITCH_RATE / (lag + (0.5 * (before - after) / bend if bend > 0 else 0.0))
    return pitch


def _moved_down(pitch: NDArray[np.float64], strength: Part) -> tuple[NDArray[np.float64], int]:
    """Return the pitch at the times of an envelope, moved into the band of touch, and by how many octaves."""
    voiced = np.flatnonzero(np.isfinite(pitch))
    if not len(voiced):
        raise ParameterError("the sound has no pitch to follow; map it by envelope or bands")
    # A frame lies around the middle of its window.
    hz = np.interp(strength.times, voiced * HOP_S + WINDOW_S / 2, pitch[voiced])
    octaves = max(0, int(np.ceil(np.log2(hz.max() / HIGHEST_HZ) - QUARTER_TONE)))
    hz = hz / 2**octaves
    return hz * 2 ** np.maximum(0, np.ceil(np.log2(LOWEST_HZ / hz))), octaves


def _tone(sound: Signal, strength: Part, hz: NDArray[np.float64] | float) -> Signal:
    tone = Part(strength.times, strength.amplitude, np.broadcast_to(hz, strength.times.shape))
    return carrier(Events(sound.seconds, (tone,)), READ_RATE)

"""Browser sound of a signal: one channel at a sound card's rate, with its gain and the share of limited samples."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass

import numpy as np
import soundfile
from fastapi import Response
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering import fade_window
from tactogram.signal import Signal, resample

RATE = 48_000
NORMAL_PEAK = 0.5
"""Largest sample of a normalised sound, in full scales: 6 dB below full scale."""
KNEE = 0.8
"""Limiter's threshold; no sample exceeds 1."""
FADE_S = 0.005
LONGEST_S = 60.0
"""Longer signals are cut."""
PLAYBACK_MM_S = 100.0
"""Speed at which a signal over displacement is played."""
MOST_GAIN = 1e9
_RANGE = re.compile(r"bytes=(\d{0,15})-(\d{0,15})")


@dataclass(frozen=True)
class AudioClip:
    """Sound for the browser: one channel of float32 at `RATE`, ``gain`` in full scales per unit of the signal.

    ``limited`` is the share of samples that the limiter changed. Loudnesses of ``normalised`` sounds cannot be
    compared.
    """

    wav: bytes
    gain: float
    limited: float
    normalised: bool


LISTENING = f"{RATE // 1000} kHz, 16 bit, normalised to a peak of {NORMAL_PEAK:g} of full scale"
"""What `sound_of` returns of a signal as ``PCM_16`` without a gain."""


def sound_of(signal: Signal, *, gain: float | None = None, subtype: str = "FLOAT") -> AudioClip:
    """Return a signal's sound for the browser, or any player.

    Axes become one by DFT321, which keeps the power at every frequency; the mean is removed; the ends are faded over 5
    ms. A signal over displacement is played at `PLAYBACK_MM_S`. Without a ``gain`` (full scales per unit, > 0), the
    largest sample becomes `NORMAL_PEAK`. ``subtype`` is the WAV's: 32-bit FLOAT, or PCM_16.
    """
    if gain is not None and not 0 < gain <= MOST_GAIN:
        raise ParameterError.must("gain", f"be > 0 and at most {MOST_GAIN:g}", gain)
    x = _one_channel(signal)
    if len(x) > 1:
        x *= fade_window(len(x), round(FADE_S * RATE))
    normalised = gain is None
    if gain is None:
        gain = common_gain([float(np.abs(x).max())])
    played, share = soft_limited(gain * x)
    out = io.BytesIO()
    soundfile.write(out, played.astype(np.float32), RATE, subtype, format="WAV")
    return AudioClip(out.getvalue(), gain, share, normalised)


def listening_name(stem: str) -> str:
    """Return the name of a file for listening."""
    return f"{stem}-listening.wav"


def sound_text(signal: Signal) -> str:
    """Return what a sound for listening lost of a signal, to follow its name."""
    over_time = signal.domain == "time"
    seconds = signal.extent if over_time else signal.extent / PLAYBACK_MM_S
    lost = ["its strength"]
    lost += ["its axes, combined into one channel"] if len(signal.axes) > 1 else []
    lost += [f"what is after {LONGEST_S:g} s"] if seconds > LONGEST_S else []
    played = "" if over_time else f", played at {PLAYBACK_MM_S:g} mm/s"
    return f"is for listening alone{played}: it loses {' and '.join(lost)}"


def common_gain(peaks: list[float]) -> float:
    """Return the gain at which the strongest signal peaks at `NORMAL_PEAK`; ``peaks`` are those of `traits.peak_of`.

    Combined axes may exceed that by at most the square root of their number.
    """
    peak = max(peaks, default=0.0)
    return min(NORMAL_PEAK / peak, MOST_GAIN) if peak > 0 else 1.0


def soft_limited(x: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return ``x`` smoothly limited to 1 above `KNEE`, and the share of samples above it."""
    size = np.abs(x)
    over = size > KNEE
    room = 1 - KNEE
    bent = KNEE + room * np.tanh((size - KNEE) / room)
    return np.where(over, np.sign(x) * bent, x), float(over.mean())


def range_response(
    data: bytes, requested: str | None, *, media_type: str, headers: dict[str, str]
) -> Response:
    """Return ``data``, one range of its bytes, or a refusal (RFC 9110, section 14).

    Safari plays an `<audio>` element only from a server that supports ranges.
    ``requested`` is the request's ``range`` header; if it is malformed or names several ranges, all bytes are sent.
    """
    headers = headers | {"accept-ranges": "bytes"}
    match = _RANGE.fullmatch((requested or "").strip())
    first, last = match.groups() if match else ("", "")
    if not (first or last) or (first and last and int(first) > int(last)):
        return Response(data, media_type=media_type, headers=headers)
    start = int(first) if first else max(0, len(data) - int(last))
    stop = min(len(data), int(last) + 1) if first and last else len(data)
    if start >= stop:
        return Response(status_code=416, headers=headers | {"content-range": f"bytes */{len(data)}"})
    headers["content-range"] = f"bytes {start}-{stop - 1}/{len(data)}"
    return Response(data[start:stop], status_code=206, media_type=media_type, headers=headers)


def _one_channel(signal: Signal) -> NDArray[np.float64]:
    """Return one channel at `RATE` without its mean, float64, shape (time,)."""
    if signal.domain == "displacement":
        signal = Signal(signal.samples, signal.rate * PLAYBACK_MM_S, signal.unit, signal.axes)
    signal = signal.cut(0, max(1, round(LONGEST_S * signal.rate)))
    while len(signal.axes) > 1:
        signal = _combined(signal)
    x = signal.samples.astype(np.float64)
    centred = signal.with_samples((x - x.mean()).astype(np.float32))
    if len(centred) * RATE / centred.rate >= 1:
        centred = resample(centred, RATE)
    channel: NDArray[np.float64] = centred.samples[0].astype(np.float64)
    return channel


def _combined(signal: Signal) -> Signal:
    """Return a signal whose first two or three axes are combined by DFT321."""
    from tactogram.signal import dft321

    x = signal.samples
    first = np.zeros((3, len(signal)), np.float32)
    first[: len(x[:3])] = x[:3]  # an axis of zeros adds neither power nor phase
    vibration = dft321(Signal(first, signal.rate, signal.unit)).samples
    names = tuple(f"axis {number}" for number in range(1 + len(x[3:])))
    return Signal(np.concatenate([vibration, x[3:]]), signal.rate, signal.unit, names)

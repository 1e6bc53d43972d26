"""Signal in a notebook: facts, waveform, spectrogram and player; below `Signal`, which shows itself by it."""

from __future__ import annotations

import base64
import html
import io

import numpy as np
import soundfile
import soxr
from numpy.typing import NDArray

from tactogram.signal.figure import _Drawn, signal_figure

HEARD_S = 10.0
AUDIBLE_RATE = 8000.0
"""Hz; browsers refuse to play files below 3000."""
SPEED_MM_S = 100.0
"""Of the finger, for signals over displacement."""


def signal_html(signal: _Drawn) -> str:
    """Return a signal as HTML that needs no other file."""
    picture = io.BytesIO()
    signal_figure(signal).savefig(picture, format="png", dpi=80)
    heard = signal.samples
    rate = signal.rate
    if signal.domain == "time":
        heard = heard[:, : max(1, round(HEARD_S * rate))]
    else:
        rate *= SPEED_MM_S
    axis = strongest(heard)
    x = heard[axis] - heard[axis].mean()
    if rate < AUDIBLE_RATE:
        x, rate = soxr.resample(x, rate, AUDIBLE_RATE), AUDIBLE_RATE
    sound = base64.b64encode(wav_of(x, rate)).decode()
    drawn = base64.b64encode(picture.getvalue()).decode()
    facts = html.escape(str(signal))
    return (
        f"<p>{facts}</p>"
        f'<img alt="waveform and spectrogram of {facts}" src="data:image/png;base64,{drawn}">'
        f'<br><audio controls src="data:audio/wav;base64,{sound}"></audio>'
    )


def strongest(samples: NDArray[np.float32]) -> int:
    """Return the row, of samples (axis, time), with the most power about its mean."""
    power = np.square(samples - samples.mean(axis=1, keepdims=True), dtype=np.float64)
    return int(power.sum(axis=1).argmax())


def wav_of(x: NDArray[np.float32], rate: float) -> bytes:
    """Return one axis, shape (time,), as a WAV file, peak at 0.9."""
    file = io.BytesIO()
    sound = x / max(float(np.abs(x).max()), 1e-12) * 0.9
    soundfile.write(file, sound, round(rate), format="WAV", subtype="PCM_16")
    return file.getvalue()

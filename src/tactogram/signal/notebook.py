"""Signal in a notebook: facts, waveform, spectrogram and player."""

from __future__ import annotations

import base64
import html
import io
from typing import TYPE_CHECKING

from tactogram.signal.figure import signal_figure
from tactogram.signal.listening import wav_bytes

if TYPE_CHECKING:
    from tactogram.signal.signal import Signal

HEARD_S = 10.0


def signal_html(signal: Signal) -> str:
    """Return a signal as HTML that needs no other file."""
    picture = io.BytesIO()
    signal_figure(signal).savefig(picture, format="png", dpi=80)
    heard = signal.cut(0, max(1, round(HEARD_S * signal.rate))) if signal.domain == "time" else signal
    sound = base64.b64encode(wav_bytes(heard)).decode()
    drawn = base64.b64encode(picture.getvalue()).decode()
    facts = html.escape(str(signal))
    return (
        f"<p>{facts}</p>"
        f'<img alt="waveform and spectrogram of {facts}" src="data:image/png;base64,{drawn}">'
        f'<br><audio controls src="data:audio/wav;base64,{sound}"></audio>'
    )

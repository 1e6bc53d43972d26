"""Figure of a stream: the finger, and the spectrogram of what was sent."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy import signal as dsp

from tactogram.signal import Signal

WINDOW_S = 0.064
HIGHEST_HZ = 1000.0
RANGE_DB = 50.0


def stream_figure(sent: Signal, track: NDArray[np.float64], *, title: str) -> Figure:
    """Return speed and force over time, and the spectrogram of the first channel up to 1 kHz.

    ``track`` has time in s, speed in mm/s and force in N at the end of each block, float64, shape (block, 3).
    """
    figure = Figure(figsize=(11, 6), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1, 2.2))
    above.plot(track[:, 0], track[:, 1], color="tab:blue", linewidth=0.9)
    above.set_ylabel("speed in contact, mm/s", color="tab:blue")
    above.set_ylim(bottom=0)
    force = above.twinx()
    force.plot(track[:, 0], track[:, 2], color="tab:orange", linewidth=0.9)
    force.set_ylabel("force, N", color="tab:orange")
    force.set_ylim(bottom=0)
    width = max(16, round(WINDOW_S * sent.rate))
    frequency, time, power = dsp.spectrogram(
        sent.samples[0].astype(np.float64),
        fs=sent.rate,
        window="hann",
        nperseg=min(width, len(sent)),
        noverlap=min(3 * width // 4, len(sent) - 1),
    )
    shown = frequency <= HIGHEST_HZ
    level = 10 * np.log10(np.maximum(power[shown], 1e-30))
    top = float(np.percentile(level, 99.8))
    unit = "full scale" if sent.unit == "1" else sent.unit
    mesh = below.pcolormesh(
        time,
        frequency[shown],
        level,
        vmin=top - RANGE_DB,
        vmax=top,
        cmap="magma",
        shading="auto",
        rasterized=True,
    )
    below.set_xlabel("time, s")
    below.set_ylabel("frequency, Hz")
    below.set_xlim(0, sent.seconds)
    figure.colorbar(mesh, ax=below, label=f"dB re 1 ({unit})²/Hz", pad=0.01)
    figure.suptitle(title, fontsize=11)
    return figure

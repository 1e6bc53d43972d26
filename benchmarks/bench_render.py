"""Benchmark of rendering: cost as a multiple of resampling to the display's rate, in the same run.

Ten seconds of a simulated texture of three axes at 1 kHz (friction of one axis for electrovibration), at half of full
drive, report included. Resampling (soxr, very high quality, one axis) is what no drive can do without; a display at
1 kHz needs none and stands without a ratio. ``faster`` is how many times faster than real time the whole is. Each
repetition runs both in turn; the ratio is the median of five. One thread for both.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from tactogram.rendering.displays.catalogue import display_family, open_display, shipped
from tactogram.rendering.drive.fit import fit
from tactogram.rendering.level import parse_level
from tactogram.signal import Signal
from tactogram.signal.resampling import resample

RATE, SECONDS = 1000.0, 10.0
REPETITIONS = 5


def run() -> list[dict[str, Any]]:
    """Return a row per shipped display; see the module for what is measured."""
    with threadpool_limits(1):
        return [row(name) for name in shipped()]


def row(name: str) -> dict[str, Any]:
    """Time one display."""
    display, level = open_display(name), parse_level("peak=0.5")
    rng = np.random.default_rng(0)
    x = rng.standard_normal((3, round(RATE * SECONDS))).astype(np.float32)
    texture = Signal(x, RATE, "m/s^2")
    if display_family(display.family).renders == "friction":
        texture = Signal(0.5 + 0.1 * x[:1], RATE, "1")
    one = texture.select(texture.axes[0])
    fit(texture, display, level=level)
    ratios, taken = [], []
    for _ in range(REPETITIONS):
        start = time.perf_counter()
        resample(one, display.rate)
        middle = time.perf_counter()
        fit(texture, display, level=level)
        end = time.perf_counter()
        ratios.append((end - middle) / (middle - start))
        taken.append(end - middle)
    seconds = float(np.median(taken))
    return {
        "display": name,
        "rate_hz": display.rate,
        "ratio": round(float(np.median(ratios)), 2) if display.rate != RATE else None,
        "ratio_sd": round(float(np.std(ratios)), 2) if display.rate != RATE else None,
        "seconds": round(seconds, 4),
        "faster": round(SECONDS / seconds, 1),
    }


if __name__ == "__main__":
    for result in run():
        print(result)

"""Benchmark of rendering: cost as a multiple of resampling to the display's rate, in the same run.

Ten seconds of a simulated texture of three axes at 1 kHz (friction of one axis for electrovibration), at half of full
drive, report included. Resampling (soxr, very high quality, one axis) is what no drive can do without; a display at
1 kHz needs none and stands without a ratio. ``faster`` is how many times faster than real time the whole is. Each
repetition runs both in turn; the ratio is the median of five. One thread for both.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.timing import beside
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
    found = beside(
        lambda: resample(one, display.rate), lambda: fit(texture, display, level=level), REPETITIONS
    )
    if display.rate == RATE:
        found |= {"ratio": None, "ratio_sd": None}
    return {
        "display": name,
        "rate_hz": display.rate,
        **found,
        "faster": round(SECONDS / found["seconds"], 1),
    }

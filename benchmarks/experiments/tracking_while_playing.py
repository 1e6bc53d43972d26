"""Resonance tracking of a simulated transducer while a texture plays, beside the same with a steady carrier.

A generator sends envelopes of noise around 140 Hz at full depth to a transducer whose resonance drifts; every quarter
of a second the admittance is measured on the modulated carrier, and the carrier moved by at most 5 Hz. Nothing in it
was measured on a device.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import signal as dsp

from tactogram.errors import ParameterError
from tactogram.rendering.displays.catalogue import open_display
from tactogram.rendering.families.ultrasonic import Settings
from tactogram.workflows.progress import ProgressCallback
from tactogram_playback.transducer.circuit import PRESETS
from tactogram_playback.transducer.simulation import BenchSettings, SimulatedGenerator
from tactogram_playback.workflows.carrier_tracking import CarrierTracking

DISPLAY = "ultrasonic-envelope"
TRANSDUCERS = ("plate", "finger")
DRIFT_HZ_PER_S, SECONDS, EVERY_S = 1.0, 20.0, 0.25
BLOCK_S = 0.05
SETTLED = 40
"""Steps until the carrier has caught up with the drift during the lock's sweep."""


def run(folder: Path, *, paper: bool, progress: ProgressCallback, seeds: int = 5) -> dict[str, Any]:
    """Return the carrier's distance from the resonance for each transducer, while a texture plays and without one.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; there is one size, and no file.
    seeds : int
        Of the texture and of the converter's noise.
    """
    display = open_display(DISPLAY)
    settings = display.settings
    if not isinstance(settings, Settings):
        raise ParameterError(f"{DISPLAY} must be an ultrasonic display")
    rows = []
    for name in TRANSDUCERS:
        for plays in (True, False):
            away = np.array([_away(settings, display.rate, name, plays, seed) for seed in range(seeds)])
            rows.append(
                {
                    "transducer": name,
                    "q": PRESETS[name].q,
                    "carrier": "modulated by a texture" if plays else "steady",
                    "mean_hz": float(away.mean()),
                    "sd_hz": float(away.std()),
                    "max_hz": float(np.abs(away).max()),
                }
            )
    result: dict[str, Any] = {
        "section": "III-C",
        "simulated": True,
        "data": "simulated transducers and converter, noise around 140 Hz at full depth",
        "display": DISPLAY,
        "drift_hz_per_s": DRIFT_HZ_PER_S,
        "seconds": SECONDS,
        "every_s": EVERY_S,
        "steps_left_out": SETTLED,
        "seeds": seeds,
        "rows": rows,
    }
    heads = f"{'transducer':>12}{'Q':>6}{'carrier':>24}{'mean':>9}{'sd':>8}{'max':>8}"
    result["text"] = "\n".join(
        ["Carrier less resonance, Hz; simulated, nothing was measured on a device.", heads]
        + [
            f"{row['transducer']:>12}{row['q']:>6g}{row['carrier']:>24}{row['mean_hz']:>9.2f}{row['sd_hz']:>8.2f}"
            f"{row['max_hz']:>8.2f}"
            for row in rows
        ]
    )
    return result


def _away(settings: Settings, rate: float, name: str, plays: bool, seed: int) -> NDArray[np.float64]:
    """Return carrier minus resonance after each step, Hz, float64, shape (step,), once it has settled."""
    rng = np.random.default_rng(seed)
    device = SimulatedGenerator(
        BenchSettings(drift_hz_per_s=DRIFT_HZ_PER_S),
        gain=settings.amplifier_gain,
        transducer=PRESETS[name],
        rng=rng,
        waits=False,
    )
    tracking = CarrierTracking(settings, {}, serial="simulated", simulated=device)
    state, count, found = np.zeros(2), round(BLOCK_S * rate), []
    with tracking.generator():
        device.start(rate)
        for _ in range(round(SECONDS / EVERY_S)):
            for _ in range(round(EVERY_S / BLOCK_S)):
                x = np.zeros(count)
                if plays:
                    # Poles at 140 Hz for the display's 16 kHz.
                    x, state = dsp.lfilter([0.02], [1, -1.96, 0.9634], rng.standard_normal(count), zi=state)
                device.advance(settings.carrier_v * (1 + np.clip(x, -1, 1)))
            tracking.step(device)
            found.append(device.carrier_hz - device.transducer.resonance_hz)
    return np.array(found[SETTLED:])

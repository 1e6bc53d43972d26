"""Textures between two recorded speeds: modulated noise whose spectrum moves with the speed, beside what does not.

Of each everyday material a *simulated* stroke at 60 and one at 240 mm/s are fitted, and what is made for 120 mm/s is
compared with a stroke at 120 mm/s; the force is 1 N.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.experiments.one_stroke import SECONDS, distances, means, table
from tactogram.datasets.simulate import make, tasks
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.modulated_noise import ModulatedNoise
from tactogram.signal.modulated_noise_fit import fit_modulated_noise
from tactogram.signal.modulated_noise_synthesis import synthesise_modulated_noise
from tactogram.signal.synthesis import synthesise
from tactogram.signal.texture_map import NoiseMap, TextureMap
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import load_run

SLOW, BETWEEN, FAST = 60.0, 120.0, 240.0
FORCE_N = 1.0
SEED = 5


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    every: int = 1,
    drawings: int = 3,
) -> dict[str, Any]:
    """Return the mean distances to the stroke between, and how spectra move with the speed.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``folder`` and ``paper`` change nothing.
    every : int
        Every so many-th material.
    drawings : int
        Seeds of everything that is generated.
    """
    prepare = load_run("texture_flow").prepare_vibration
    materials = tasks("everyday", seed=SEED, per_class=1, seconds=SECONDS, own_images=False)[::every]
    rows, exponents = [], []
    for number, task in enumerate(materials, 1):
        slow, between, fast, again = (
            prepare(make(replace(task, speed_mm_s=speed, force_n=FORCE_N, take=take)).streams["acceleration"])
            for take, speed in enumerate((SLOW, BETWEEN, FAST, BETWEEN))
        )
        at = [[SLOW, FORCE_N], [FAST, FORCE_N]]
        noise = NoiseMap([fit_modulated_noise(stroke) for stroke in (slow, fast)], at)
        lines = TextureMap([fit_autoregressive(stroke) for stroke in (slow, fast)], at)
        made = {
            "another stroke at that speed": partial(_same, again),
            "ar_texture": partial(_of_lines, lines.at(BETWEEN, FORCE_N)),
            "texture_var": partial(_of_noise, noise.at(BETWEEN, FORCE_N)),
            "texture_var, spectra crossfaded": partial(_of_noise, noise.mix(noise.weights(BETWEEN, FORCE_N))),
        }
        rows.append(distances(made, [between], drawings))
        exponents.append(noise.exponent)
        progress("materials", number, len(materials))
    found = means(rows)
    quartiles = np.quantile(exponents, (0.25, 0.5, 0.75)).round(3).tolist()
    return {
        "simulated": True,
        "drawings": drawings,
        "distances": found,
        "exponent_quartiles": quartiles,
        "text": "\n".join([*table("to a stroke between", found), f"exponents, quartiles: {quartiles}"]),
    }


def _same(signal: Signal, seed: int) -> Signal:
    return signal


def _of_noise(model: ModulatedNoise, seed: int) -> Signal:
    return synthesise_modulated_noise(model, SECONDS, seed=seed)


def _of_lines(model: AutoregressiveModel, seed: int) -> Signal:
    return synthesise(model, SECONDS, seed=seed)

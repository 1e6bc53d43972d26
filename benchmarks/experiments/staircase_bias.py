"""Bias and spread of staircase thresholds, by length and by slope of the function: simulated observers.

Each takes one staircase of the shipped study `threshold` with so many reversals. Held against the truth: the fit that
decides (`estimate_threshold`), and the mean of reversals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from tactogram.errors import DataError
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.progress import ProgressCallback
from tactogram_study.analysis.threshold import SETTLED_3_DOWN, estimate_threshold, reversal_threshold
from tactogram_study.designs.staircase import Staircase, StaircaseTrack
from tactogram_study.simulated_observer import SimulatedEffect
from tactogram_study.study_file import Study

Numbers = NDArray[np.float64]
SPREADS_DB = (1.0, 2.0, 4.0, 8.0)
"""Sd of the cumulative normal; the simulated participants of studies have 4."""
LENGTHS: Mapping[int, int] = {6: 40, 8: 80, 12: 120, 16: 160}
"""Reversals, and the most trials."""
PLACE_DB, PLACE_SD_DB = -20.0, 3.0
HEADINGS = (
    "spread, dB",
    "reversals",
    "trials",
    "fit: bias",
    "sd",
    "covers",
    "reversals: bias",
    "sd",
)
NOTES = (
    "Simulated observers. bias in dB, ± its standard error: positive is too high. covers: share of the fits'",
    "intervals of 95 % that hold the truth. Fit and reversals are held against the level of .794 correct.",
)


def run(
    folder: Path, *, paper: bool, progress: ProgressCallback, observers: int = 500, seed: int = 0
) -> dict[str, Any]:
    """Return bias and spread for each length and slope.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; both recipes are one.
    observers : int
        Simulated, for each row.
    """
    shipped = Study.load("threshold").design
    rows = []
    for spread in SPREADS_DB:
        for reversals, most in LENGTHS.items():
            values = {**shipped.model_dump(), "reversals": reversals, "most_trials": most}
            rng = np.random.default_rng([seed, int(10 * spread), reversals])
            rows.append(_row(Staircase(**values), spread, observers, rng))
    lines = [
        "| " + " | ".join(cells) + " |" for cells in (HEADINGS, ["---"] * len(HEADINGS), *map(_cells, rows))
    ]
    text = "\n".join([*lines, "", *NOTES])
    write_text(folder / "staircase_bias.md", text + "\n")
    return {"simulated": True, "observers": observers, "seed": seed, "rows": rows, "text": text}


def _row(design: Staircase, spread: float, observers: int, rng: np.random.Generator) -> dict[str, Any]:
    errors: dict[str, list[float]] = {"fit": [], "mean_of_reversals": []}
    trials, covered = [], []
    lapse = SimulatedEffect().lapse
    for _ in range(observers):
        place = PLACE_DB + PLACE_SD_DB * rng.standard_normal()
        x, right, turned = staircase_of(design, place, spread, lapse, rng)
        trials.append(len(x))
        settled = place + spread * ndtri((SETTLED_3_DOWN - 0.5) / (0.5 - lapse))
        if (mean := reversal_threshold(x, turned.tolist())) is not None:
            errors["mean_of_reversals"].append(mean - settled)
        try:
            found = estimate_threshold(x, right)
        except DataError:
            continue
        errors["fit"].append(found.threshold - settled)
        covered.append(found.low <= settled <= found.high)
    return {
        "spread_db": spread,
        "reversals": design.reversals,
        "trials": float(np.mean(trials)),
        "covered": float(np.mean(covered)),
        **{name: _bias(values) for name, values in errors.items()},
    }


def staircase_of(
    design: Staircase, place: float, spread: float, lapse: float, rng: np.random.Generator
) -> tuple[Numbers, Numbers, NDArray[np.bool_]]:
    """Return intensities, answers (1 right) and reversals of a simulated observer, each of shape (trial,)."""
    track = StaircaseTrack(design.start_db)
    x, right, turned = [], [], []
    while not design.ended(track):
        sure = ndtr((track.intensity - place) / spread)
        correct = bool(rng.random() < 0.5 + (0.5 - lapse) * sure)
        after = design.after(track, correct=correct)
        x.append(track.intensity)
        right.append(float(correct))
        turned.append(len(after.reversals) > len(track.reversals))
        track = after
    return np.array(x), np.array(right), np.array(turned)


def _bias(errors: Sequence[float]) -> dict[str, float]:
    sd = float(np.std(errors, ddof=1))
    return {
        "bias": float(np.mean(errors)),
        "se": sd / float(np.sqrt(len(errors))),
        "sd": sd,
        "n": len(errors),
    }


def _cells(row: Mapping[str, Any]) -> list[str]:
    def bias(name: str) -> list[str]:
        return [f"{row[name]['bias']:+.2f} ± {row[name]['se']:.2f}", f"{row[name]['sd']:.1f}"]

    start = [f"{row['spread_db']:g}", str(row["reversals"]), f"{row['trials']:.0f}"]
    return [*start, *bias("fit"), f"{row['covered']:.3f}", *bias("mean_of_reversals")]

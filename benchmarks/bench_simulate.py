"""The simulator: seconds of signal per second of computing on one core, and how separable the simulated classes are.

Stick-slip included. Separability is the accuracy of a linear discriminant (shrinkage) on log band powers of 200-sample
windows, trained on two takes of 30 s and tested on the third; of simulated data, so it says that the classes are not
trivial, not how real ones are.
"""

import time
from itertools import pairwise

import numpy as np
from scipy.signal import periodogram
from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

from tactogram_simulate import make, tasks

WINDOW = 200


def run():
    return [*speed(), *separability()]


def speed():
    rows = []
    for rate in (330.0, 1000.0, 6000.0, 10_000.0):
        todo = tasks("stroking9", seed=0, per_class=2, seconds=60, rate=rate)
        make(todo[0])  # compiles, and makes the height field
        start = time.perf_counter()
        for task in todo[:2]:
            make(task)
        rows.append(
            {
                "what": f"3 axes at {rate:g} Hz",
                "seconds of signal per second": 120 / (time.perf_counter() - start),
            }
        )
    return rows


def separability():
    rows = []
    for name, speed_mm_s in (
        ("stroking30", 100),
        ("stroking30", 200),
        ("stroking30", 400),
        ("stroking9", 100),
    ):
        features, classes, takes = [], [], []
        takes_per_class = 3 if name == "stroking30" else 6
        seconds = 30 if name == "stroking30" else 4
        for task in tasks(name, seed=0, per_class=takes_per_class, seconds=seconds):
            if task.speed_mm_s != speed_mm_s:
                continue
            recording = make(task)
            rows_of_it = log_bands(recording.streams["acceleration"])
            features.append(rows_of_it)
            classes += [f"{task.surface}-{task.contactor}"] * len(rows_of_it)
            takes += [task.take] * len(rows_of_it)
        x, y, take = np.concatenate(features), np.array(classes), np.array(takes)
        last = take > takes_per_class * 2 / 3
        judge = LinearDiscriminantAnalysis(solver="lsqr", shrinkage="auto").fit(x[~last], y[~last])
        rows.append(
            {
                "what": f"{name} at {speed_mm_s} mm/s, simulated",
                "classes": len(set(classes)),
                "linear discriminant, windows": float(np.mean(judge.predict(x[last]) == y[last])),
            }
        )
    return rows


def log_bands(signal, bands=16):
    """Return the log power in bands of each window and axis, shape (window, axis * band)."""
    n = len(signal) // WINDOW
    windows = signal.samples[:, : n * WINDOW].reshape(len(signal.axes), n, WINDOW)
    _, power = periodogram(windows, signal.rate, "hann", axis=-1)
    edges = np.linspace(1, power.shape[-1], bands + 1).astype(int)
    binned = np.stack([power[..., a:b].mean(-1) for a, b in pairwise(edges)], -1)
    return np.log(binned + 1e-9).transpose(1, 0, 2).reshape(n, -1)
